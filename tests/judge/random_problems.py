"""Small random planning problems that reveal wrong dominance, semantics or accounting."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from judge.preferences import exact, random_preference
from judge.problems import Edge, GraphProblem, JudgedTask, Relaxation, grid_problem
from judge.semantics import monitor
from judge.syntax import Formula, parse, random_boolean, random_formula


def random_problem(
    seed: int,
    *,
    kind: str = "order",
    tasks: int | None = None,
    relaxed: bool = False,
    decimals: int = 0,
    depth: int = 3,
) -> GraphProblem:
    """Draw a problem with 3 to 7 states: zero-cost edges, self-loops, dead ends, several propositions a state.

    Most tasks can be satisfied alone, but not at the start; together they need not be feasible.

    Args:
        seed: the same seed gives the same problem.
        kind: kind of the preference; over violations when `relaxed` (then `weighted-sum`, `max` or `sum`).
        tasks: number of tasks; None to draw 2 or 3.
        relaxed: whether tasks have relaxations and may be skipped.
        decimals: decimal places that costs may have.
        depth: greatest depth of a task's formula.
    """
    rng = random.Random(f"{seed} {kind} {relaxed}")
    atoms = ["a", "b", "c"][: rng.choice((2, 3, 3))]
    density = rng.choice((0.2, 0.3, 0.4))
    moves = _diamonds(rng) if rng.random() < 0.4 else _tangle(rng)
    states = ["s0", *dict.fromkeys(target for _, _, target in moves if target != "s0")]
    costs = rng.choice(((0, 1, 1, 2, 3, 5), (1, 1, 2, 5, 9, 20), (0, 1)))
    edges: dict[tuple[str, str], Edge] = {}
    for source, action, target in moves:
        cost = Fraction(rng.choice(costs) * 10**decimals + _digits(rng, decimals), 10**decimals)
        edges.setdefault((source, action), Edge(source, action, exact(cost), target))
    labels = {state: frozenset(p for p in atoms if rng.random() < density) for state in states}
    graph = GraphProblem(
        start="s0",
        edges=tuple(edges.values()),
        labels={state: label for state, label in labels.items() if label},
        tasks=(),
    )
    names = [f"phi{k + 1}" for k in range(tasks or rng.choice((2, 2, 3)))]
    return replace(
        graph,
        tasks=tuple(_random_task(rng, graph, name, atoms, depth, relaxed) for name in names),
        preference=random_preference(rng, names, kind, "violation" if relaxed else "cost"),
    )


def random_errands(seed: int, kind: str) -> GraphProblem:
    """Draw three errands on a narrow grid of uneven ground, where doing a task early is a long detour."""
    rng = random.Random(f"errands {seed} {kind}")
    size = (rng.randint(5, 8), rng.choice((2, 2, 3)))
    cells = [(x, y) for x in range(size[0]) for y in range(size[1])]
    regions = {name: (x, y, x, y) for name, (x, y) in zip("abcde", rng.sample(cells, 5), strict=True)}
    tasks = [JudgedTask(f"phi{k + 1}", parse(_random_visits(rng))) for k in range(3)]
    preference = random_preference(rng, [task.name for task in tasks], kind)
    grid = grid_problem(size, rng.choice(cells), regions, tasks, preference)
    ground = rng.choice(((1,), (0, 1, 1, 2), (1, 1, 2, 5)))
    return replace(grid, edges=tuple(replace(edge, cost=rng.choice(ground)) for edge in grid.edges))


def _random_visits(rng: random.Random) -> str:
    p, q, r = rng.sample("abcde", 3)
    if rng.random() < 0.1:
        return f"(!{p} U {q}) & F ({q} & F {r})"
    return rng.choice((f"F ({p} & F {q})", f"F ({p} & (F {q} & F {r}))"))


def _tangle(rng: random.Random) -> list[tuple[str, str, str]]:
    """Draw (source, action, target) of a graph in which every state can be reached."""
    states = [f"s{k}" for k in range(rng.randint(3, 7))]
    moves = [(rng.choice(states[: k + 1]), target, target) for k, target in enumerate(states[1:])]
    return moves + _detours(rng, states, rng.randint(len(states) // 2, 2 * len(states)))


def _diamonds(rng: random.Random) -> list[tuple[str, str, str]]:
    """Draw a chain of forks that join again: paths that differ only before the join, where dominance is decided."""
    states = [f"s{k}" for k in range(rng.choice((4, 7, 7)))]
    moves = []
    for k in range(0, len(states) - 1, 3):
        fork, upper, lower, joint = states[k : k + 4]
        moves += [(fork, upper, upper), (fork, lower, lower), (upper, joint, joint), (lower, joint, joint)]
    return moves + _detours(rng, states, rng.choice((0, 0, 1, 3)))


def _detours(rng: random.Random, states: Sequence[str], number: int) -> list[tuple[str, str, str]]:
    pairs = [(rng.choice(states), rng.choice(states)) for _ in range(number)]
    return [(source, rng.choice((target, "go", "turn", "wait")), target) for source, target in pairs]


def _digits(rng: random.Random, decimals: int) -> int:
    return rng.randrange(10**decimals) if decimals and rng.random() < 0.7 else 0


def _random_task(
    rng: random.Random, graph: GraphProblem, name: str, atoms: Sequence[str], depth: int, relaxed: bool
) -> JudgedTask:
    for _ in range(40):
        formula = _random_errand(rng, atoms) if rng.random() < 0.5 else random_formula(rng, atoms, depth)
        if rng.random() < 0.05 or _is_worth_doing(graph, formula):
            break
    if not relaxed:
        return JudgedTask(name, formula)
    entries = tuple(
        Relaxation(rng.choice(atoms), random_boolean(rng, atoms, rng.choice((0, 1))), rng.choice((0, 1, 2, 3, 5)))
        for _ in range(rng.choice((0, 1, 1, 2)))
    )
    return JudgedTask(name, formula, entries, rng.choice((None, None, rng.randint(0, 12))))


def _random_errand(rng: random.Random, atoms: Sequence[str]) -> Formula:
    """Draw a formula of a common kind: visits in sequence, avoidance until a visit, a visit right after another."""
    p, q, r = (("ap", rng.choice(atoms)) for _ in range(3))
    avoid: Formula = ("U", ("not", p), q)
    return rng.choice(
        (
            ("F", p),
            ("F", ("and", p, ("F", q))),
            ("F", ("and", p, ("F", ("and", q, ("F", r))))),
            ("F", ("and", p, ("X", q))),
            ("X", ("F", ("and", p, ("X", ("F", p))))),
            avoid,
            ("and", avoid, ("F", r)),
            ("and", ("F", p), ("F", q)),
            ("U", ("implies", p, q), ("and", q, ("X", r))),
            ("X", ("X", ("X", ("F", ("and", p, q))))),
        )
    )


def _is_worth_doing(graph: GraphProblem, formula: Formula) -> bool:
    """Return whether some path of the graph satisfies a formula that the start alone does not satisfy."""
    judge = monitor(formula)
    first = (graph.start, judge.step(judge.start, graph.label(graph.start)))
    if judge.satisfied(first[1]):
        return False
    seen, pending = {first}, [first]
    while pending:
        state, progress = pending.pop()
        for edge in graph.outgoing.get(state, []):
            reached = (edge.target, judge.step(progress, graph.label(edge.target)))
            if judge.satisfied(reached[1]):
                return True
            if reached not in seen:
                seen.add(reached)
                pending.append(reached)
    return False
