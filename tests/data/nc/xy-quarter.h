0 BEGIN PGM XY_QUARTER MM
1 ; machine Hermle C600U
2 ; assumed: travels are the figures commonly quoted, no maker's data sheet was at hand, where zero lies within the Z travel is assumed
3 ; assumed: C turns without end on the machine, +-360 deg is a limit for programs
4 ; assumed: bodies are round values of the class, no maker's drawing was at hand, compare every clearance with your machine
5 ; tests xy-quarter-ccw and xy-quarter-cw
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
19 ; pivot on table top ball 135.000 mm above it
20 ; pivot ball at x 0.000 y 0.000 z 60.000 with all axes at zero
21 ; place the pivot: at C 0 A -0.5 jog to X 412.5 Y -414 Z 156.125, setting ball of the spindle in the pivot cup, lock the magnet, within 0.06 mm, 3 sigma of the 20 um that the session counts on
22 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500, the program then goes there itself
23 ; at park, pivot and spindle cup mounted, bar off
24 STOP M0
25 L Z+425.1250 R0 FMAX M91
26 L C+0.0000 R0 FMAX M91
27 L A-0.5000 R0 FMAX M91
28 L Y-410.0000 R0 FMAX M91
29 L X+312.5000 R0 FMAX M91
30 L X+412.4200 R0 FMAX M91
31 L Y-413.9989 R0 FMAX M91
32 L Z+332.6563 R0 FMAX M91
33 ; near the cups, next Z to 156.125 at feed, hand on the feed hold
34 STOP M0
35 L Z+156.1250 R0 F1000.000 M91
36 ; mount the bar and start the recording
37 STOP M0
38 ; xy-quarter-ccw capture 0 to 90
39 CYCL DEF 9.0 DWELL TIME
40 CYCL DEF 9.1 DWELL 3.0
41 CC IX-99.9200 IY+3.9989
42 C IX-103.9189 IY+103.9189 DR+ R0 F500.000
43 CYCL DEF 9.0 DWELL TIME
44 CYCL DEF 9.1 DWELL 3.0
45 ; xy-quarter-cw capture 90 to 0
46 CYCL DEF 9.0 DWELL TIME
47 CYCL DEF 9.1 DWELL 3.0
48 CC IX+3.9989 IY-99.9200
49 C IX+103.9189 IY-103.9189 DR- R0 F500.000
50 CYCL DEF 9.0 DWELL TIME
51 CYCL DEF 9.1 DWELL 3.0
52 ; stop the recording and take the bar off
53 STOP M0
54 L Z+332.6563 R0 F1000.000 M91
55 L Z+425.1250 R0 FMAX M91
56 L Y-410.0000 R0 FMAX M91
57 L X+312.5000 R0 FMAX M91
58 END PGM XY_QUARTER MM
