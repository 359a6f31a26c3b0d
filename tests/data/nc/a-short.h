0 BEGIN PGM A_SHORT MM
1 ; machine Hermle C600U
2 ; ball bar 100 mm, 500 mm/min at the ball
3 ; gauge length 110.000 mm from spindle nose to ball
4 ; a tool of length 0 must be active: call it before the cup is mounted
5 ; positions in machine coordinates, machine_zero C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250
6 M129
7 M127
8 M5
9 M9
10 ; pivot on table top ball 75.000 mm above it
11 ; pivot ball at x 0.000 y -100.000 z 0.000 with all axes at zero
12 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500
13 ; at park, pivot and spindle cup mounted, bar off
14 STOP M0
15 L Z+425.1250 R0 FMAX M91
16 L C+0.0000 R0 FMAX M91
17 L A-0.5000 R0 FMAX M91
18 L Y-410.0000 R0 FMAX M91
19 L X+312.5000 R0 FMAX M91
20 L A-24.5000 R0 FMAX M91
21 L Z+96.1250 R0 FMAX M91
22 ; mount the bar and start the recording
23 STOP M0
24 ; a-short-ccw capture -20 to 70
25 L A-24.5000 R0 F572.957 M91
26 CYCL DEF 9.0 DWELL TIME
27 CYCL DEF 9.1 DWELL 3.0
28 L A-20.5000 R0 F286.478 M91
29 L A+69.5000 R0 F286.478 M91
30 L A+73.5000 R0 F286.478 M91
31 CYCL DEF 9.0 DWELL TIME
32 CYCL DEF 9.1 DWELL 3.0
33 ; a-short-cw capture 70 to -20
34 L A+73.5000 R0 F572.957 M91
35 CYCL DEF 9.0 DWELL TIME
36 CYCL DEF 9.1 DWELL 3.0
37 L A+69.5000 R0 F286.478 M91
38 L A-20.5000 R0 F286.478 M91
39 L A-24.5000 R0 F286.478 M91
40 CYCL DEF 9.0 DWELL TIME
41 CYCL DEF 9.1 DWELL 3.0
42 ; stop the recording and take the bar off
43 STOP M0
44 L Z+425.1250 R0 FMAX M91
45 L A-0.5000 R0 FMAX M91
46 END PGM A_SHORT MM
