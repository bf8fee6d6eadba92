"""From one global stick phase to the next."""
