0 BEGIN PGM XY_QUARTER MM
1 ; machine Hermle C600U
2 ; ball bar 100 mm, 500 mm/min at the ball
3 ; gauge length 110.000 mm from spindle nose to ball
4 ; a tool of length 0 must be active: call it before the cup is mounted
5 ; positions in machine coordinates, machine_zero C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250
6 M129
7 M127
8 M5
9 M9
10 ; pivot on table top ball 135.000 mm above it
11 ; pivot ball at x 0.000 y 0.000 z 60.000 with all axes at zero
12 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500
13 ; at park, pivot and spindle cup mounted, bar off
14 STOP M0
15 L Z+425.1250 R0 FMAX M91
16 L C+0.0000 R0 FMAX M91
17 L A-0.5000 R0 FMAX M91
18 L Y-410.0000 R0 FMAX M91
19 L X+312.5000 R0 FMAX M91
20 L X+412.5000 R0 FMAX M91
21 L Y-414.0000 R0 FMAX M91
22 L Z+156.1250 R0 FMAX M91
23 ; mount the bar and start the recording
24 STOP M0
25 ; xy-quarter-ccw capture 0 to 90
26 CYCL DEF 9.0 DWELL TIME
27 CYCL DEF 9.1 DWELL 3.0
28 L Y-410.0000 X+412.5000 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
29 CC IX-100.0000 IY+0.0000
30 C IX-100.0000 IY+100.0000 DR+ R0 F500.000
31 L Y-309.9825 X+308.5000 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
32 CYCL DEF 9.0 DWELL TIME
33 CYCL DEF 9.1 DWELL 3.0
34 ; xy-quarter-cw capture 90 to 0
35 CYCL DEF 9.0 DWELL TIME
36 CYCL DEF 9.1 DWELL 3.0
37 L Y-310.0000 X+312.5000 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
38 CC IX+0.0000 IY-100.0000
39 C IX+100.0000 IY-100.0000 DR- R0 F500.000
40 L Y-414.0000 X+412.5175 Z+156.1250 C+0.0000 A-0.5000 R0 FT0.481 M91
41 CYCL DEF 9.0 DWELL TIME
42 CYCL DEF 9.1 DWELL 3.0
43 ; stop the recording and take the bar off
44 STOP M0
45 L Z+425.1250 R0 FMAX M91
46 L Y-410.0000 R0 FMAX M91
47 L X+312.5000 R0 FMAX M91
48 END PGM XY_QUARTER MM
