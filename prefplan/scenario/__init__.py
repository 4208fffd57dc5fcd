"""Scenario files: TOML decoded strictly into a model, tasks and a preference."""
