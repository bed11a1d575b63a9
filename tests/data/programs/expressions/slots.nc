(A plate with two slots and a boss, sized by its parameters)
#<length> = 40. #<width> = 12.
#<depth> = 3.
#<feed> = 600
#100 = 2 (slots)
#[100 + 1] = [#<length> / #100]
G21 G17 G90 G94
T#100 M[2*3]
S[1000 * EXP[0]] M3
G0 Z[#<depth> + 2] X-#101 Y-[#<width> / 2]
G1 Z-#<depth> F[#<feed> / 4]
X#101 F#<feed>
Y[#<width> / 2]
X[-#101]
Y-[#<width> / 2]
#<depth> = [#<depth> * 2] Z-#<depth>
Z-#<depth>
G0 Z5
X[10 * COS[30]] Y[10 * SIN[30]]
G1 Z-1
G3 X[10 * COS[150]] Y[10 * sin[150]] I[-10 * COS[30]] J[-10 * SIN[30]]
G2 X-#101 Y0 R[SQRT[[#101 - 10 * COS[30]] ** 2 + 25]]
G4 P[1 / 2]
G0 Z5
M30
