"""Node-link diagrams: automata, transition systems, and plans on graphs."""
