"""Execution of plans: the executor, the closed loop around it, faults, and measured costs."""
