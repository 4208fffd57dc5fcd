"""Lower bounds of several objectives at once: the tables of one bound for each cost, and of one for each preference.

The pattern databases of all costs are over the same sets of tasks, so that a state's entry is found once for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.pattern_database import UNREACHABLE, no_patterns, pattern_size, patterns
from prefplan.heuristics.preference_bound import Blocks, block_entry, blocks, no_blocks
from prefplan.heuristics.preprocessing import ENTRY_BYTES, TABLES_SHARE, Options
from prefplan.preferences.objective import PreferenceObjective
from prefplan.product.kernels import Integer, bare_kernel
from prefplan.product.product_automaton import Product
from prefplan.product.successors import INFINITE, ProductView


class ObjectiveBounds(NamedTuple):
    """Tables for D costs and A preferences.

    Attributes:
        tasks: (P, k) int64, strides: (P, k) int64, base: (P,) int64: as of `Patterns`.
        tables: (D, entries) int32, the table of `Patterns` for each cost.
        blocks: as of one preference, those of all.
        owner: (B,) int64, the preference of each block.
    """

    tasks: np.ndarray
    strides: np.ndarray
    base: np.ndarray
    tables: np.ndarray
    blocks: Blocks
    owner: np.ndarray


def objective_bounds(
    product: Product,
    views: Sequence[ProductView],
    additive: Sequence[PreferenceObjective],
    options: Options,
    *,
    single: bool,
    max_bytes: float,
) -> ObjectiveBounds:
    """Return the tables of several objectives.

    Args:
        product: what is searched.
        views: the product with each of the costs.
        additive: the preferences whose growth is bounded.
        options: how to search.
        single: whether one plan is wanted, not the front.
        max_bytes: memory that all is to fit into.

    Raises:
        OverflowError: 64 bits may not be enough.
    """
    backwards = [Backward(product, view) for view in views]
    size = options.heuristic
    if size is None:
        most = TABLES_SHARE * max_bytes / ENTRY_BYTES / len(views)
        size = pattern_size(backwards[0], single=single, max_entries=most)
    tasks = len(product.sizes)
    known = [patterns(backward, min(size, tasks)) if size else no_patterns() for backward in backwards]
    growing = additive if options.preference_bound else ()
    each = [blocks(backwards[o.cost], o.measure, o.units.factor, known[o.cost]) for o in growing]
    owner = [k for k, one in enumerate(each) for _ in one.members]
    tables = np.stack([one.table for one in known])
    return ObjectiveBounds(
        known[0].tasks, known[0].strides, known[0].base, tables, _joined(each, tasks), np.array(owner, dtype=np.int64)
    )


def _joined(each: Sequence[Blocks], tasks: int) -> Blocks:
    """Return the blocks of several measures as those of one."""
    each = [one for one in each if len(one.members)]
    if not each:
        return no_blocks(tasks)
    width = max(one.tasks.shape[1] for one in each)
    starts = np.cumsum([0, *(len(one.table) for one in each)])

    def padded(columns: np.ndarray, fill: int) -> np.ndarray:
        return np.pad(columns, ((0, 0), (0, width - columns.shape[1])), constant_values=fill)

    return Blocks(
        np.concatenate([padded(one.tasks, -1) for one in each]),
        np.concatenate([padded(one.strides, 0) for one in each]),
        np.concatenate([one.base + start for one, start in zip(each, starts, strict=False)]),
        np.concatenate([one.members for one in each]),
        np.concatenate([one.projection for one in each]),
        np.concatenate([one.table for one in each]),
    )


@bare_kernel
def write_bounds(
    bounds: ObjectiveBounds, node: Integer, automata: np.ndarray, satisfied: Integer, found: np.ndarray
) -> None:
    """Write the least growth of each cost, then of each preference, from a product state to the end.

    Each is `INFINITE` at most; where no task set can be finished, that of every cost is `INFINITE`.
    """
    costs = bounds.tables.shape[0]
    for e in range(found.shape[0]):
        found[e] = 0
    for p in range(bounds.base.shape[0]):
        entry = bounds.base[p] + node
        for j in range(bounds.tasks.shape[1]):
            entry += bounds.strides[p, j] * automata[bounds.tasks[p, j]]
        for d in range(costs):
            cost = np.int64(bounds.tables[d, entry])
            found[d] = max(found[d], np.int64(INFINITE) if cost == UNREACHABLE else cost)
    tables = bounds.blocks
    for b in range(tables.members.shape[0]):
        entry = block_entry(tables, b, node, automata, satisfied)
        e = costs + bounds.owner[b]
        found[e] = min(found[e] + tables.table[entry], np.int64(INFINITE))
