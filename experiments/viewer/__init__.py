"""Plans carried out in simulation and shown live in the browser."""
