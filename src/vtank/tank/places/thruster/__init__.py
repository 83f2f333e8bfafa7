"""Effects of one thruster: what is read of its input, what acts of it, and what force comes of it."""
