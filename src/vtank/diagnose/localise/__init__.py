"""Where the gap lies: channel, run, stretch of time, frequency and region of motion."""
