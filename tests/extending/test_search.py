"""A search of one's own, from outside: every path up to a cost is tried. It is slower, and agrees."""

from __future__ import annotations

from fractions import Fraction

import prefplan as pp


def front_by_trying_everything(problem: pp.Problem, max_cost: int) -> list[tuple[int | float, int | float]]:
    """Return the non-dominated (cost, mu) of all paths that satisfy the tasks; costs must be positive."""
    system, dfas, found = problem.system, problem.automata, []
    first = tuple(dfa.step(0, system.label(system.start)) for dfa in dfas)
    pending = [
        (
            system.start,
            first,
            Fraction(0),
            tuple(0 if q == d.accepting else None for q, d in zip(first, dfas, strict=True)),
        )
    ]
    while pending:
        state, automata, cost, done = pending.pop()
        if None not in done:
            found.append((cost, problem.measure.value([Fraction(c) for c in done], [Fraction(0)] * len(done))))
            continue
        for edge in system.edges(state):
            target, spent = int(system.targets[edge]), cost + Fraction(system.cost(edge))
            label = system.label(target)
            after = tuple(dfa.step(q, label) for dfa, q in zip(dfas, automata, strict=True))
            costs = tuple(
                spent if c is None and q == d.accepting else c for c, q, d in zip(done, after, dfas, strict=True)
            )
            if spent <= max_cost:
                pending.append((target, after, spent, costs))
    best: list[tuple[Fraction, Fraction]] = []
    for cost, mu in sorted(found):
        if not best or mu < best[-1][1]:
            best.append((cost, mu))
    return [(float(cost), float(mu)) for cost, mu in best]


def test_a_search_from_outside_agrees() -> None:
    grid = pp.GridModel((3, 3), (0, 0), regions={"a": [(2, 0, 2, 0)], "b": [(0, 2, 0, 2)], "c": [(2, 2, 2, 2)]})
    tasks = [pp.Task("one", "F (c & F a)"), pp.Task("two", "F b")]
    problem = pp.Problem(grid.transition_system(), tasks, pp.Order())
    front = [(plan.cost, plan.preference) for plan in pp.pareto_front(problem)]
    assert len(front) == 2
    assert front_by_trying_everything(problem, max_cost=10) == front
