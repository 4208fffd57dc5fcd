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
    patterns,
    projected_patterns,
    sets_of_tasks,
)
from prefplan.heuristics.preference_bound import Blocks, block_entry, blocks, no_blocks
from prefplan.heuristics.preprocessing import ENTRY_BYTES, TABLES_SHARE, Options
from prefplan.heuristics.projections import Projections, place_of
from prefplan.heuristics.task_sets import TaskSets, table_entry
from prefplan.models.kernels import INFINITE, UNREACHABLE, Integer, bare_kernel
from prefplan.preferences.objective import PreferenceObjective
from prefplan.product.contraction import Graph
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product


class ObjectiveBounds(NamedTuple):
    """Tables for D costs and A preferences.

    Attributes:
        sets: P sets of tasks, and base: (P,) int64: as in `Patterns`.
        tables: (D, entries) int32, the table of `Patterns` for each cost.
        add_up: whether a bound is the sum of the entries, not the largest.
        projections: of the model, which the tables are over; None where its states are listed.
        blocks: those of all preferences.
        owner: (B,) int64, the preference of each block.
    """

    sets: TaskSets
    base: np.ndarray
    tables: np.ndarray
    add_up: bool
    projections: Projections | None
    blocks: Blocks
    owner: np.ndarray


def objective_bounds(
    product: Product,
    graphs: Sequence[Graph],
    preferences: Sequence[PreferenceObjective],
    options: Options,
    *,
    max_bytes: float,
) -> ObjectiveBounds:
    """Return the tables of several objectives.

    Args:
        product: what is searched.
        graphs: (D,) what is searched, with each of the costs.
        preferences: all of them; the growth of those with rounded values is not bounded.
        options: how to search.
        max_bytes: memory that all is to fit into.

    Raises:
        OverflowError: 64 bits may not be enough.
    """
    known, backwards = _costs_to_go(product, graphs, options, max_bytes=max_bytes)
    growing = [k for k, o in enumerate(preferences) if options.preference_bound and o.measure.is_whole]
    each = [
        blocks(backwards[o.cost], o.measure, o.units.factor, known[o.cost]) for o in (preferences[k] for k in growing)
    ]
    owner = [k for k, one in zip(growing, each, strict=True) for _ in one.members]
    first = backwards[0]
    return ObjectiveBounds(
        known[0].sets,
        known[0].base,
        np.stack([one.table for one in known]),
        isinstance(first, Projected),
        first.projections() if isinstance(first, Projected) else None,
        _joined(each) or no_blocks(first),
        np.array(owner, dtype=np.int64),
    )


def _costs_to_go(
    product: Product, graphs: Sequence[Graph], options: Options, *, max_bytes: float
) -> tuple[list[Patterns], Sequence[Backward | Projected]]:
    """Return the tables of each cost, and what fills further ones; arguments as in `objective_bounds`."""
    if isinstance(product, GeneratedProduct):
        projected = Projected(product)
        each = [projected.with_costs(graph.costs) for graph in graphs]
        groups = projected.groups() if options.heuristic != 0 else []
        return [projected_patterns(one, groups) for one in each], each
    listed = [Backward(product, graph, sweep=options.sweep) for graph in graphs]
    most = TABLES_SHARE * max_bytes / ENTRY_BYTES / len(graphs)
    sets = sets_of_tasks(listed[0], options.heuristic, most)
    return [patterns(one, sets) for one in listed], listed


def _joined(each: Sequence[Blocks]) -> Blocks | None:
    """Return the blocks of several measures as those of one; None without measures."""
    if not each:
        return None
    width = max(one.sets.tasks.shape[1] for one in each)
    starts = np.cumsum([0, *(len(one.table) for one in each)])

    def padded(columns: np.ndarray) -> np.ndarray:
        return np.pad(columns, ((0, 0), (0, width - columns.shape[1])))

    numbers = [one.sets.projection for one in each if one.sets.projection is not None]
    projection = np.concatenate(numbers) if numbers else None
    return Blocks(
        TaskSets(
            np.concatenate([padded(one.sets.tasks) for one in each]),
            np.concatenate([padded(one.sets.strides) for one in each]),
            projection,
        ),
        np.concatenate([one.base + start for one, start in zip(each, starts, strict=False)]),
        np.concatenate([one.members for one in each]),
        np.concatenate([one.table for one in each]),
    )


@bare_kernel
def write_bounds(
    bounds: ObjectiveBounds,
    node: Integer,
    automata: np.ndarray,
    satisfied: Integer,
    found: np.ndarray,
) -> None:
    """Write (D + A,) lower bounds of the growth of each cost, then of each preference, from a product state to the end.

    Each is at most `INFINITE`; where some set of tasks cannot be finished, every cost's is `INFINITE`.
    """
    costs = bounds.tables.shape[0]
    for e in range(found.shape[0]):
        found[e] = 0
    for p in range(bounds.base.shape[0]):
        place = place_of(bounds.projections, bounds.sets.projection, p, node)
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
        place = place_of(bounds.projections, tables.sets.projection, b, node)
        entry = block_entry(tables, b, place, automata, satisfied)
        e = costs + bounds.owner[b]
        found[e] = min(found[e] + tables.table[entry], np.int64(INFINITE))
