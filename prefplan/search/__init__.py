"""Best-first searches for the Pareto front, and the plans on it.

- `reference`: Algorithm 1 and BOA* of the paper in plain Python; what all searches must find. Read it first.
- `label_search`: the same compiled, for any number of costs and preferences. `driver`: the loop around it.
- `keys`: the entries of a label key. `labels`: how entries grow, and memory. `values`: entries computed by formulas.
- `paths`: the result of a search, and plans from paths of product states.
- `bounds`: limits and bounds of objectives as a user gives them.
- `incumbent`: which search suits a problem, and some plan if it is stopped. `infeasibility`: why no plan exists.
"""
