0 BEGIN PGM A_SHORT MM
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
14 ; pivot on table top ball 75.000 mm above it
15 ; pivot ball at x 0.000 y -100.000 z 0.000 with all axes at zero
16 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500
17 ; at park, pivot and spindle cup mounted, bar off
18 STOP M0
19 L Z+425.1250 R0 FMAX M91
20 L C+0.0000 R0 FMAX M91
21 L A-0.5000 R0 FMAX M91
22 L Y-410.0000 R0 FMAX M91
23 L X+312.5000 R0 FMAX M91
24 L A-24.5000 R0 FMAX M91
25 L Z+96.1250 R0 FMAX M91
26 ; mount the bar and start the recording
27 STOP M0
28 ; a-short-ccw capture -20 to 70
29 L A-24.5000 R0 F572.957 M91
30 CYCL DEF 9.0 DWELL TIME
31 CYCL DEF 9.1 DWELL 3.0
32 L A-20.5000 R0 F286.478 M91
33 L A+69.5000 R0 F286.478 M91
34 L A+73.5000 R0 F286.478 M91
35 CYCL DEF 9.0 DWELL TIME
36 CYCL DEF 9.1 DWELL 3.0
37 ; a-short-cw capture 70 to -20
38 L A+73.5000 R0 F572.957 M91
39 CYCL DEF 9.0 DWELL TIME
40 CYCL DEF 9.1 DWELL 3.0
41 L A+69.5000 R0 F286.478 M91
42 L A-20.5000 R0 F286.478 M91
43 L A-24.5000 R0 F286.478 M91
44 CYCL DEF 9.0 DWELL TIME
45 CYCL DEF 9.1 DWELL 3.0
46 ; stop the recording and take the bar off
47 STOP M0
48 L Z+425.1250 R0 FMAX M91
49 L A-0.5000 R0 FMAX M91
50 END PGM A_SHORT MM
