"""The reachable states of a manipulation model, breadth first."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from prefplan.limits import check_limits
from prefplan.models.costs import UNMEASURED, CostTable
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.successors import Moves, expand, steps_of
from prefplan.models.manipulation.symmetry import IN_HAND, Exclusion, Symmetry
from prefplan.models.transition_system import TransitionSystem
from prefplan.plan import OnDemand

CHUNK = 2**13
"""Number of states that are expanded between two checks of the limits."""

EDGE_BYTES = 40
"""Memory for each edge while states are numbered, bytes."""


def moves_of(space: StateCodes, symmetry: Symmetry) -> Moves:
    """Return a model as arrays, given what may be exchanged."""
    model, names, neutral, alike = space.model, space.locations, symmetry.neutral, symmetry.alike
    # An object that is alike to no other changes in a canonical state only if there are neutral locations.
    alone = [[o] for o, obj in enumerate(space.objects) if neutral and not any(obj in each for each in alike)]
    objects = alone + [[o for o, obj in enumerate(space.objects) if obj in each] for each in alike]
    class_of = np.zeros(max(space.held + 1, len(space.hands)), dtype=np.int64)
    places = np.zeros((len(neutral) + 1, 1 + max(map(len, neutral), default=0)), dtype=np.int64)
    for number, each in enumerate(neutral, start=1):
        members = [x for x, name in enumerate(names) if name in each]
        class_of[members] = number
        places[number, : len(members)] = members
    excluded, first, conditions = _exclusion_arrays(space, action_names(space), symmetry.exclusions)
    below = np.array([[name in place.on for name in names] for place in model.locations])
    empty = np.array([[name in place.clear_of for name in names] for place in model.locations])
    closed = np.array([place.closed for place in model.locations])
    capacity = np.array([place.capacity for place in model.locations], dtype=np.int64)
    digit = space.mark_digits
    marks = [[digit.get((obj, place.marks or ""), 0) for obj in space.objects] for place in model.locations]
    origins = [[space.origins.get((obj, name), 0) for obj in space.objects] for name in names]
    return Moves(
        radices=np.array(space.radices, dtype=np.int64),
        location=space.location,
        first_slot=np.searchsorted(space.location, np.arange(len(names) + 1)),
        over=space.over,
        above=space.above,
        capacity=np.where(closed | (below & empty).any(axis=1), 0, capacity),
        movable=np.array([not obj.fixed for obj in model.objects], dtype=np.bool_),
        needs=below.astype(np.int8) - empty.astype(np.int8),
        blocks=below | (closed[:, None] & empty).T,
        mark=np.array(marks, dtype=np.int64).reshape(len(names), len(space.objects)),
        origin=np.array(origins, dtype=np.int64).reshape(len(names), len(space.objects)),
        neutral=class_of,
        places=places,
        ranks=np.zeros(len(places), dtype=np.int64),
        alike=np.array([o for each in objects for o in each], dtype=np.int64),
        alike_class=np.repeat(np.arange(len(objects)), list(map(len, objects))),
        excluded=excluded,
        first_condition=first,
        conditions=conditions,
    )


def _exclusion_arrays(
    space: StateCodes, actions: Sequence[str], exclusions: Collection[Exclusion]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return exclusions as in `Moves`, given the encoding of the states and the texts of the actions."""
    first_slot = np.searchsorted(space.location, np.arange(len(space.locations) + 1)).tolist()
    slots = {name: first_slot[x : x + 2] for x, name in enumerate(space.locations)}
    slots[IN_HAND] = [space.held, space.held + 1]

    def condition(obj: str, what: str) -> list[int]:
        is_mark = what not in slots
        return [space.mark_digits[obj, what], 1, 2] if is_mark else [1 + space.objects.index(obj), *slots[what]]

    def rows_of(exclusion: Exclusion) -> list[list[int]]:
        action, pairs, origin = exclusion
        value = space.origins[action.obj, origin] if origin else 0
        grasped = [[len(space.radices) - 1, value, value + 1]] if origin else []
        return [condition(*pair) for pair in sorted(pairs)] + grasped

    number = {text: a for a, text in enumerate(actions)}
    ordered = sorted((number[str(one.action)], rows_of(one)) for one in exclusions)
    rows = [each for _, each in ordered]
    of_action = np.searchsorted([a for a, _ in ordered], np.arange(len(actions) + 1))
    conditions = np.array([row for each in rows for row in each], dtype=np.int64).reshape(-1, 3)
    return of_action.astype(np.int32), np.cumsum([0, *map(len, rows)]).astype(np.int32), conditions


