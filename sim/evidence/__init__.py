"""What is said of a run, proven from its log alone."""
