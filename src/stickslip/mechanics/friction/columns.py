"""Columns of a parameter row, which belongs to one smooth piece of a law.

After PARAMETER_COLUMN the parameters of the formula follow, then constants made of them.
"""

LAW_COLUMN, STATIC_COLUMN, FORWARD_STATIC_COLUMN = 0, 1, 2
PIECE_END_COLUMN, NEXT_PIECE_COLUMN = 3, 4
PARAMETER_COLUMN = 5
