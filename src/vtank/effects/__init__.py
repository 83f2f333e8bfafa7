"""The catalogue of unmodelled effects: one file per effect, each with its law, parameters and source."""
