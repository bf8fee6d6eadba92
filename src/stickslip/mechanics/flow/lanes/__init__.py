"""Many motions of two blocks at once: the same step for a row of lanes, as vector instructions."""
