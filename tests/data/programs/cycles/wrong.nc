(what a control would stop at: no hole is made, and each block says why)
G0 X0 Y0 Z10
G99 G81 X10 Z-5 F100
G82 X10 R2 P1
G81 X10 Z3 R2
G83 X10 Z-5 R2
G83 X10 Z-5 R2 Q0
G73 X10 Z-5 R2 Q-1
G87 X10 Z-5 R2 I1 J1
G76 P1 X10 Z-5 R2 I1 J1 K1
(made, but not as written)
G82 X20 Z-1 R2
G82 X30 Z-1 R2 P-4
G83 X40 Z-1 R2 Q0.0001
G81 X50 Z-1 R2 L-1
G84 X60 Z-1 R2 Q1
G88 X70 Z-1 R2 P0
G80
G0 Z10
