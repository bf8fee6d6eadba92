"""The flow of any number of blocks with any linear coupling, damping and harmonic forcing."""
