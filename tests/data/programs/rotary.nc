(ROTARY AXES)
G21 G90 G94
G0 X0 A0 B0
(Alone: 90 degrees at 360 degrees per minute, 15 s)
G1 A90 F360
(In rapid, two at once)
G0 A0 B180
(Along with a move)
G1 X10 A30 F600
G2 X20 Y10 I0 J10 C45
(In increments and with a position named)
G91 A10
G90
G92 A0
A20
G92.1
(Inverse time: 30 s)
G93 G1 A0 F2
G94
(As written, not the shortest way)
G0 C405
C45
(To the reference point)
G28 A0 B0 C0
G53 C10
(With a cycle: turn, then the hole)
G81 Z-5 R2 F100 A90
A180
G80
G0 A999999999
M30
