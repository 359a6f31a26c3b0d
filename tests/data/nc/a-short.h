0 BEGIN PGM A_SHORT MM
1 ; machine Hermle C600U
2 ; ball bar 100 mm, 500 mm/min at the ball
3 ; gauge length 110.000 mm from spindle nose to ball, tool length off
4 ; positions in machine coordinates, machine_zero C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250
5 M129
6 M127
7 M5
8 M9
9 ; pivot on table top ball 75.000 mm above it
10 ; pivot ball at x 0.000 y -100.000 z 0.000 with all axes at zero
11 ; bring the axes to park by hand: Z 425.125 C 0.000 A -0.500 Y -410.000 X 312.500
12 ; at park, pivot and spindle cup mounted, bar off
13 STOP M0
14 L Z+425.1250 R0 FMAX M91
15 L C+0.0000 R0 FMAX M91
16 L A-0.5000 R0 FMAX M91
17 L Y-410.0000 R0 FMAX M91
18 L X+312.5000 R0 FMAX M91
19 L A-24.5000 R0 FMAX M91
20 L Z+96.1250 R0 FMAX M91
21 ; mount the bar and start the recording
22 STOP M0
23 ; a-short-ccw capture -20 to 70
24 L A-24.5000 R0 F572.957 M91
25 CYCL DEF 9.0 DWELL TIME
26 CYCL DEF 9.1 DWELL 3.0
27 L A-20.5000 R0 F286.478 M91
28 L A+69.5000 R0 F286.478 M91
29 L A+73.5000 R0 F286.478 M91
30 CYCL DEF 9.0 DWELL TIME
31 CYCL DEF 9.1 DWELL 3.0
32 ; a-short-cw capture 70 to -20
33 L A+73.5000 R0 F572.957 M91
34 CYCL DEF 9.0 DWELL TIME
35 CYCL DEF 9.1 DWELL 3.0
36 L A+69.5000 R0 F286.478 M91
37 L A-20.5000 R0 F286.478 M91
38 L A-24.5000 R0 F286.478 M91
39 CYCL DEF 9.0 DWELL TIME
40 CYCL DEF 9.1 DWELL 3.0
41 ; stop the recording and take the bar off
42 STOP M0
43 L Z+425.1250 R0 FMAX M91
44 L A-0.5000 R0 FMAX M91
45 END PGM A_SHORT MM
