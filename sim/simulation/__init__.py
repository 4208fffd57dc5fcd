"""The running simulation and its records."""
