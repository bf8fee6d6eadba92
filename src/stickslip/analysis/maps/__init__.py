"""Maps: what a map offers, maps given by functions, powers, parts and fast stand-ins."""
