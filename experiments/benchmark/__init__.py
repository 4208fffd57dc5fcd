"""The planner, timed: the paper's Table I, and groups of other cases."""
