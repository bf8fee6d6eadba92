"""What is solved at a bifurcation, and where it holds."""
