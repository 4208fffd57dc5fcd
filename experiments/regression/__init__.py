"""Regression tests on outcomes of plans, for users."""
