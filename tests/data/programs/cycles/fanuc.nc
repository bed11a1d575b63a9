%
O100 (feed 122 mm in 55.92 s, rapid 595.5902 mm, 3 dwells of 0.5 s)
G21 G17 G90 G40 G80
M3 S1000
G0 X0. Y0. Z50.
G43 H1 Z20.
(10 + 18 rapid, 12 feed, 12 rapid)
G99 G81 X10. Y0. Z-10. R2. F100.
(10 rapid, 12 feed, 12 rapid)
X20.
(10 rapid to the hole; 5 + 5 + 4 and 1 more for each of two clearances; 5 + 4 + 10 + 9 between pecks; 32 up)
G98 G83 X30. Z-12. Q5.
(twice 10 + 18 rapid, the pecks as before)
G91 X10. K2
(R and Z stay where they were: 50.9902 + 18 rapid, 14 feed, 32 rapid)
G90 G82 X0. Y10. P500
(rigid: 20 + 15 rapid, 13 feed in, 13 out, 15 rapid, and P inside and outside)
M29 S500
G84 X20. Z-8. R5. F500.
(10 + 18 rapid, 10 feed, 0.3 off the wall, 28 up, 0.3 back)
G76 Y20. Z-8. R2. Q0.3 P0
G80
M30
%
