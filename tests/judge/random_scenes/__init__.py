"""Random scenes: what `prefplan check` says to each, and what becomes of its cheapest plan."""
