(lower case, white space, signs and points as people write them)
g0 x 1 0 y+.5z-0.
g 1 x20.y0.5 f 6 0 0
n30x2
*71
n40 y-.5 *12
