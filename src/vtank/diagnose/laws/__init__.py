"""The missing law: formulas of a typed grammar for what no effect of the catalogue explains."""
