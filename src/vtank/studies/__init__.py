"""Studies on top of the library: the paper, blind trials, design of experiments, campaigns, bandwidth."""
