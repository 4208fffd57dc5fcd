"""The reachable states of a manipulation model, generated breadth-first, one layer at a time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from prefplan.limits import check_limits
from prefplan.models.generated import OnDemand
from prefplan.models.manipulation.action import Action, kind_of
from prefplan.models.manipulation.action_costs import UNMEASURED
from prefplan.models.manipulation.codes import StateCodes, StateLayer
from prefplan.models.manipulation.cost_matrix import CostMatrix, cost_matrices, unmeasured
from prefplan.models.manipulation.operators import Operator
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.transition_system import EdgeCosts, TransitionSystem

CHUNK = 2**13
"""States whose actions are generated at once, between two checks of the limits."""

LAYER_BYTES = 40
"""Memory for each edge of a layer while its targets are numbered."""

EDGE_BYTES = 80
"""Memory for each edge while all are sorted by source."""

MAX_TABLE_CODES = 2**24
"""Largest number of codes for which `Numbering` keeps a table of all codes."""


@dataclass(frozen=True)
class Generator:
    """Successor generator of a manipulation model.

    Attributes:
        space: the encoding of its states.
        operators: the kinds of actions.
        costs: the costs of the actions, in order.
    """

    space: StateCodes
    operators: tuple[Operator, ...]
    costs: tuple[CostMatrix, ...]

    @classmethod
    def of(cls, space: StateCodes, operators: Sequence[Operator]) -> Generator:
        """Return the generator for the model of an encoding."""
        costs = cost_matrices(space.model, [operator.kind for operator in operators], space.hands)
        return cls(space, tuple(operators), costs)

    @property
    def has_gaps(self) -> bool:
        """Whether some kind of action might be possible between two poses of the hand, but was not measured there."""
        over = self.space.over
        stays = over[:, None] == over[None, :]
        known = self.costs[0].entries
        gaps = [known[k][stays != operator.travels] for k, operator in enumerate(self.operators)]
        return any(bool((costs == UNMEASURED).any()) for costs in gaps)

    def edges(
        self, codes: np.ndarray, kind: str | None = None
    ) -> Iterator[tuple[Action, np.ndarray, np.ndarray, list[np.ndarray]]]:
        """Yield each action, in order, as (action, states where it is applicable, successors, costs).

        Args:
            codes: (N,) codes of the states.
            kind: kind of the actions, None for all.

        Yields:
            The action; (n,) indices into `codes`; (n,) codes of the successors; for each cost, (n,) values in its unit.

        Raises:
            ModelError: a successor is not a state of the model, or the cost of an action was not measured.
        """
        layer = StateLayer(self.space, codes)
        for k, operator in enumerate(self.operators):
            if kind not in (None, operator.kind):
                continue
            for action, having, targets in operator.successors(layer):
                check_limits()
                before = layer.hand[having]
                after = self.space.digit(targets, 0)
                costs = [matrix.entries[k, before, after] for matrix in self.costs]
                for hand in before[costs[0] == UNMEASURED]:
                    raise unmeasured(str(action), self.space.hands[hand])
                yield action, np.arange(len(codes))[having], targets, costs

    def require_measured(self, code: int) -> None:
        """Raise ModelError if the cost of some action of a state was not measured."""
        for _ in self.edges(self.space.array(code)):
            pass

    def step(self, code: int, text: str) -> tuple[int, tuple[Fraction, ...]] | None:
        """Return an action's successor and costs, in the user's units; None if it is not applicable."""
        for action, having, targets, costs in self.edges(self.space.array(code), kind_of(text)):
            if len(having) and str(action) == text:
                units = [matrix.unit for matrix in self.costs]
                return int(targets[0]), tuple(int(cost[0]) * unit for cost, unit in zip(costs, units, strict=True))
        return None


class Numbering:
    """A two-way map between codes and numbers, which are given in the order in which codes are found."""

    def __init__(self, bound: int) -> None:
        """Begin with no codes; all will be less than a bound."""
        self._layers: list[np.ndarray] = []
        self._count = 0
        self._index = np.full(bound, -1, dtype=np.int32) if bound <= MAX_TABLE_CODES else None
        self._sorted = np.empty(0, dtype=np.int64)
        self._numbers = np.empty(0, dtype=np.int32)

    def __len__(self) -> int:
        """Return the number of codes so far."""
        return self._count

    @property
    def all(self) -> np.ndarray:
        """All codes, by number."""
        return np.concatenate(self._layers)

    def add(self, codes: np.ndarray) -> np.ndarray:
        """Number the codes that are new, in ascending order, and return these."""
        codes = np.unique(codes)
        new = codes[self.number(codes) < 0]
        numbers = np.arange(self._count, self._count + len(new), dtype=np.int32)
        if self._index is not None:
            self._index[new] = numbers
        else:
            places = np.searchsorted(self._sorted, new)
            self._sorted = np.insert(self._sorted, places, new)
            self._numbers = np.insert(self._numbers, places, numbers)
        self._layers.append(new)
        self._count += len(new)
        return new

    def number(self, codes: np.ndarray) -> np.ndarray:
        """Return the numbers of codes, int32, -1 for those not yet added."""
        if self._index is not None:
            return self._index[codes]
        places = np.searchsorted(self._sorted, codes)
        known = places < self._count
        known[known] = self._sorted[places[known]] == codes[known]
        numbers = np.full(len(codes), -1, dtype=np.int32)
        numbers[known] = self._numbers[places[known]]
        return numbers


class ListedStates(OnDemand[ManipulationState]):
    """States by number.

    Attributes:
        codes: (S,) int64, their codes.
    """

    def __init__(self, space: StateCodes, codes: np.ndarray) -> None:
        """Take the codes, which are decoded when they are read."""
        super().__init__(lambda: len(codes), lambda i: space.decode(int(codes[i])))
        self.codes = codes


def reachable(
    generator: Generator,
    known: Sequence[int],
    *,
    names: Collection[str] | None = None,
    canonical: Callable[[np.ndarray], np.ndarray] | None = None,
) -> TransitionSystem:
    """Return every state of a manipulation model reachable from known ones, `ListedStates`, as a transition system.

    Args:
        generator: generates the successors.
        known: codes of the first states, in the order of their numbers; the initial state's first.
        names: the propositions to keep in labels; None for all.
        canonical: maps codes to those of their canonical states; None if all are canonical.

    Raises:
        ModelError: as in `Generator.edges`, or there are too many states for 64-bit integers.
        LimitError: a limit of time or memory was reached.
    """
    space = generator.space
    space.require_small()
    numbers = Numbering(space.bound)
    for code in known:
        numbers.add(np.array([code], dtype=np.int64))
    lists, costs, names_of_actions = _edges(generator, numbers, known, canonical)
    check_limits(EDGE_BYTES * sum(map(len, lists["sources"])))
    source = np.concatenate(lists.pop("sources"))
    order = np.argsort(source, kind="stable")
    columns = [EdgeCosts(matrix.name, np.concatenate(costs.pop(0))[order], matrix.unit) for matrix in generator.costs]
    offsets = np.searchsorted(source[order], np.arange(len(numbers) + 1)).astype(np.int64)
    del source
    codes = numbers.all
    labels, label_sets = _labels(space, codes, names)
    return TransitionSystem(
        states=ListedStates(space, codes),
        start=0,
        offsets=offsets,
        targets=np.concatenate(lists.pop("targets"))[order],
        actions=np.concatenate(lists.pop("actions"))[order],
        costs=columns[0].costs,
        unit=columns[0].unit,
        labels=labels,
        action_names=names_of_actions,
        label_sets=label_sets,
        propositions=space.model.known_propositions,
        cost_name=columns[0].name,
        more_costs=tuple(columns[1:]),
    )


def _edges(
    generator: Generator,
    numbers: Numbering,
    known: Sequence[int],
    canonical: Callable[[np.ndarray], np.ndarray] | None,
) -> tuple[dict[str, list[np.ndarray]], list[list[np.ndarray]], tuple[str, ...]]:
    """Number every state reachable from known ones; return arrays of edges, of costs, and the actions' texts."""
    index: dict[Action, int] = {}
    none = np.empty(0, dtype=np.int32)
    lists = {"sources": [none], "targets": [none], "actions": [none]}
    columns = [[matrix.entries.ravel()[:0]] for matrix in generator.costs]
    layer = np.array(known, dtype=np.int64)
    while len(layer):
        found = []
        for first in range(0, len(layer), CHUNK):
            chunk = layer[first : first + CHUNK]
            sources = numbers.number(chunk)
            for action, having, targets, costs in generator.edges(chunk):
                found.append(targets if canonical is None else canonical(targets))
                lists["sources"].append(sources[having])
                lists["actions"].append(np.full(len(targets), index.setdefault(action, len(index)), dtype=np.int32))
                for column, each in zip(columns, costs, strict=True):
                    column.append(each)
            check_limits()
        check_limits(LAYER_BYTES * sum(map(len, found)))
        layer = numbers.add(np.concatenate([layer[:0], *found]))
        lists["targets"] += map(numbers.number, found)
    return lists, columns, tuple(map(str, index))


def _labels(
    space: StateCodes, codes: np.ndarray, names: Collection[str] | None
) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
    """Return (S,) each state's label, restricted to some names, as an index, and the distinct labels."""
    keys = np.zeros(len(codes), dtype=np.int64)
    weight = 1
    parts: list[tuple[int, list[str]]] = []
    for d, values in space.seen(names):
        distinct_values = list(dict.fromkeys(values))
        keys += weight * np.array([distinct_values.index(value) for value in values])[space.digit(codes, d)]
        parts.append((weight, distinct_values))
        weight *= len(distinct_values)
    distinct, labels = np.unique(keys, return_inverse=True)
    sets = tuple(
        frozenset(name for w, values in parts if (name := values[int(key) // w % len(values)])) for key in distinct
    )
    return labels.astype(np.int32), sets
