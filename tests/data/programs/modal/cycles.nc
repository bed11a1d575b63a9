(increments after an absolute hole: R and Z turn into increments)
G0 X0 Y0 Z10
G99 G81 X10 Y0 Z-5 R2 F100
X20
X30
G83 X40 Z-9 R2 Q1
G91 X10 L3
G80
G90 G1 X0 F600
G84 Z-5 R2 F1
G0 X5
