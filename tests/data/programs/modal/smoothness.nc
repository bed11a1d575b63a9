%
O0187 (Tolerances by levels and words of their own)
G20 G17 G90 G64
G187 P1 E0.02
G0 X0 Y0
G1 F40. X1.
G61
Y1.
G64
X0.
G187 P3
Y0.
G187 P4
X1.
G187 E0.
X2.
G187
X3.
G5.1 Q1 R5
X4.
G5.1 Q0
X5.
G05 P10000
X6.
G05 P0
G08 P1
X7.
G05.1 X8. Y1. I1. J1. (a spline of another control)
G5.1 Q1 R11
M30
%
