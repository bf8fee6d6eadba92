"""Maps of R^n: their periodic orbits, and how these change with a parameter."""
