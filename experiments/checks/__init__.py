"""What `prefplan check` finds in a scenario, and `prefplan doctor` on a machine."""
