"""Where along a parameter something changes."""
