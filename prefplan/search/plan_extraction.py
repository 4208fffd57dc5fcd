"""Plans of paths, with all their values computed again from the model, and the edges of a path between two nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from prefplan.exact_costs import exact, to_number
from prefplan.ledger import Ledger
from prefplan.models.kernels import Integer, kernel
from prefplan.plan import Plan, Purchase
from prefplan.product.contraction import Graph
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.product_automaton import Product
from prefplan.product.starts import Start


def plan_of(product: Product, steps: np.ndarray, automata: Sequence[tuple[int, ...]], start: Start) -> Plan:
    """Return the plan of a path, all its values computed again from the model.

    Args:
        product: what was searched.
        steps: (K,) the path, as for `Product.trajectory`.
        automata: (K + 1,) states of the automata.
        start: how the path begins.
    """
    problem, past = product.problem, product.problem.past
    actions, states, labels, (first, *more) = product.trajectory(steps)
    labels = [*past.labels, *labels]
    purchases = _purchases(product, labels, automata, start)
    actions, first = (*past.actions, *actions), (*map(exact, past.costs), *first)
    ledger = Ledger.of(problem, actions, first, labels, purchases, dict(zip(problem.cost_names[1:], more, strict=True)))
    final = ledger.final
    values = [to_number(value) for value in ledger.exact_objectives()]
    count = len(problem.cost_names)
    names = [named.name for named in problem.preferences]
    return Plan(
        cost=final.cost,
        preference=final.preference,
        task_costs=final.task_costs,
        violation_costs=final.violation_costs,
        actions=ledger.actions,
        states=(*past.states, *states),
        relaxations=tuple(replace(purchase, cost=to_number(exact(purchase.cost))) for purchase in purchases),
        costs=dict(zip(problem.cost_names, values[:count], strict=True)),
        preferences=dict(zip(names, values[count:], strict=True)),
        action_costs=tuple(map(to_number, first)),
        map=problem.system.map,
        display=problem.display,
    )


def _purchases(
    product: Product, labels: Sequence[frozenset[str]], automata: Sequence[tuple[int, ...]], start: Start
) -> list[Purchase]:
    """Return the relaxations relaxed along a path and the rules broken, in order of steps.

    The labels are those of the past and the path, `automata` the states along the path.
    """
    problem, price, first = product.problem, product.units.price, len(labels) - len(automata)
    purchases: list[Purchase] = []
    for i, (name, dfa) in enumerate(zip(problem.names, product.automata, strict=True)):
        if start.relaxed[i] is None:
            purchases.append(Purchase(name, 0, None, (dfa.skip or 0) * price))
        relaxed = [*(start.relaxed[i] or ())]
        steps = zip(automata, automata[1:], labels[first + 1 :], strict=False) if dfa.relaxations else ()
        for k, (before, after, label) in enumerate(steps, start=first + 1):
            readings = dfa.readings(before[i], label)
            reading = next(reading for reading in readings if reading.state == after[i])
            relaxed += [(k, relaxation) for relaxation in reading.relaxations]
        for k, relaxation in relaxed:
            assumed, _, count = dfa.relaxations[relaxation]
            purchases.append(Purchase(name, k, assumed, count * price))
    prices = {rule.name: rule.skip for rule in problem.rules}
    broken = problem.broken(labels).items()
    purchases += [Purchase(name, step, None, exact(prices[name] or 0), rule=True) for name, step in broken]
    return sorted(purchases, key=lambda purchase: purchase.step)


def edges_between(
    product: Product, graph: Graph, before: int, after: int, automata: tuple[int, ...], cost: int
) -> list[int]:
    """Return the edges of a path of one cost between two nodes on which no automaton moves before the last edge.

    Ties go to fewer actions, then to the model's order of actions. The nodes `before` and `after` are of the graph that
    was searched; `automata` are their states before, and the cost is as in `Product.costs`.
    """
    rests = (product.transitions(automata) == np.array(automata)[:, None]).all(axis=0)
    arrays = product.offsets, product.targets, product.costs, product.classes
    ends = int(graph.states[before]), int(graph.states[after])
    edges: list[int] = cheapest_path(*arrays, rests & graph.contracted, *ends, cost).tolist()
    assert edges, "the search made a step that the model does not have"
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
    # A link of a path has a number, an edge and the link before it. Of equal costs the heap has the largest item first,
    # so that ties go to the link made first. A state is left at most once, the source perhaps twice.
    most = 2 * targets.shape[0]
    edges, before = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    costs_so_far, links = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    passed = np.zeros(classes.shape[0], dtype=np.bool_)
    waiting: Integer = np.int64(0)
    state, link, cost, made = np.int64(source), np.int64(-1), np.int64(0), np.int64(0)
    while True:
        for edge in range(offsets[state], offsets[state + 1]):
            if cost + costs[edge] <= limit and not passed[targets[edge]]:
                edges[made], before[made] = edge, link
                waiting = heap_push(costs_so_far, links, waiting, cost + costs[edge], -made, None)
                made += 1
        while waiting > 0:
            cost, link = costs_so_far[0], -links[0]
            waiting = heap_pop(costs_so_far, links, waiting, None)
            state = np.int64(targets[edges[link]])
            if state == target and cost == limit:
                return _edges_to(link, edges, before)
            if passable[classes[state]] and not passed[state]:
                break
        else:
            return np.empty(0, dtype=np.int64)
        passed[state] = True


@kernel
def _edges_to(link: Integer, edges: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return the edges of the path that ends with a link."""
    length, at = 0, link
    while at >= 0:
        length, at = length + 1, before[at]
    path = np.empty(length, dtype=np.int64)
    for k in range(length - 1, -1, -1):
        path[k], link = edges[link], before[link]
    return path
