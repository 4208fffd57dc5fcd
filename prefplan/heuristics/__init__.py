"""Lower bounds of the cost-to-go and of the preference's growth, tabulated before a search.

- `cost_to_go`: equation (4) of the paper in plain Python, and Lemma 1. Read it first.
- `backward`: the same for a few tasks together, compiled: by `sweep`, or else by Dijkstra's algorithm.
- `pattern_database`: tables of sets of tasks, and what they say of a product state.
- `projection`, `projected_backward`: the same where states are generated.
- `lagrangian`, `landmarks`: larger bounds, for fronts and for single plans.
- `prepare`: which of these a search gets. A new bound is made here, and looked up in `search/label_search`.
"""
