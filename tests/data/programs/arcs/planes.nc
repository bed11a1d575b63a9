(a quarter of radius 10 in each plane, G3 seen against the normal)
F600
G17 G3 X-10 Y10 I-10 J0
G0 X0 Y0 Z0
G18 G3 Z-10 X10 K-10 I0
G0 X0 Y0 Z0
G19 G3 Y-10 Z10 J-10 K0
G0 X0 Y0 Z0
G90.1
G17 G3 X-10 Y10 I-10 J0
