"""Lower bounds of the cost-to-go and of the preference's growth, tabulated before a search.

- `cost_to_go`: equation (4) of the paper in plain Python, and Lemma 1. Read it first.
- `backward`: cost-to-go tables for a few tasks together, in compiled code: by `sweep`, or by Dijkstra's algorithm.
- `pattern_database`: which sets of tasks get a table, and the bound that all tables give for a product state.
- `projection`, `projected_backward`: tables of a manipulation model whose states are generated.
- `lagrangian`, `landmarks`: larger bounds, for fronts and for single plans, respectively.
- `prepare`: which of these a search gets. Build a new bound there, and look it up in `search/label_search`.
"""
