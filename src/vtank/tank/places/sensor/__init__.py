"""Effects of one sensor: late, turned, elsewhere, off, in other units, or by a clock of its own."""
