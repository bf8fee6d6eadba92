"""Maps: what a map offers, and maps by functions, powers and windows."""
