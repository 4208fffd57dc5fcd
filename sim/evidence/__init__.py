"""Logs of runs, and certificates: checks of every claim about a run, made from its log alone."""
