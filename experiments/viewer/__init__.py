"""A plan carried out in simulation and played in the browser."""
