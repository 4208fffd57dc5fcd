"""Best-first searches for the Pareto front, and the plans on it."""
