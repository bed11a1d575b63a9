%
:9999 (odd)
n5 g90g21g17g40g80g94 (lower case (with) parens)
n30g0x0y0s3000m3
n20g43h1z5.m8
n40 g1 z-1. f100
/n50 x10. f500
/1 n60 y10.
n70 x 0 . 
N10 G00
N11 X50.
N12 G01
N13 F250
N14 Y50. (trailing
/M1
;semicolon comment
N15 G0 Z5. M5 M9
M30
%
this is after the end
