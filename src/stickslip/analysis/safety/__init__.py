"""How safe an attractor is: what carries a motion into another basin, and how long it takes."""
