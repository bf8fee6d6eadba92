"""Models: immutable, validated parameters of oscillators on a belt."""
