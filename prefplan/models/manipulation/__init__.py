"""Objects on a table that an arm moves between locations, as a transition system."""
