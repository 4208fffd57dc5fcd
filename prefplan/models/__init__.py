"""Robot models that make a transition system: explicit graphs, grids and manipulation."""
