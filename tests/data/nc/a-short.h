0 BEGIN PGM A_SHORT MM
1 ; machine Hermle C600U
2 ; assumed: travels are the figures commonly quoted, no maker's data sheet was at hand, where zero lies within the Z travel is assumed
3 ; assumed: C turns without end on the machine, +-360 deg is a limit for programs
4 ; assumed: bodies are round values of the class, no maker's drawing was at hand, compare every clearance with your machine
5 ; ball bar 100 mm, 500 mm/min at the ball
6 ; gauge length 110.000 mm from spindle nose to ball, known within 0.009 mm
7 ; a tool of length 0 must be active: call it before the cup is mounted
8 ; positions in machine coordinates, machine_zero C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250
9 ; turned coordinates are switched off, a basic rotation of the offset must be zero
10 ; sense of axes: iso841, a positive command moves the tool in the positive sense relative to the workpiece
11 M129
12 M127
13 M5
14 M9
15 PLANE RESET STAY
16 CYCL DEF 10.0 ROTATION
17 CYCL DEF 10.1 ROT+0
18 ; pivot on table top ball 75.000 mm above it
19 ; pivot ball at x 0.000 y -100.000 z 0.000 with all axes at zero
20 ; place the pivot: at C 0 A -0.5 jog to X 412.5 Y -414 Z 156.125, setting ball of the spindle in the pivot cup, lock the magnet, within 0.06 mm, 3 sigma of the 20 um that the session counts on
21 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500, the program then goes there itself
22 ; at park, pivot and spindle cup mounted, bar off
23 STOP M0
24 L Z+425.1250 R0 FMAX M91
25 L C+0.0000 R0 FMAX M91
26 L A-0.5000 R0 FMAX M91
27 L Y-410.0000 R0 FMAX M91
28 L X+312.5000 R0 FMAX M91
29 L A-24.5000 R0 FMAX M91
30 L Z+234.9219 R0 FMAX M91
31 ; near the cups, next Z to 96.125 at feed, hand on the feed hold
32 STOP M0
33 L Z+96.1250 R0 F1000.000 M91
34 ; mount the bar and start the recording
35 STOP M0
36 ; a-short-ccw capture -20 to 70
37 CYCL DEF 9.0 DWELL TIME
38 CYCL DEF 9.1 DWELL 3.0
39 L A+73.5000 R0 F286.478 M91
40 CYCL DEF 9.0 DWELL TIME
41 CYCL DEF 9.1 DWELL 3.0
42 ; a-short-cw capture 70 to -20
43 CYCL DEF 9.0 DWELL TIME
44 CYCL DEF 9.1 DWELL 3.0
45 L A-24.5000 R0 F286.478 M91
46 CYCL DEF 9.0 DWELL TIME
47 CYCL DEF 9.1 DWELL 3.0
48 ; stop the recording and take the bar off
49 STOP M0
50 L Z+234.9219 R0 F1000.000 M91
51 L Z+425.1250 R0 FMAX M91
52 L A-0.5000 R0 FMAX M91
53 END PGM A_SHORT MM
