"""Runs and data sets, simulated or real: one record type from either source."""
