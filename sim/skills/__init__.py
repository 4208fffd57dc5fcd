"""Skills: each action's operator with the motion that achieves its effect."""
