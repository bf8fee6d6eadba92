"""What joins mechanics and analysis: maps of models, mechanisms of their breakpoints."""
