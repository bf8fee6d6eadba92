"""Parameters of models from measurements."""
