"""From product states back to a plan: the actions between them, and what was spent on each task."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from prefplan.front import Plan, Purchase
from prefplan.graph import Graph
from prefplan.product import Product, Start
from prefplan.quanta import to_number


@dataclass(frozen=True)
class Waypoint:
    """A product state on a path.

    Attributes:
        node: of the graph that was searched.
        automata: states of the tasks' automata.
        cost: of the label made there, as in `Product.costs`.
    """

    node: int
    automata: tuple[int, ...]
    cost: int


def extract(product: Product, graph: Graph, path: Sequence[Waypoint], start: Start) -> Plan:
    """Return the plan that visits some product states, with its costs worked out afresh from the model.

    Args:
        product: what was searched.
        graph: over what.
        path: product states at which the search made labels, the start's first.
        start: how the path begins.
    """
    edges: list[int] = []
    states = [path[0].automata]
    for before, after in zip(path, path[1:], strict=False):
        for edge in _way(product, graph, before, after):
            edges.append(edge)
            states.append(before.automata)
        states[-1] = after.automata
    return _account(product, edges, states, start)


def _way(product: Product, graph: Graph, before: Waypoint, after: Waypoint) -> list[int]:
    """Return the edges of a cheapest way between two waypoints on which no automaton moves before the last edge.

    Ties go to fewer actions, then to the model's order of actions.
    """
    offsets, targets, costs, classes = product.offsets, product.targets, product.costs, product.classes
    source, target = int(graph.states[before.node]), int(graph.states[after.node])
    limit = after.cost - before.cost
    rests = _resting_classes(product, before.automata).tolist()
    arrives = _leads(product, int(classes[target]), before.automata, after.automata)
    links: list[tuple[int, int]] = []
    queue: list[tuple[int, int, int, int]] = [(0, 0, -1, source)]
    passed: set[int] = set()
    while queue:
        cost, length, link, state = heapq.heappop(queue)
        if link >= 0:
            if state == target and cost == limit and arrives:
                way = []
                while link >= 0:
                    link, edge = links[link]
                    way.append(edge)
                return way[::-1]
            if state in passed or not graph.contracted or not rests[classes[state]]:
                continue
            passed.add(state)
        first, last = int(offsets[state]), int(offsets[state + 1])
        ways = zip(costs[first:last].tolist(), targets[first:last].tolist(), strict=True)
        for edge, (step, end) in enumerate(ways, first):
            if cost + step <= limit and end not in passed:
                links.append((link, edge))
                heapq.heappush(queue, (cost + step, length + 1, len(links) - 1, end))
    raise AssertionError("the search made a step that the model does not have")


def _resting_classes(product: Product, automata: tuple[int, ...]) -> np.ndarray:
    """Return the (C,) bool label classes on whose free reading all automata rest."""
    rests = np.ones(product.delta.shape[2], dtype=bool)
    for i, q in enumerate(automata):
        rests &= product.delta[i, q] == q
    return rests


def _leads(product: Product, label: int, before: tuple[int, ...], after: tuple[int, ...]) -> bool:
    """Return whether some reading of a label class takes the automata from one combination to another."""
    for i, (q, then) in enumerate(zip(before, after, strict=True)):
        bought = slice(product.extra_first[i, q, label], product.extra_first[i, q, label + 1])
        if product.delta[i, q, label] != then and then not in product.extra_state[bought]:
            return False
    return True


def _account(product: Product, edges: list[int], states: list[tuple[int, ...]], start: Start) -> Plan:
    """Return the plan of some edges, given the automata's states before and after each."""
    problem, system = product.problem, product.problem.system
    names = problem.names
    quantum = Fraction(1, 10**problem.decimals)
    steps = [(int(product.costs[edge]) >> product.shift) * product.unit for edge in edges]
    spent = np.cumsum([0, *steps], dtype=object)
    task_costs, violations = [], [Fraction(0)] * len(names)
    purchases: list[Purchase] = []
    for i, (name, dfa) in enumerate(zip(names, product.automata, strict=True)):
        accepting = dfa.automaton.accepting
        done = next((k for k, automata in enumerate(states) if automata[i] == accepting), len(states) - 1)
        task_costs.append(spent[done] * quantum)
        bought = start.bought[i]
        if bought is None:
            price = Fraction(dfa.skip or 0) * quantum
            purchases.append(Purchase(name, 0, None, to_number(price)))
            violations[i] += price
        for k, automata in enumerate(states if dfa.relaxations else states[:1]):
            if k > 0:
                label = system.label(int(product.targets[edges[k - 1]]))
                readings = dfa.readings(states[k - 1][i], label)
                bought = next(r.bought for r in readings if r.state == automata[i])
            for relaxation in bought or ():
                assumed, _, quanta = dfa.relaxations[relaxation]
                purchases.append(Purchase(name, k, assumed, to_number(quanta * quantum)))
                violations[i] += quanta * quantum
    visited = [system.start, *(int(product.targets[edge]) for edge in edges)]
    return Plan(
        cost=to_number(Fraction(spent[-1]) * quantum),
        preference=to_number(problem.measure.value(task_costs, violations)),
        task_costs={name: to_number(cost) for name, cost in zip(names, task_costs, strict=True)},
        violation_costs={name: to_number(cost) for name, cost in zip(names, violations, strict=True)},
        actions=tuple(system.action_names[system.actions[edge]] for edge in edges),
        states=tuple(system.states[state] for state in visited),
        relaxations=tuple(sorted(purchases, key=lambda p: p.step)),
    )
