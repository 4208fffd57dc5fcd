"""Preference functions over task costs (Definition 5), and the contracts that a search relies on.

From a table of a scenario file to a label key, a preference has two forms:

| form                                        | made by            | what it adds                                    |
| ------------------------------------------- | ------------------ | ----------------------------------------------- |
| a class of `kinds`, such as `Order`         | the user           | mu, in names of tasks and the user's numbers    |
| `objective.Measure`, a sum of `terms`       | `problem.Problem`  | tasks by number, so a contract; a cost, units   |

An `Expression` is parsed to a tree (`expression`) and split into terms that the search supports (`analysis`). If it
cannot be split, it is a single term, whose contract is derived, or declared by the user and tested (`contracts`).
"""
