"""Maps that stand for a map: its branches as polynomials, asked where a proof is not needed."""
