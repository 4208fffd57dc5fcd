"""Skills: the operator of each kind of action, together with the motion that achieves its effect."""
