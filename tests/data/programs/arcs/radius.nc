(quarter and three quarters of radius 10, then a radius at its limit)
G1 X10 Y0 F600
G3 X0 Y10 R10
G3 X10 Y0 R-10
G2 X-10 Y0 R9.9999
