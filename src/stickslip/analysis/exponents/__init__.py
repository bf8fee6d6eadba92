"""How fast orbits part: exponents of maps of R^n, means with errors, tests of series for chaos."""
