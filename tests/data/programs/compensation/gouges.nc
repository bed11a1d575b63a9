(What does not fit, and what is not known)
G90 G17 F600
G41 D12
G1 X10 Y0
X20
G40
G0 X0 Y0
G42 D1.5
G1 X10
G40
(the lead-in is shorter than the radius)
G41.1 D10
X12
X60
(a step smaller than the tool)
Y1
X50 Y31
Y60
(an inner arc smaller than the tool)
X20
G3 X18 Y58 J-2
G1 Y10
G40
(no arc can end compensation)
G2 X20 Y8 I2
G0 Z10
M30
