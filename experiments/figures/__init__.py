"""Figures of fronts and maps, and diagrams of automata and graphs."""
