"""Lower bounds of several objectives: pattern databases for each cost, and growth tables for each preference.

The pattern databases of all costs are over the same sets of tasks, so that one index serves all costs. Where states
are generated, tables are over projections, and their entries are added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.pattern_database import (
    Patterns,
    levels_of_sets,
    no_patterns,
    patterns,
    projected_patterns,
)
from prefplan.heuristics.preference_bound import Blocks, block_entry, blocks, no_blocks
from prefplan.heuristics.preprocessing import ENTRY_BYTES, TABLES_SHARE, Options
from prefplan.heuristics.projections import Projections, no_projections, projected
from prefplan.heuristics.task_sets import TaskSets, table_entry
from prefplan.preferences.objective import PreferenceObjective
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel
from prefplan.product.product_automaton import Product
from prefplan.product.product_view import ProductView


class ObjectiveBounds(NamedTuple):
    """Tables for D costs and A preferences.

    Attributes:
        sets: P sets of tasks, and base: (P,) int64: as in `Patterns`.
        tables: (D, entries) int32, the table of `Patterns` for each cost.
        add_up: whether a bound is the sum of the entries, not the largest.
        projections: of the model, which the tables are over; none where its states are listed.
        blocks: those of all preferences.
        owner: (B,) int64, the preference of each block.
    """

    sets: TaskSets
    base: np.ndarray
    tables: np.ndarray
    add_up: bool
    projections: Projections
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
        views: (D,) the product with each of the costs.
        additive: the preferences whose growth is bounded.
        options: how to search.
        single: whether one plan is wanted, not the front.
        max_bytes: memory that all is to fit into.

    Raises:
        OverflowError: 64 bits may not be enough.
    """
    known, backwards = _costs_to_go(product, views, options, single=single, max_bytes=max_bytes)
    growing = additive if options.preference_bound else ()
    each = [blocks(backwards[o.cost], o.measure, o.units.factor, known[o.cost]) for o in growing]
    owner = [k for k, one in enumerate(each) for _ in one.members]
    first = backwards[0]
    return ObjectiveBounds(
        known[0].sets,
        known[0].base,
        np.stack([one.table for one in known]),
        isinstance(first, Projected),
        first.projections() if isinstance(first, Projected) else no_projections(),
        _joined(each, len(product.sizes)),
        np.array(owner, dtype=np.int64),
    )


def _costs_to_go(
    product: Product, views: Sequence[ProductView], options: Options, *, single: bool, max_bytes: float
) -> tuple[list[Patterns], Sequence[Backward | Projected]]:
    """Return the tables of each cost, and what fills further ones; arguments as in `objective_bounds`."""
    if isinstance(product, GeneratedProduct):
        projected = Projected(product, options.apart_entries)
        each = [projected.with_costs(view.costs) for view in views]
        return [projected_patterns(one) if options.heuristic != 0 else no_patterns() for one in each], each
    listed = [Backward(product, view, sweep=options.sweep) for view in views]
    most = TABLES_SHARE * max_bytes / ENTRY_BYTES / len(views)
    sets, *_ = levels_of_sets(listed[0], options.heuristic, single=single, max_entries=most)
    return [patterns(one, sets) for one in listed], listed


def _joined(each: Sequence[Blocks], tasks: int) -> Blocks:
    """Return the blocks of several measures as those of one."""
    each = [one for one in each if len(one.members)]
    if not each:
        return no_blocks(tasks)
    width = max(one.sets.tasks.shape[1] for one in each)
    starts = np.cumsum([0, *(len(one.table) for one in each)])

    def padded(columns: np.ndarray) -> np.ndarray:
        return np.pad(columns, ((0, 0), (0, width - columns.shape[1])))

    return Blocks(
        TaskSets(
            np.concatenate([padded(one.sets.tasks) for one in each]),
            np.concatenate([padded(one.sets.strides) for one in each]),
            np.concatenate([one.sets.projection for one in each]),
        ),
        np.concatenate([one.base + start for one, start in zip(each, starts, strict=False)]),
        np.concatenate([one.members for one in each]),
        np.concatenate([one.table for one in each]),
    )


@bare_kernel
def write_bounds(
    bounds: ObjectiveBounds,
    digits: np.ndarray,
    node: Integer,
    automata: np.ndarray,
    satisfied: Integer,
    found: np.ndarray,
) -> None:
    """Write (D + A,) lower bounds of the growth of each cost, then of each preference, from a product state to the end.

    Each is at most `INFINITE`; where some set of tasks cannot be finished, every cost's is `INFINITE`. `digits` are
    those of the node, where states are generated.
    """
    costs = bounds.tables.shape[0]
    for e in range(found.shape[0]):
        found[e] = 0
    for p in range(bounds.base.shape[0]):
        place = projected(bounds.projections, bounds.sets.projection[p], digits, node)
        entry = bounds.base[p] + table_entry(bounds.sets, p, place, automata)
        for d in range(costs):
            cost = np.int64(bounds.tables[d, entry])
            if cost == UNREACHABLE:
                found[d] = INFINITE
            elif bounds.add_up:
                found[d] = min(found[d] + cost, np.int64(INFINITE))
            else:
                found[d] = max(found[d], cost)
    tables = bounds.blocks
    for b in range(tables.members.shape[0]):
        place = projected(bounds.projections, tables.sets.projection[b], digits, node)
        entry = block_entry(tables, b, place, automata, satisfied)
        e = costs + bounds.owner[b]
        found[e] = min(found[e] + tables.table[entry], np.int64(INFINITE))
