(the tool stays where it is when G92 or G52 renames the place)
G0 X10 Y10
G92 X0 Y0
G1 X10 F600
G92.2
G1 X0
G92.3
G1 X0
G92.1
G52 X5
G1 X0
G52 X0
G1 X0
