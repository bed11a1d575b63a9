(radius 10: half, full, helix of one turn, three turns, by I and J)
G17 G21 G90 F600
G1 X10 Y0
G3 X-10 Y0 I-10 J0
G3 I10
G2 X-10 Z-3 I10
G3 X-10 Z0 I10 P3
