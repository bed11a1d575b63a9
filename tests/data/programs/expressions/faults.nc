%
O9000 (a macro called without its arguments)
#1=#1(START Z)
#4=#7/2.(R.)
G0 X#24 Y#25
G1 Z##4 F500
#5=10
G1 X#5 F[6*100]
X[#5 / [#5 - 10]]
Y[SQRT[5 - #5]]
X[EXP[#5 * 100]]
#6=1 X#7
X#6
X#[#5 / 4]
X[#5 + ]
X[#5 * [2 + 1]
X[#5 & 2]
X[SQR[4]]
X#<half the
#5 X1
X#5 + 1
IF[#5EQ10]GOTO1
WHILE[#5GT0]DO1
#5=#5-1
END1
X#5
M99
%
