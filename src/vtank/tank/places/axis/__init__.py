"""Effects of the water along or about one axis, in the units of that axis."""
