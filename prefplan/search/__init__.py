"""Best-first searches for the Pareto front, and the plans on it.

- `reference`: Algorithm 1 and BOA* of the paper in plain Python; what all searches must find. Read it first.
- `boa_star`, `bi_objective_search`: the same compiled, for one cost and one preference with label keys (g, mu).
- `ltmoa_star`, `entries`, `lexicographic_queue`, `objective_search`: several costs or preferences, or longer keys.
- `entry_map`, `valuations`: the label keys of these, and values of expressions and Python functions.
- `labels`, `driver`: memory of a compiled search, and the loop around it. `result`: what a search returns.
- `bounds`: limits and bounds of objectives as a user gives them.
- `incumbent`: some plan for a search that is stopped.
- `plan_extraction`: from product states to a plan. `infeasibility`: why there is none.
"""
