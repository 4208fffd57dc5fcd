"""Skills: how each symbolic action is carried out."""
