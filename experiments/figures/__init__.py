"""Figures of fronts, plans, automata and transition systems."""
