"""Programs: the command line and the paper's experiments."""
