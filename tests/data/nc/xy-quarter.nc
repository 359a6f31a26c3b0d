%
(XY_QUARTER)
(machine Hermle C600U)
(ball bar 100 mm, 500 mm/min at the ball)
(gauge length 110.000 mm from spindle nose to ball, tool length off)
(positions in work coordinates with zero at the zero of the machine file)
(work offset that must be active, from machine_zero: C 0.0000 A -0.5000 Y -410.0000 X 312.5000 Z 96.1250)
(G69 ends turned coordinates: take it out where the control has no such word)
(G4 X is a dwell in seconds, change it where the control wants P)
(F of a block with C or A alone is deg/min)
M5
M9
G69
G17 G21 G40 G49 G90 G94
G64
(pivot on table top ball 135.000 mm above it)
(pivot ball at x 0.000 y 0.000 z 60.000 with all axes at zero)
(bring the axes to park by hand: Z 329.000 C 0.000 A 0.000 Y 0.000 X 0.000)
(at park, pivot and spindle cup mounted, bar off)
M0
G0 Z329.0000
G0 C0.0000
G0 A0.0000
G0 Y0.0000
G0 X0.0000
G0 X100.0000
G0 Y-4.0000
G0 Z60.0000
(mount the bar and start the recording)
M0
(xy-quarter-ccw capture 0 to 90)
G4 X3.0
G93
G1 Y0.0000 X100.0000 Z60.0000 C0.0000 A0.0000 F124.998
G94 F500
G17 G91
G3 X-100.0000 Y100.0000 I-100.0000 J0.0000 F500.000
G17 G90
G93
G1 Y100.0175 X-4.0000 Z60.0000 C0.0000 A0.0000 F124.998
G4 X3.0
(xy-quarter-cw capture 90 to 0)
G4 X3.0
G1 Y100.0000 X0.0000 Z60.0000 C0.0000 A0.0000 F124.998
G94 F500
G17 G91
G2 X100.0000 Y-100.0000 I0.0000 J-100.0000 F500.000
G17 G90
G93
G1 Y-4.0000 X100.0175 Z60.0000 C0.0000 A0.0000 F124.998
G4 X3.0
(stop the recording and take the bar off)
M0
G94 F500
G0 Z329.0000
G0 Y0.0000
G0 X0.0000
(no word of ISO 6983 tells the modes found: left as here)
G17 G21 G40 G49 G90 G94
M30
%
