"""Effects of one fin: what acts of its angle, and what lift comes of it."""
