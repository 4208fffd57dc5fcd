"""The commands of `prefplan`, one per module; each has `add(commands)`, which adds its parser."""
