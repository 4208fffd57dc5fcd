"""Scenario files that ship with prefplan."""
