"""Multi-terminal decision diagrams: functions from labels to anything, reduced and shared.

R. E. Bryant, "Graph-Based Algorithms for Boolean Function Manipulation", 1986, with arbitrary leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any


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

    def branch(self, name: str, high: Diagram, low: Diagram) -> Diagram:
        """Return the diagram that decides on a proposition smaller than all those below."""
        if high is low or high == low:
            return high
        key = (name, high, low)
        if key not in self._unique:
            self._unique[key] = Branch(name, high, low)
        return self._unique[key]

    def map(self, diagram: Diagram, function: Callable[[Any], Hashable]) -> Diagram:
        """Return a diagram with a function applied to its leaves."""
        memo: dict[Diagram, Diagram] = {}

        def walk(d: Diagram) -> Diagram:
            if d not in memo:
                memo[d] = self.branch(d.name, walk(d.high), walk(d.low)) if isinstance(d, Branch) else function(d)
            return memo[d]

        return walk(diagram)

    def lift(self, function: Callable[[Any, Any], Hashable]) -> Callable[[Diagram, Diagram], Diagram]:
        """Return a function of two leaves as one of two diagrams."""
        memo: dict[tuple[Diagram, Diagram], Diagram] = {}

        def apply(left: Diagram, right: Diagram) -> Diagram:
            key = (left, right)
            if key not in memo:
                names = [d.name for d in key if isinstance(d, Branch)]
                if names:
                    name = min(names)
                    (a, b), (c, d) = _cofactors(left, name), _cofactors(right, name)
                    memo[key] = self.branch(name, apply(a, c), apply(b, d))
                else:
                    memo[key] = function(left, right)
            return memo[key]

        return apply


def _cofactors(diagram: Diagram, name: str) -> tuple[Diagram, Diagram]:
    if isinstance(diagram, Branch) and diagram.name == name:
        return diagram.high, diagram.low
    return diagram, diagram


def leaf(diagram: Diagram, label: frozenset[str]) -> Any:
    """Return the leaf that a label leads to."""
    while isinstance(diagram, Branch):
        diagram = diagram.high if diagram.name in label else diagram.low
    return diagram


def leaves(diagram: Diagram) -> list[Any]:
    """Return the distinct leaves, in order of first appearance with true before false."""
    found: dict[Any, None] = {}
    seen: set[Diagram] = set()

    def walk(d: Diagram) -> None:
        if d in seen:
            return
        seen.add(d)
        if isinstance(d, Branch):
            walk(d.high)
            walk(d.low)
        else:
            found[d] = None

    walk(diagram)
    return list(found)


Price = tuple[int, int, tuple[int, ...]]
"""What was paid, for how many propositions, and the numbers of the offers taken, in order."""


def cheapest_leaves(diagram: Diagram, label: frozenset[str], offers: Mapping[str, tuple[int, int]]) -> dict[Any, Price]:
    """Return the leaves that a label leads to with some propositions added to it, each at the least price.

    A path asks for every proposition once at most, so that prices add up along it as on a graph: one visit to each
    branch does for all sets of propositions. Ties go to fewer of them, then to the offers that come first.

    Args:
        diagram: what is read.
        label: what holds.
        offers: propositions that may be added, each with its price and the number of the offer.
    """

    @cache
    def walk(d: Diagram) -> dict[Any, Price]:
        if not isinstance(d, Branch):
            return {d: (0, 0, ())}
        if d.name in label:
            return walk(d.high)
        found = dict(walk(d.low))
        if d.name in offers:
            price, offer = offers[d.name]
            for end, (paid, count, taken) in walk(d.high).items():
                dearer = (paid + price, count + 1, tuple(sorted((*taken, offer))))
                found[end] = min(found.get(end, dearer), dearer)
        return found

    return walk(diagram)


def paths(diagram: Diagram) -> Iterator[tuple[dict[str, bool], Any]]:
    """Yield every path from the root as (the propositions it decides, its leaf)."""
    if isinstance(diagram, Branch):
        for value, below in ((True, diagram.high), (False, diagram.low)):
            for guard, end in paths(below):
                yield {diagram.name: value} | guard, end
    else:
        yield {}, diagram


def same(one: Diagram, other: Diagram) -> bool:
    """Return whether two diagrams, perhaps of different families, are the same function."""
    compared: set[tuple[int, int]] = set()
    waiting = [(one, other)]
    while waiting:
        a, b = waiting.pop()
        if isinstance(a, Branch) and isinstance(b, Branch) and a.name == b.name:
            if (id(a), id(b)) not in compared:
                compared.add((id(a), id(b)))
                waiting += [(a.high, b.high), (a.low, b.low)]
        elif isinstance(a, Branch) or isinstance(b, Branch) or a != b:
            return False
    return True
