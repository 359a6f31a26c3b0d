0 BEGIN PGM A_SHORT MM
1 ; machine Hermle C600U
2 ; assumed: travels are the figures commonly quoted, no maker's data sheet was at hand, where zero lies within the Z travel is assumed
3 ; assumed: C turns without end on the machine, +-360 deg is a limit for programs
4 ; assumed: bodies are round values of the class, no maker's drawing was at hand, compare every clearance with your machine
5 ; tests a-short-ccw and a-short-cw
6 ; ball bar 100 mm, 500 mm/min at the ball
7 ; gauge length 110.000 mm from spindle nose to ball, known within 0.009 mm
8 ; a tool of length 0 must be active: call it before the cup is mounted
9 ; positions in machine coordinates, machine_zero C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250
10 ; turned coordinates are switched off, a basic rotation of the offset must be zero
11 ; sense of axes: iso841, a positive command moves the tool in the positive sense relative to the workpiece
12 M129
13 M127
14 M5
15 M9
16 PLANE RESET STAY
17 CYCL DEF 10.0 ROTATION
18 CYCL DEF 10.1 ROT+0
19 ; pivot on table top ball 75.000 mm above it
20 ; pivot ball at x 0.000 y -100.000 z 0.000 with all axes at zero
21 ; place the pivot: at C 0 A -0.5 jog to X 412.5 Y -414 Z 156.125, setting ball of the spindle in the pivot cup, lock the magnet, within 0.06 mm, 3 sigma of the 20 um that the session counts on
22 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500, the program then goes there itself
23 ; at park, pivot and spindle cup mounted, bar off
24 STOP M0
25 L Z+425.1250 R0 FMAX M91
26 L C+0.0000 R0 FMAX M91
27 L A-0.5000 R0 FMAX M91
28 L Y-410.0000 R0 FMAX M91
29 L X+312.5000 R0 FMAX M91
30 L A-24.5000 R0 FMAX M91
31 L Z+234.9219 R0 FMAX M91
32 ; near the cups, next Z to 96.125 at feed, hand on the feed hold
33 STOP M0
34 L Z+96.1250 R0 F1000.000 M91
35 ; mount the bar and start the recording
36 STOP M0
37 ; a-short-ccw capture -20 to 70
38 CYCL DEF 9.0 DWELL TIME
39 CYCL DEF 9.1 DWELL 3.0
40 L A+73.5000 R0 F286.478 M91
41 CYCL DEF 9.0 DWELL TIME
42 CYCL DEF 9.1 DWELL 3.0
43 ; a-short-cw capture 70 to -20
44 CYCL DEF 9.0 DWELL TIME
45 CYCL DEF 9.1 DWELL 3.0
46 L A-24.5000 R0 F286.478 M91
47 CYCL DEF 9.0 DWELL TIME
48 CYCL DEF 9.1 DWELL 3.0
49 ; stop the recording and take the bar off
50 STOP M0
51 L Z+234.9219 R0 F1000.000 M91
52 L Z+425.1250 R0 FMAX M91
53 L A-0.5000 R0 FMAX M91
54 END PGM A_SHORT MM
