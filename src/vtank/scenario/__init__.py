"""Scenarios: what is commanded, sensed and disturbed in one experiment, from TOML files with units in the keys."""
