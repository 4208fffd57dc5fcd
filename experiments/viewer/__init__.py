"""A plan carried out before a spectator's eyes, in the browser."""
