"""Robot models, each of which becomes a transition system: explicit graphs, grids and manipulation."""
