"""Border collisions: outcomes predicted and observed."""
