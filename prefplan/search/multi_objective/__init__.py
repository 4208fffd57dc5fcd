"""Search for any number of costs and preferences, and for preferences whose label key has several entries.

- `ltmoa_star`: the compiled search; `objective_search`: the loop around it; `open_list`: its open list.
- `entry_map`: which entries a label needs; `entries`: the same as arrays, and how they grow along a step.
- `valuations`: values of expressions and Python functions, as programs for the kernel.
"""
