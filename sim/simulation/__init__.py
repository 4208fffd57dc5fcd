"""The running simulation, and what is recorded of it."""
