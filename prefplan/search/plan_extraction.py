"""From the product states of a path to a plan: the actions between them, and the costs of each task."""

from __future__ import annotations

import heapq
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from prefplan.exact_costs import exact, to_number
from prefplan.ledger import Ledger
from prefplan.models.costs import EdgeCosts
from prefplan.plan import Plan, Purchase
from prefplan.product.contraction import Graph
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.kernels import Integer, kernel
from prefplan.product.product_automaton import Product
from prefplan.product.starts import Start


@dataclass(frozen=True)
class Waypoint:
    """A product state on a path.

    Attributes:
        node: of the graph that was searched.
        automata: (N + R,) states of the automata.
        cost: of the path up to here, as in `Product.costs`.
    """

    node: int
    automata: tuple[int, ...]
    cost: int


def extract(product: Product, graph: Graph, path: Sequence[Waypoint], start: Start) -> tuple[Plan, Any]:
    """Return the plan that visits some product states, and its exact mu, computed anew from the model.

    Args:
        product: what was searched.
        graph: the graph that it was searched over.
        path: product states at which the search made labels, the start's first.
        start: how the path begins.
    """
    if isinstance(product, GeneratedProduct):
        return _extract_generated(product, path, start)
    edges: list[int] = []
    states = [path[0].automata]
    for before, after in zip(path, path[1:], strict=False):
        for edge in _path(product, graph, before, after):
            edges.append(edge)
            states.append(before.automata)
        states[-1] = after.automata
    return account(product, edges, states, start)


def _extract_generated(product: GeneratedProduct, path: Sequence[Waypoint], start: Start) -> tuple[Plan, Any]:
    """Return the same as `extract`, with labels and costs from the problem's own system."""
    actions, states = product.model.lift([waypoint.node for waypoint in path])
    labels, costs = product.problem.system.along(actions)
    return _plan(product, actions, states, labels, costs, [waypoint.automata for waypoint in path], start)


def _path(product: Product, graph: Graph, before: Waypoint, after: Waypoint) -> list[int]:
    """Return the edges of a cheapest path between two waypoints on which no automaton moves before the last edge.

    Ties go to fewer actions, then to the model's order of actions.
    """
    source, target = int(graph.states[before.node]), int(graph.states[after.node])
    edges: list[int] = []
    if _leads(product, int(product.classes[target]), before.automata, after.automata):
        passable = _resting_classes(product, before.automata) & graph.contracted
        limit = after.cost - before.cost
        arrays = product.offsets, product.targets, product.costs, product.classes
        edges = cheapest_path(*arrays, passable, source, target, limit).tolist()
    if not edges:
        raise AssertionError("the search made a step that the model does not have")
    return edges


@kernel
def cheapest_path(
    offsets: np.ndarray,
    targets: np.ndarray,
    costs: np.ndarray,
    classes: np.ndarray,
    passable: np.ndarray,
    source: Integer,
    target: Integer,
    limit: Integer,
) -> np.ndarray:
    """Return the edges of a path of exactly one cost from one state to another; none if there is no such path.

    Args:
        offsets: (S + 1,) int64, where each state's edges begin.
        targets: (E,) int32, where edges lead.
        costs: (E,) int64.
        classes: (S,) int32, of labels.
        passable: (C,) bool, classes of states that the path may pass.
        source: where it begins.
        target: where it ends, with at least one edge.
        limit: cost of the path.
    """
    links, taken = [np.int64(-1)], [np.int64(-1)]
    # Links are numbered as they are made: ties go to the path found first.
    queue = [(np.int64(0), 0, np.int64(0), np.int64(source))]
    passed = {np.int64(-1)}
    while queue:
        cost, length, link, state = heapq.heappop(queue)
        if link > 0:
            if state == target and cost == limit:
                path = np.empty(length, dtype=np.int64)
                for k in range(length - 1, -1, -1):
                    path[k] = taken[link]
                    link = links[link]
                return path
            if state in passed or not passable[classes[state]]:
                continue
            passed.add(state)
        for edge in range(offsets[state], offsets[state + 1]):
            end = np.int64(targets[edge])
            if cost + costs[edge] <= limit and end not in passed:
                links.append(np.int64(link))
                taken.append(np.int64(edge))
                heapq.heappush(queue, (cost + costs[edge], length + 1, np.int64(len(links) - 1), end))
    return np.empty(0, dtype=np.int64)


def _resting_classes(product: Product, automata: tuple[int, ...]) -> np.ndarray:
    """Return the (C,) bool label classes whose free reading leaves all automata in these states."""
    rests: np.ndarray = (product.transitions(automata) == np.array(automata)[:, None]).all(axis=0)
    return rests


