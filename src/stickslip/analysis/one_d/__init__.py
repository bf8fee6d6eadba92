"""Maps of the line: what needs the order of its points."""
