$PART.MIN%
(work offset by G15 H, tool length by G56 H; G54 to G59 are no work offsets here)
N1 G15 H1
N2 G0 X100. Y50. Z100.
N3 T1 M6
N4 G56 H1 Z50. S1500 M3
N5 G4 F2
(one block in the coordinates of offset 0)
N6 G16 H0 Z60.
(return level 20: three holes, down and up again 20 to -10, and one place without hole)
N7 G71 Z20.
N8 G81 X10. Y10. Z-10. R2. F200 M53
N9 X20.
N10 NCYL X30.
N11 X40. M54
N12 G80
(chips broken every 3 mm; J is said)
N13 G83 X0 Y0 Z-9. R0. I3. J6. F100 M53
N14 G80
N15 G85 X5. Z-5. R1. F100 FA=400 M53
N16 G80 G53
(variables, jumps and subprograms)
N17 VC1=0
NLOOP VC1=VC1+1
N18 G0 X=VC1*10
N19 IF [VC1 LT 3] NLOOP
N20 CALL O100 Q2
N21 GOTO N23
N22 G0 X999.
N23 VZOFX[1]=5
N24 G0 Y=VZOFX[2]
N25 MODIN O100
N26 G11 X10. Y10. P30
N27 G68 X10. Y10. I0 J0 K1 R90
N28 M2
O100
G91 G0 X1.
G90
RTS
