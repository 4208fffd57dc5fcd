"""The exact Pareto front of a small problem by exhaustive search, with no pruning that needs a contract.

A label is (product state, every cost so far, the same when each task was satisfied, violation costs). Only these are
pruned:

- exact duplicates, and labels equal to another in all but higher violation costs (mu never falls in a violation cost);
- labels with no objective better than some plan's: none falls along a trajectory;
- labels that cannot reach the end of any plan within the cost bound, by exact distances in the product.

So the answer is exact for every mu that never falls along a trajectory, up to the bound.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import combinations, count, product
from operator import add, le
from typing import NamedTuple

from judge.preferences import Mu, Number, Values
from judge.problems import GraphProblem, JudgedTask
from judge.semantics import Label, holds_now, monitor

#: In place of a monitor's state: the task is satisfied, or was skipped.
DONE, SKIPPED = -1, -2

Node = tuple[str, tuple[int, ...]]
Use = tuple[int, str, Number]
Reading = tuple[int, tuple[tuple[str, Number], ...]]


class Move(NamedTuple):
    """An action with one way of reading the label it leads to; `uses` are (task, assumed proposition, price)."""

    cost: Number
    action: str
    node: Node
    uses: tuple[Use, ...]


class Skip(NamedTuple):
    """A task dropped before the first action."""

    task: int
    cost: Number


class Product:
    """The reachable part of graph x monitors, made on demand, and the exact distance of each node to a plan's end."""

    def __init__(self, problem: GraphProblem) -> None:
        """Build every reachable node."""
        self.problem = problem
        self._readings: dict[tuple[int, int, Label], list[Reading]] = {}
        self.starts = list(self._starts())
        self.moves: dict[Node, list[Move]] = {}
        pending = [move.node for _, move in self.starts]
        while pending:
            node = pending.pop()
            if node not in self.moves:
                self.moves[node] = [] if self.finished(node) else list(self._moves(node))
                pending.extend(move.node for move in self.moves[node])
        self.distance = self._distances()

    def finished(self, node: Node) -> bool:
        """Say whether a plan ends here: every task not skipped is satisfied."""
        return node[0] not in self.problem.bygone and all(state < 0 for state in node[1])

    def _starts(self) -> Iterator[tuple[tuple[Skip, ...], Move]]:
        tasks = self.problem.tasks
        skippable = [Skip(k, task.skip) for k, task in enumerate(tasks) if task.skip is not None]
        for size in range(len(skippable) + 1):
            for skips in combinations(skippable, size):
                dropped = {skip.task for skip in skips}
                before = tuple(SKIPPED if k in dropped else monitor(t.formula).start for k, t in enumerate(tasks))
                for move in self._read(before, self.problem.start, 0, ""):
                    yield skips, move

    def _moves(self, node: Node) -> Iterator[Move]:
        for edge in self.problem.outgoing.get(node[0], []):
            yield from self._read(node[1], edge.target, edge.cost, edge.action)

    def _read(self, states: tuple[int, ...], target: str, cost: Number, action: str) -> Iterator[Move]:
        label = self.problem.label(target)
        for chosen in product(*(self._readings_of(k, state, label) for k, state in enumerate(states))):
            uses = tuple((k, *entry) for k, (_, entries) in enumerate(chosen) for entry in entries)
            yield Move(cost, action, (target, tuple(state for state, _ in chosen)), uses)

    def _readings_of(self, k: int, state: int, label: Label) -> list[Reading]:
        key = (k, state, label)
        if key not in self._readings:
            self._readings[key] = list(readings(self.problem.tasks[k], state, label).items())
        return self._readings[key]

    def _distances(self) -> dict[Node, Number]:
        into: dict[Node, list[tuple[Number, Node]]] = {}
        for node, moves in self.moves.items():
            for move in moves:
                into.setdefault(move.node, []).append((move.cost, node))
        distance: dict[Node, Number] = {}
        heap: list[tuple[Number, Node]] = [(0, node) for node in self.moves if self.finished(node)]
        heapq.heapify(heap)
        while heap:
            far, node = heapq.heappop(heap)
            if node not in distance:
                distance[node] = far
                for cost, source in into.get(node, []):
                    heapq.heappush(heap, (far + cost, source))
        return distance


