"""Best-first searches for the Pareto front, and the plans on it.

- `reference`: Algorithm 1 and BOA* of the paper in plain Python; what all searches must find. Read it first.
- `boa_star`: the same compiled, for one cost and one preference with label keys (g, mu). `growth`: how mu grows.
- `multi_objective`: LTMOA*, for several costs or preferences, or longer label keys.
- `labels`, `driver`: memory of a compiled search, and the loop around it. `result`: what a search returns.
- `bounds`: limits and bounds of objectives as a user gives them.
- `incumbent`: some plan for a search that is stopped.
- `paths`, `plan_extraction`: from product states to plans. `infeasibility`: why there is none.
"""