def _leads(product: Product, label: int, before: tuple[int, ...], after: tuple[int, ...]) -> bool:
    """Return whether some reading of a label class takes the automata from one combination to another."""
    for i in np.flatnonzero(product.transitions(before)[:, label] != after):
        if i >= len(product.automata):
            return False
        bought = slice(product.extra_first[i, before[i], label], product.extra_first[i, before[i], label + 1])
        if after[i] not in product.extra_state[bought]:
            return False
    return True


def account(
    product: Product, edges: Sequence[int], automata: Sequence[tuple[int, ...]], start: Start
) -> tuple[Plan, Any]:
    """Return the plan of some edges and its exact mu, given the automata's states before and after each."""
    system, taken = product.problem.system.listed, np.array(edges, dtype=np.int64)
    visited = [system.start, *product.targets[taken].tolist()]
    actions = tuple(system.action_names[action] for action in system.actions[taken].tolist())
    states, labels = tuple(system.states[state] for state in visited), [system.label(state) for state in visited]
    costs = [_in_users_units(column, taken) for column in system.edge_costs]
    return _plan(product, actions, states, labels, costs, automata, start)


def _plan(
    product: Product,
    actions: tuple[str, ...],
    states: tuple[Hashable, ...],
    labels: Sequence[frozenset[str]],
    costs: Sequence[tuple[Fraction, ...]],
    automata: Sequence[tuple[int, ...]],
    start: Start,
) -> tuple[Plan, Any]:
    """Return the plan of K actions after the past, and its exact mu.

    Args:
        product: what was searched.
        actions: (K,) in order.
        states: (K + 1,) before the first action and after each.
        labels: (K + 1,) of the states.
        costs: (K,) of the actions, for each of the costs.
        automata: (K + 1,) states of the automata.
        start: how the path begins.
    """
    problem, past = product.problem, product.problem.past
    labels = [*past.labels, *labels]
    purchases = _purchases(product, labels, automata, start)
    first, *more = costs
    actions, first = (*past.actions, *actions), (*map(exact, past.costs), *first)
    ledger = Ledger.of(problem, actions, first, labels, purchases, dict(zip(problem.cost_names[1:], more, strict=True)))
    final = ledger.final
    worth = [to_number(value) for value in ledger.exact_objectives()]
    count = len(problem.cost_names)
    names = [named.name for named in problem.preferences]
    plan = Plan(
        cost=final.cost,
        preference=final.preference,
        task_costs=final.task_costs,
        violation_costs=final.violation_costs,
        actions=ledger.actions,
        states=(*past.states, *states),
        relaxations=tuple(replace(purchase, cost=to_number(exact(purchase.cost))) for purchase in purchases),
        costs=dict(zip(problem.cost_names, worth[:count], strict=True)),
        preferences=dict(zip(names, worth[count:], strict=True)),
        action_costs=tuple(map(to_number, first)),
        map=problem.system.map,
        display=problem.display,
    )
    return plan, ledger.exact_preference()


def _purchases(
    product: Product, labels: Sequence[frozenset[str]], automata: Sequence[tuple[int, ...]], start: Start
) -> list[Purchase]:
    """Return the relaxations bought along a path and the rules broken, in order of steps.

    The labels are those of the past and the path, `automata` the states along the path.
    """
    problem, price, first = product.problem, product.units.price, len(labels) - len(automata)
    found: list[Purchase] = []
    for i, (name, dfa) in enumerate(zip(problem.names, product.automata, strict=True)):
        if start.bought[i] is None:
            found.append(Purchase(name, 0, None, (dfa.skip or 0) * price))
        bought = [*(start.bought[i] or ())]
        steps = zip(automata, automata[1:], labels[first + 1 :], strict=False) if dfa.relaxations else ()
        for k, (before, after, label) in enumerate(steps, start=first + 1):
            readings = dfa.readings(before[i], label)
            reading = next(reading for reading in readings if reading.state == after[i])
            bought += [(k, relaxation) for relaxation in reading.relaxations]
        for k, relaxation in bought:
            assumed, _, count = dfa.relaxations[relaxation]
            found.append(Purchase(name, k, assumed, count * price))
    prices = {rule.name: rule.skip for rule in problem.rules}
    broken = problem.broken(labels).items()
    found += [Purchase(name, step, None, exact(prices[name] or 0), rule=True) for name, step in broken]
    return sorted(found, key=lambda purchase: purchase.step)


def _in_users_units(column: EdgeCosts, edges: np.ndarray) -> tuple[Fraction, ...]:
    """Return the costs of (K,) edges, in the user's units."""
    counts = column.costs[edges].tolist()
    cost_of = {count: count * column.unit for count in set(counts)}
    return tuple(map(cost_of.__getitem__, counts))
