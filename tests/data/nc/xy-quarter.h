0 BEGIN PGM XY_QUARTER MM
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
18 ; pivot on table top ball 135.000 mm above it
19 ; pivot ball at x 0.000 y 0.000 z 60.000 with all axes at zero
20 ; place the pivot: at C 0 A -0.5 jog to X 412.5 Y -414 Z 156.125, setting ball of the spindle in the pivot cup, lock the magnet, within 0.06 mm, 3 sigma of the 20 um that the session counts on
21 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500, the program then goes there itself
22 ; at park, pivot and spindle cup mounted, bar off
23 STOP M0
24 L Z+425.1250 R0 FMAX M91
25 L C+0.0000 R0 FMAX M91
26 L A-0.5000 R0 FMAX M91
27 L Y-410.0000 R0 FMAX M91
28 L X+312.5000 R0 FMAX M91
29 L X+412.4200 R0 FMAX M91
30 L Y-413.9989 R0 FMAX M91
31 L Z+332.6563 R0 FMAX M91
32 ; near the cups, next Z to 156.125 at feed, hand on the feed hold
33 STOP M0
34 L Z+156.1250 R0 F1000.000 M91
35 ; mount the bar and start the recording
36 STOP M0
37 ; xy-quarter-ccw capture 0 to 90
38 CYCL DEF 9.0 DWELL TIME
39 CYCL DEF 9.1 DWELL 3.0
40 CC IX-99.9200 IY+3.9989
41 C IX-103.9189 IY+103.9189 DR+ R0 F500.000
42 CYCL DEF 9.0 DWELL TIME
43 CYCL DEF 9.1 DWELL 3.0
44 ; xy-quarter-cw capture 90 to 0
45 CYCL DEF 9.0 DWELL TIME
46 CYCL DEF 9.1 DWELL 3.0
47 CC IX+3.9989 IY-99.9200
48 C IX+103.9189 IY-103.9189 DR- R0 F500.000
49 CYCL DEF 9.0 DWELL TIME
50 CYCL DEF 9.1 DWELL 3.0
51 ; stop the recording and take the bar off
52 STOP M0
53 L Z+332.6563 R0 F1000.000 M91
54 L Z+425.1250 R0 FMAX M91
55 L Y-410.0000 R0 FMAX M91
56 L X+312.5000 R0 FMAX M91
57 END PGM XY_QUARTER MM
