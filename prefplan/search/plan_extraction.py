"""Plans of paths, with all their values computed again from the model, and the edges of a path between two nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from prefplan.exact_costs import exact, to_number
from prefplan.ledger import Ledger
from prefplan.plan import Plan, Purchase
from prefplan.product.contraction import Graph, cheapest_paths
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
    least, last = np.empty((2, len(product.classes)), dtype=np.int64)
    source, state = int(graph.states[before]), int(graph.states[after])
    arrays = product.offsets, product.targets, product.costs, (rests & graph.contracted)[product.classes]
    cheapest_paths(*arrays, source, state, cost, least, last)
    assert least[state] == cost, "the search made a step that the model does not have"
    edges = list[int]()
    while not edges or state != source:
        edges.append(int(last[state]))
        state = int(np.searchsorted(product.offsets, edges[-1], side="right")) - 1
    return edges[::-1]
