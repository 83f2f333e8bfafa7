"""The catalogue of unmodelled effects: one file per effect, which says all that is to be known about it.

A new effect is a file here, its term in a plant's equation or a sensor's reading, and its row in the README's table
(`vtank effects --markdown`). Everything else asks the catalogue.
"""
