"""The reachable states of a manipulation model, breadth first."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from prefplan.limits import check_limits
from prefplan.models.costs import UNMEASURED, CostTable
from prefplan.models.manipulation.action_costs import unmeasured
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.exclusions import exclusion_arrays, read_exclusions
from prefplan.models.manipulation.successors import Moves, expand, steps_of
from prefplan.models.system import Barred
from prefplan.models.transition_system import OnDemand, TransitionSystem

CHUNK = 2**13
"""States whose actions are listed at once, between two checks of the limits."""

EDGE_BYTES = 40
"""Memory for each edge while states are numbered."""

Classes = Collection[Collection[str]]
"""Names of objects or of locations in classes, within which they may be exchanged."""


def moves_of(space: StateCodes, neutral: Classes = (), alike: Classes = (), barred: Barred = ()) -> Moves:
    """Return a model as arrays, given its neutral locations and alike objects in classes, see `symmetry`."""
    model, names = space.model, space.locations
    # Only where locations are neutral does an object that is alone take another one.
    alone = [[o] for o, obj in enumerate(space.objects) if neutral and not any(obj in each for each in alike)]
    objects = alone + [[o for o, obj in enumerate(space.objects) if obj in each] for each in alike]
    class_of = np.zeros(max(space.held + 1, len(space.hands)), dtype=np.int64)
    places = np.zeros((len(neutral) + 1, 1 + max(map(len, neutral), default=0)), dtype=np.int64)
    for number, each in enumerate(neutral, start=1):
        members = [x for x, name in enumerate(names) if name in each]
        class_of[members] = number
        places[number, : len(members)] = members
    excluded, first, conditions = exclusion_arrays(space, action_names(space), read_exclusions(model, barred))
    below = np.array([[name in place.on for name in names] for place in model.locations])
    empty = np.array([[name in place.clear_of for name in names] for place in model.locations])
    closed = np.array([place.closed for place in model.locations])
    capacity = np.array([place.capacity for place in model.locations], dtype=np.int64)
    digit = space.mark_digits
    marks = [[digit.get((obj, place.marks or ""), 0) for obj in space.objects] for place in model.locations]
    return Moves(
        radices=np.array(space.radices, dtype=np.int64),
        location=space.location.astype(np.int64),
        first_slot=np.searchsorted(space.location, np.arange(len(names) + 1)).astype(np.int64),
        over=space.over.astype(np.int64),
        above=space.above.astype(np.int64),
        capacity=np.where(closed | (below & empty).any(axis=1), 0, capacity),
        movable=np.array([not obj.fixed for obj in model.objects], dtype=np.bool_),
        needs=below.astype(np.int8) - empty.astype(np.int8),
        blocks=below | (closed[:, None] & empty).T,
        mark=np.array(marks, dtype=np.int64).reshape(len(names), len(space.objects)),
        neutral=class_of,
        places=places,
        ranks=np.zeros(len(places), dtype=np.int64),
        alike=np.array([o for each in objects for o in each], dtype=np.int64),
        alike_class=np.repeat(np.arange(len(objects)), list(map(len, objects))).astype(np.int64),
        excluded=excluded,
        first_condition=first,
        conditions=conditions,
    )


def action_names(space: StateCodes) -> tuple[str, ...]:
    """Return the texts of the actions by their numbers."""
    loaded = [f"{obj} {name}" for obj in space.objects for name in space.locations]
    names = [f"transit {name}" for name in space.locations] + [f"grasp {obj}" for obj in space.objects]
    return (*names, *(f"transport {text}" for text in loaded), *(f"release {text}" for text in loaded))


@dataclass(frozen=True)
class StateTable:
    """S states and E actions of a model.

    Attributes:
        codes: (S,) int64, of the states; the start's first.
        offsets: (S + 1,) int64 and targets: (E,) int32, as in `TransitionSystem`.
        actions: (E,) int32, index into `action_names`.
        prices: (E,) int32, as in `prefplan.models.manipulation.successors.Steps`.
        action_names: texts of the actions.
    """

    codes: np.ndarray
    offsets: np.ndarray
    targets: np.ndarray
    actions: np.ndarray
    prices: np.ndarray
    action_names: tuple[str, ...]


def listed(space: StateCodes, moves: Moves, start: int) -> StateTable:
    """Return the canonical states that can be reached from one by the standard operators.

    States of one distance from the start are in the order of their codes.

    Raises:
        ModelError: there are too many states for 64-bit integers.
        LimitError: a limit of time or memory was reached.
    """
    space.require_small()
    steps = steps_of(moves)
    layer = np.array([start], dtype=np.int64)
    layers, sorted_codes, edges = list[np.ndarray](), layer, list[tuple[np.ndarray, ...]]()
    while len(layer):
        layers.append(layer)
        chunks = []
        for first in range(0, len(layer), CHUNK):
            _check_limits(first)
            chunks.append(expand(moves, layer[first : first + CHUNK], steps))
        edges += chunks
        reached = np.concatenate([chunk[1] for chunk in chunks])
        _check_limits(len(reached))
        reached = np.unique(reached)
        places = np.searchsorted(sorted_codes, reached)
        layer = reached[sorted_codes[np.minimum(places, len(sorted_codes) - 1)] != reached]
        sorted_codes = np.insert(sorted_codes, np.searchsorted(sorted_codes, layer), layer)
    codes = np.concatenate(layers)
    counts, reached, actions, prices = (np.concatenate([chunk[k] for chunk in edges]) for k in range(4))
    _check_limits(len(reached))
    targets = np.argsort(codes)[np.searchsorted(sorted_codes, reached)].astype(np.int32)
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return StateTable(codes, offsets, targets, actions, prices, action_names(space))


def _check_limits(edges: int) -> None:
    """Check the limits before memory for some edges is taken, unless they are few: small models are always listed."""
    if edges >= CHUNK:
        check_limits(EDGE_BYTES * edges)


def table(
    space: StateCodes, listing: StateTable, costs: Collection[CostTable], names: Collection[str] | None
) -> TransitionSystem:
    """Return the states of a listing as a transition system; labels keep some propositions, all for None.

    Raises:
        ModelError: the cost of an action was not measured.
    """
    codes = listing.codes
    columns = tuple(replace(each, entries=each.entries.ravel()[listing.prices]) for each in costs)
    for edge in np.flatnonzero(columns[0].entries == UNMEASURED)[:1]:
        before = listing.prices[edge] // len(space.hands) % len(space.hands)
        raise unmeasured(listing.action_names[listing.actions[edge]], space.hands[before])
    labels, label_sets = _labels(space, codes, names)
    return TransitionSystem(
        states=OnDemand(len(codes), lambda i: space.decode(int(codes[i]))),
        start=0,
        offsets=listing.offsets,
        targets=listing.targets,
        actions=listing.actions,
        costs=columns,
        labels=labels,
        action_names=listing.action_names,
        label_sets=label_sets,
        propositions=space.model.valid_propositions,
    )


def _labels(
    space: StateCodes, codes: np.ndarray, names: Collection[str] | None
) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
    """Return (S,) each state's label, restricted to some names, as an index, and the distinct labels."""
    keys = np.zeros(len(codes), dtype=np.int64)
    weight = 1
    parts: list[tuple[int, list[str]]] = []
    for d, values in space.visible(names):
        distinct_values = list(dict.fromkeys(values))
        keys += weight * np.array([distinct_values.index(value) for value in values])[space.digit(codes, d)]
        parts.append((weight, distinct_values))
        weight *= len(distinct_values)
    distinct, labels = np.unique(keys, return_inverse=True)
    sets = tuple(
        frozenset(name for w, values in parts if (name := values[int(key) // w % len(values)])) for key in distinct
    )
    return labels.astype(np.int32), sets