def readings(task: JudgedTask, state: int, label: Label) -> dict[int, tuple[tuple[str, Number], ...]]:
    """Return the states one task may be in after reading a label, each with the cheapest relaxations for it."""
    if state < 0:
        return {state: ()}
    judge = monitor(task.formula)
    usable = [entry for entry in task.relax if entry.assume not in label and holds_now(entry.when, label)]
    found: dict[int, tuple[tuple[str, Number], ...]] = {}
    for size in range(len(usable) + 1):
        for chosen in combinations(usable, size):
            assumed = {entry.assume for entry in chosen}
            after = judge.step(state, label | assumed)
            reached = DONE if judge.satisfied(after) else after
            entries = tuple((entry.assume, entry.cost) for entry in chosen)
            if len(assumed) == size and (reached not in found or _price(entries) < _price(found[reached])):
                found[reached] = entries
    return found


def _price(entries: tuple[tuple[str, Number], ...]) -> Number:
    return sum(cost for _, cost in entries)


@lru_cache(maxsize=1)
def explored(problem: GraphProblem) -> Product:
    """Return the product of a problem; the last one is cached for the next call."""
    return Product(problem)


def cheapest_cost(problem: GraphProblem) -> Number | None:
    """Return the least total cost of a plan, or None when there is no plan."""
    space = explored(problem)
    return min((space.distance[m.node] for _, m in space.starts if m.node in space.distance), default=None)


class TooManyError(Exception):
    """There are more labels than the judge's limit."""


def exact_front(
    problem: GraphProblem, mu: Mu | None = None, *, max_cost: Number, max_labels: float = math.inf
) -> list[tuple[Number, Number]]:
    """Return the non-dominated (cost, mu) of cost at most `max_cost`, by rising cost.

    Args:
        problem: the problem.
        mu: preference function of (task costs, violation costs) that never falls along a trajectory, nor in a
            violation cost; the problem's own when None.
        max_cost: greatest total cost, in the user's units, inclusive.
        max_labels: labels to make at the most.

    Raises:
        TooManyError: there would be more.
    """
    value = mu or problem.mu()

    def worth(spent: Values, ends: Sequence[Values], paid: Values) -> Values:
        return spent[0], value(tuple(end[0] for end in ends), paid)

    points = undominated(explored(problem), worth, limits=(max_cost,), max_labels=max_labels)
    return [(point[0], point[1]) for point in points]


def undominated(
    space: Product,
    worth: Callable[[Values, Sequence[Values], Values], Values],
    *,
    limits: Values,
    prices: Callable[[Node, Move], Values] = lambda node, move: (move.cost,),
    max_labels: float = math.inf,
) -> list[Values]:
    """Return every non-dominated worth of a plan, by rising sum of costs.

    Args:
        space: the product, with the distances in the first cost.
        worth: objectives, given every total cost, the same when each task was satisfied (or now), and violation costs;
            none falls along a trajectory, nor in a violation cost.
        limits: greatest costs, inclusive.
        prices: every cost of a move.
        max_labels: labels to make at the most.

    Raises:
        TooManyError: there would be more.
    """
    ticket, tasks = count(), len(space.problem.tasks)
    heap: list[tuple[Number, int, Node, Values, tuple[Values | None, ...], Values]] = []
    seen: dict[tuple[Node, tuple[Values | None, ...], Values], list[Values]] = {}

    def push(spent: Values, frozen: tuple[Values | None, ...], paid: Values, move: Move) -> None:
        node = move.node
        if node not in space.distance or spent[0] + space.distance[node] > limits[0] or not no_worse(spent, limits):
            return
        ends = tuple(spent if end is None and q == DONE else end for end, q in zip(frozen, node[1], strict=True))
        owed = list(paid)
        for task, _, price in move.uses:
            owed[task] += price
        rivals = seen.setdefault((node, ends, spent), [])
        if any(no_worse(rival, owed) for rival in rivals):
            return
        rivals.append(tuple(owed))
        if len(seen) > max_labels:
            raise TooManyError
        heapq.heappush(heap, (sum(spent), next(ticket), node, spent, ends, tuple(owed)))

    for skips, move in space.starts:
        skipped = {skip.task: skip.cost for skip in skips}
        paid = tuple(skipped.get(k, 0) for k in range(tasks))
        push((0,) * len(limits), (None,) * tasks, paid, move)
    front: list[Values] = []
    while heap:
        _, _, node, spent, frozen, paid = heapq.heappop(heap)
        now = worth(spent, [spent if end is None else end for end in frozen], paid)
        if any(no_worse(point, now) for point in reversed(front)):
            continue
        if space.finished(node):
            front = [point for point in front if not no_worse(now, point)] + [now]
            continue
        for move in space.moves[node]:
            after = tuple(map(add, spent, prices(node, move)))
            push(after, frozen, paid, move)
    return front


def no_worse(one: Sequence[Number], other: Sequence[Number]) -> bool:
    """Return whether no entry exceeds that of another vector."""
    return all(map(le, one, other))
