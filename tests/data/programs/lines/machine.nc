(reference moves with unknown reference points, two work offsets)
G0 G54 X10 Y20 Z5
G91 G28 Z0
G90 G53 G0 X-100
G55 X0 Y0
G28 X5
M30
