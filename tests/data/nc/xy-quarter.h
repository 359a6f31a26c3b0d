0 BEGIN PGM XY_QUARTER MM
1 ; machine Hermle C600U
2 ; ball bar 100 mm, 500 mm/min at the ball
3 ; gauge length 110.000 mm from spindle nose to ball
4 ; a tool of length 0 must be active: call it before the cup is mounted
5 ; positions in machine coordinates, machine_zero C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250
6 ; turned coordinates are switched off, a basic rotation of the offset must be zero
7 M129
8 M127
9 M5
10 M9
11 PLANE RESET STAY
12 CYCL DEF 10.0 ROTATION
13 CYCL DEF 10.1 ROT+0
14 ; pivot on table top ball 135.000 mm above it
15 ; pivot ball at x 0.000 y 0.000 z 60.000 with all axes at zero
16 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500
17 ; at park, pivot and spindle cup mounted, bar off
18 STOP M0
19 L Z+425.1250 R0 FMAX M91
20 L C+0.0000 R0 FMAX M91
21 L A-0.5000 R0 FMAX M91
22 L Y-410.0000 R0 FMAX M91
23 L X+312.5000 R0 FMAX M91
24 L X+412.5000 R0 FMAX M91
25 L Y-414.0000 R0 FMAX M91
26 L Z+156.1250 R0 FMAX M91
27 ; mount the bar and start the recording
28 STOP M0
29 ; xy-quarter-ccw capture 0 to 90
30 CYCL DEF 9.0 DWELL TIME
31 CYCL DEF 9.1 DWELL 3.0
32 L Y-410.0000 X+412.5000 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
33 CC IX-100.0000 IY+0.0000
34 C IX-100.0000 IY+100.0000 DR+ R0 F500.000
35 L Y-309.9825 X+308.5000 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
36 CYCL DEF 9.0 DWELL TIME
37 CYCL DEF 9.1 DWELL 3.0
38 ; xy-quarter-cw capture 90 to 0
39 CYCL DEF 9.0 DWELL TIME
40 CYCL DEF 9.1 DWELL 3.0
41 L Y-310.0000 X+312.5000 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
42 CC IX+0.0000 IY-100.0000
43 C IX+100.0000 IY-100.0000 DR- R0 F500.000
44 L Y-414.0000 X+412.5175 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
45 CYCL DEF 9.0 DWELL TIME
46 CYCL DEF 9.1 DWELL 3.0
47 ; stop the recording and take the bar off
48 STOP M0
49 L Z+425.1250 R0 FMAX M91
50 L Y-410.0000 R0 FMAX M91
51 L X+312.5000 R0 FMAX M91
52 END PGM XY_QUARTER MM