def action_names(space: StateCodes) -> tuple[str, ...]:
    """Return the texts of the actions by their numbers."""
    loaded = [f"{obj} {name}" for obj in space.objects for name in space.locations]
    names = [f"transit {name}" for name in space.locations] + [f"grasp {obj}" for obj in space.objects]
    return (*names, *(f"transport {text}" for text in loaded), *(f"release {text}" for text in loaded))


def listed(
    space: StateCodes, moves: Moves, costs: Collection[CostTable], start: int, names: Collection[str]
) -> tuple[TransitionSystem, np.ndarray]:
    """List the canonical states reachable from `start` by the standard operators; return also their (S,) int64 codes.

    States at the same distance from the start are in the order of their codes. Costs are (K, H, H), as in `CostTable`;
    labels keep the propositions `names`.

    Raises:
        LimitError: a limit of time or memory was reached.
    """
    codes, edges = _reachable(moves, start, np.all([each.entries.ravel() != UNMEASURED for each in costs], axis=0))
    counts, reached, actions, prices = (np.concatenate(each) for each in zip(*edges, strict=True))
    _check_limits(len(reached))
    by_code = np.argsort(codes)
    labels, label_sets = _labels(space, codes, names)
    system = TransitionSystem(
        states=OnDemand(len(codes), lambda i: space.decode(int(codes[i]))),
        start=0,
        offsets=np.concatenate([[0], np.cumsum(counts)]),
        targets=by_code[np.searchsorted(codes[by_code], reached)].astype(np.int32),
        actions=actions,
        costs=tuple(replace(each, entries=each.entries.ravel()[prices]) for each in costs),
        labels=labels,
        action_names=action_names(space),
        label_sets=label_sets,
        propositions=space.model.valid_propositions,
    )
    return system, codes


def _reachable(moves: Moves, start: int, exists: np.ndarray) -> tuple[np.ndarray, list[tuple[np.ndarray, ...]]]:
    """Return (S,) the canonical states reachable from `start`, and their actions, in chunks, as from `expand`.

    `exists` is (P,) bool, by price as in `Steps`: whether actions with this price exist.
    """
    steps = steps_of(moves)
    layer = np.array([start], dtype=np.int64)
    layers, known, edges = list[np.ndarray](), layer, list[tuple[np.ndarray, ...]]()
    while len(layer):
        layers.append(layer)
        chunks = []
        for first in range(0, len(layer), CHUNK):
            _check_limits(first)
            chunks.append(expand(moves, layer[first : first + CHUNK], exists, steps))
        edges += chunks
        reached = np.concatenate([chunk[1] for chunk in chunks])
        _check_limits(len(reached))
        reached = np.unique(reached)
        places = np.searchsorted(known, reached)
        layer = reached[known[np.minimum(places, len(known) - 1)] != reached]
        known = np.insert(known, np.searchsorted(known, layer), layer)
    return np.concatenate(layers), edges


def _check_limits(edges: int) -> None:
    """Check the limits before memory for some edges is taken, unless they are few: small models are always listed."""
    if edges >= CHUNK:
        check_limits(EDGE_BYTES * edges)


def _labels(
    space: StateCodes, codes: np.ndarray, names: Collection[str]
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
