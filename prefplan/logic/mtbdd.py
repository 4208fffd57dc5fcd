"""Multi-terminal decision diagrams: functions from labels to arbitrary values, reduced and shared.

R. E. Bryant, "Graph-Based Algorithms for Boolean Function Manipulation", 1986, with arbitrary leaves.

A diagram is as deep as its number of propositions, which may be thousands; so nothing here recurses.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

from prefplan.limits import check_limits

CHECKED_EVERY = 256
"""Number of steps between two checks of the limits."""


@dataclass(frozen=True, eq=False)
class Branch:
    """Decision on one proposition; `high` where it is true, `low` where it is not.

    Made by `Diagrams.branch` only, so that equal functions are one object and compare by identity.
    """

    name: str
    high: Diagram
    low: Diagram


Diagram = Branch | Hashable


class Diagrams:
    """A family of diagrams over propositions ordered by name, in which equal functions are the same object."""

    def __init__(self) -> None:
        """Start an empty family."""
        self._unique: dict[tuple[str, Diagram, Diagram], Branch] = {}
        self._made = 0

    def branch(self, name: str, high: Diagram, low: Diagram) -> Diagram:
        """Return the diagram that decides on a proposition, which must precede all those below it."""
        self._made += 1
        if not self._made % CHECKED_EVERY:
            check_limits()
        if high is low or high == low:
            return high
        key = (name, high, low)
        if key not in self._unique:
            self._unique[key] = Branch(name, high, low)
        return self._unique[key]

    def map(self, diagram: Diagram, function: Callable[[Any], Hashable]) -> Diagram:
        """Return a diagram with a function applied to its leaves, in the order of `leaves`."""
        mapped: dict[Diagram, Diagram] = {}
        for d in upwards(diagram):
            mapped[d] = self.branch(d.name, mapped[d.high], mapped[d.low]) if isinstance(d, Branch) else function(d)
        return mapped[diagram]

    def lift(self, function: Callable[[Any, Any], Hashable]) -> Callable[..., Diagram]:
        """Extend a function of two leaves to two diagrams or, if it is associative, to any number of diagrams."""
        memo: dict[tuple[Diagram, Diagram], Diagram] = {}

        def join(left: Diagram, right: Diagram) -> Diagram:
            pending = [(left, right)]
            while pending:
                pair = pending[-1]
                names = [d.name for d in pair if isinstance(d, Branch)]
                if pair in memo:
                    pending.pop()
                elif not names:
                    memo[pair] = function(*pair)
                else:
                    name = min(names)
                    (a, b), (c, d) = cofactors(pair[0], name), cofactors(pair[1], name)
                    if (a, c) not in memo:
                        pending.append((a, c))
                    elif (b, d) not in memo:
                        pending.append((b, d))
                    else:
                        memo[pair] = self.branch(name, memo[a, c], memo[b, d])
            return memo[left, right]

        def apply(*diagrams: Diagram) -> Diagram:
            # Join pairs, then pairs of the results: joining thousands one after the other takes quadratic time.
            while len(diagrams) > 1:
                diagrams = tuple(reduce(join, diagrams[k : k + 2]) for k in range(0, len(diagrams), 2))
            return diagrams[0]

        return apply


def cofactors(diagram: Diagram, name: str) -> tuple[Diagram, Diagram]:
    """Return the cofactors of a diagram for a proposition, true and false, that is not after its first one."""
    if isinstance(diagram, Branch) and diagram.name == name:
        return diagram.high, diagram.low
    return diagram, diagram


def leaf(diagram: Diagram, label: frozenset[str]) -> Any:
    """Return the leaf that a label leads to."""
    while isinstance(diagram, Branch):
        diagram = diagram.high if diagram.name in label else diagram.low
    return diagram


def upwards(diagram: Diagram) -> list[Diagram]:
    """Return every node of a diagram once, after all its descendants: first those of `high`, then those of `low`."""
    nodes: dict[Diagram, None] = {}
    pending = [diagram]
    while pending:
        d = pending[-1]
        if isinstance(d, Branch) and d.high not in nodes:
            pending.append(d.high)
        elif isinstance(d, Branch) and d.low not in nodes:
            pending.append(d.low)
        else:
            nodes[pending.pop()] = None
    return list(nodes)


def leaves(diagram: Diagram) -> list[Any]:
    """Return the distinct leaves, in order of first appearance with true before false."""
    return [d for d in upwards(diagram) if not isinstance(d, Branch)]


Price = tuple[int, int, tuple[int, ...]]
"""A sum of prices, the number of offers in it, and the numbers of these offers, sorted."""


def cheapest_leaves(diagram: Diagram, label: frozenset[str], offers: Mapping[str, tuple[int, int]]) -> dict[Any, Price]:
    """Return the leaves that a label leads to if propositions may be added to it, each with the least price.

    A path decides on every proposition at most once, so prices add up along it, and one visit to each branch covers all
    sets of propositions. Ties go to fewer propositions, then to the offers that come first.

    `offers` are the propositions, not in the label, that may be added, each with its price and the offer's number.
    """
    cheapest: dict[Diagram, Price] = {diagram: (0, 0, ())}

    def reach(node: Diagram, price: Price) -> None:
        cheapest[node] = min(price, cheapest.get(node, price))

    for d in reversed(upwards(diagram)):
        if isinstance(d, Branch) and d in cheapest:
            total, count, taken = cheapest.pop(d)
            reach(d.high if d.name in label else d.low, (total, count, taken))
            if d.name in offers:
                price, offer = offers[d.name]
                reach(d.high, (total + price, count + 1, tuple(sorted((*taken, offer)))))
    return cheapest


def paths(diagram: Diagram) -> Iterator[tuple[dict[str, bool], Any]]:
    """Yield every path from the root as (the propositions it decides, its leaf)."""
    pending: list[tuple[dict[str, bool], Diagram]] = [({}, diagram)]
    while pending:
        guard, d = pending.pop()
        if isinstance(d, Branch):
            pending += [(guard | {d.name: False}, d.low), (guard | {d.name: True}, d.high)]
        else:
            yield guard, d


def same(one: Diagram, other: Diagram) -> bool:
    """Return whether two diagrams, perhaps of different families, represent the same function."""
    return _numbered(one) == _numbered(other)


def _numbered(diagram: Diagram) -> list[Hashable]:
    """Return the nodes of a diagram, with branches as (name, numbers of both successors)."""
    number = {d: k for k, d in enumerate(upwards(diagram))}
    return [(d.name, number[d.high], number[d.low]) if isinstance(d, Branch) else d for d in number]
