"""The report of a diagnosis: one HTML file that needs nothing else, and the same findings in words."""
