"""How the key of a label grows along a step, compiled; `keys` says which entries a key has."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from prefplan.models.kernels import Integer, inner_kernel

PRODUCT_LIMIT = 2**61
"""Products of a cost and a weight stay below this."""

COST, SUM, MAXIMUM, TASK, VIOLATION, VALUE = range(6)
"""How an entry grows: with a cost; at a rate; to a maximum; with a cost until a task is satisfied; only where violation
costs are paid; as `Keys.evaluate` says."""


class Keys(NamedTuple):
    """The K entries of label keys, for N tasks of which P may have violation costs, and how they grow.

    Attributes:
        entries: (K, 3) int64, how each entry grows, the cost that it grows with, and the row of its rates or its task.
        rates: (R, 2^N) int64, by satisfied set: what a sum grows by for each unit of its cost, or at least how many
            times the cost a maximum is.
        late: (L, 4) int64, entry, task, slope and offset: a sum grows with max(0, slope * cost - offset).
        violation: (K, P) int64, what each entry grows by for each unit of violation cost.
        edge_costs: (D, E) int64, costs of each edge, or of each price where states are generated;
            (1, 0) where successors come with their only cost.
        compared: (W,) int64, the entries by which labels of a product state are compared; ~e for less of entry e.
        shift: number of low bits of the first cost, which count actions.
        objectives: O: the first entries are the objectives.
        first: the objective in whose order goals are found.
        lexicographic: whether a label is also no worse than another if its objectives are lexicographically no more.
        lazy: whether labels are compared with expanded ones only; `compared` then lacks the first objective.
        ranked: of labels with one bound of the first objective, those are expanded first of which so many first entries
            are lexicographically less.
        cost_limit: from this cost on a product with it might not fit 64 bits.
        computed: whether some entries are values.
        evaluate: (label) -> whether the values in a label's key could be computed, as in `END`; None in Python.
    """

    entries: np.ndarray
    rates: np.ndarray
    late: np.ndarray
    violation: np.ndarray
    edge_costs: np.ndarray
    compared: np.ndarray
    shift: int
    objectives: int
    first: int
    lexicographic: bool
    lazy: bool
    ranked: int
    cost_limit: int
    computed: bool
    evaluate: Any


@inner_kernel
def spent(keys: Keys, key: np.ndarray, d: Integer) -> Integer:
    """Return one of the total costs, in units: without the low bits of the first cost, which count actions."""
    return key[d] >> keys.shift if d == 0 else key[d]


@inner_kernel
def grow(keys: Keys, satisfied: Integer, step: Integer, violation: np.ndarray, key: np.ndarray) -> bool:
    """Replace a label's `key` by that of a successor, except for values; return whether it fits 64 bits for sure.

    `satisfied` are the tasks before the step, as bits; `step` is its cost, or the number of its edge or price, and
    `violation` (P,) the violation costs that it pays, or (0,) if no step pays any.
    """
    numbered = keys.edge_costs.shape[1] > 0
    for d in range(keys.edge_costs.shape[0]):
        key[d] += keys.edge_costs[d, step] if numbered else step
        if spent(keys, key, d) >= keys.cost_limit:
            return False
    for e in range(keys.edge_costs.shape[0], key.shape[0]):
        how, d, row = keys.entries[e, 0], keys.entries[e, 1], keys.entries[e, 2]
        after = spent(keys, key, d)
        if how == SUM:
            key[e] += keys.rates[row, satisfied] * (after - _before(keys, key, d, step))
        elif how == MAXIMUM:
            key[e] = max(key[e], keys.rates[row, satisfied] * after)
        elif how == TASK and not satisfied >> row & 1:
            key[e] = after
        for i in range(violation.shape[0]):
            key[e] += keys.violation[e, i] * violation[i]
    for t in range(keys.late.shape[0]):
        e, i, slope, offset = keys.late[t, 0], keys.late[t, 1], keys.late[t, 2], keys.late[t, 3]
        if not satisfied >> i & 1:
            d = keys.entries[e, 1]
            before, after = _before(keys, key, d, step), spent(keys, key, d)
            key[e] += max(0, slope * after - offset) - max(0, slope * before - offset)
    return True


@inner_kernel
def _before(keys: Keys, key: np.ndarray, d: Integer, step: Integer) -> Integer:
    """Return a total cost before the step that the costs in `key` already count."""
    before = key[d] - (keys.edge_costs[d, step] if keys.edge_costs.shape[1] else step)
    return before >> keys.shift if d == 0 else before
