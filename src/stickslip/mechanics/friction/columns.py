"""What a row of a friction law's numbers holds, for those who write it and for kernels.

A row belongs to one smooth piece of a law: the number of the law, its F(0) backward and forward,
the speed where the piece ends, the row of the next one, then the parameters of its formula and
constants made of them.
"""

LAW_COLUMN, STATIC_COLUMN, FORWARD_STATIC_COLUMN = 0, 1, 2
PIECE_END_COLUMN, NEXT_PIECE_COLUMN = 3, 4
PARAMETER_COLUMN = 5
