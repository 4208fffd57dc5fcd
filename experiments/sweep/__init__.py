"""Sweeps: a plan carried out many times under random perturbations."""
