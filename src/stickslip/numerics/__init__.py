"""Methods that know neither friction nor maps."""
