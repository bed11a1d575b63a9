(A plate outside, then a pocket inside; both with a cutter of 10 mm)
G21 G90 G17 G94
T1 M6
S8000 M3
G0 X-20 Y-20 Z5
G1 Z-2 F500
(outside, tool on the left: clockwise)
G41.1 D10
G1 X0 Y-10 F1200
Y50
G2 X10 Y60 I10
G1 X80
G4 P0.5
X90 Y50
M8
Y0
X-10
G40
G1 X-20 Y-20
G0 Z5
(inside, tool on the left: counter-clockwise)
G0 X45 Y30
G1 Z-4 F300
G41.1 D10
G1 X45 Y10 F1200
X80
G9 Y40
G3 X70 Y50 I-10
G1 X20
X10 Y40
Y10
X45
G1 Z-6
X50
G40 X45 Y30
G0 Z50
M30
