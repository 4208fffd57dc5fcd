"""The product automaton (Definition 7), never built: successors, and contraction to the labels that matter."""
