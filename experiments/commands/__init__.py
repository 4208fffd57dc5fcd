"""The commands of `prefplan`, one a module; each has `add(commands)`, which adds its parser."""
