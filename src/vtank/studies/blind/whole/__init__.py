"""Blind trials of whole vehicles: vehicle, scenarios and what is wrong drawn at random, the truth sealed apart."""
