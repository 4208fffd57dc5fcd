"""Assertions on fronts, plans and executions for users' regression tests."""
