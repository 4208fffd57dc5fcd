"""Best-first searches for the Pareto front, and the plans on it.

- `reference`: Algorithm 1 and BOA* of the paper in plain Python; what all searches must find. Read it first.
- `label_search`: the same compiled, for any number of costs and preferences. `driver`: the loop around it.
- `keys`: which entries a label key has. `labels`: how they grow, and memory. `values`: those that are computed.
- `paths`: what a search returns; from product states to plans.
- `bounds`: limits and bounds of objectives as a user gives them.
- `incumbent`: which search suits a problem, and some plan for one that is stopped. `infeasibility`: why there is none.
"""
