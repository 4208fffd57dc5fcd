"""What the arm can do: one answer for the check of a scenario, for a run, for replanning and for the planner."""
