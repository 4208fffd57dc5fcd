"""The judges against hand-computed cases, against the definition of LTL, and against plain listing of all plans."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
from judge import (
    EXPRESSIONS,
    Edge,
    GraphProblem,
    JudgedTask,
    Relaxation,
    cheapest_cost,
    exact_front,
    exact_plans,
    grid_problem,
    holds,
    is_good_prefix,
    parse,
    random_formula,
    random_problem,
    random_text,
    reference,
    replay,
    satisfaction_index,
    to_text,
)
from judge.preferences import named
from judge.semantics import Label, holds_now, monitor, powerset
from judge.syntax import bracketed, is_co_safe


def labels(*words: str) -> list[Label]:
    """Write a trace of one-letter propositions: `labels("a", "", "bc")`."""
    return [frozenset(word) for word in words]


def tasks(*formulas: str) -> tuple[JudgedTask, ...]:
    return tuple(JudgedTask(f"phi{k + 1}", parse(text)) for k, text in enumerate(formulas))


def graph(
    edges: list[tuple[str, int, str]], marked: dict[str, str], formulas: list[str], preference: dict[str, Any]
) -> GraphProblem:
    return GraphProblem(
        start=edges[0][0],
        edges=tuple(Edge(source, target, cost, target) for source, cost, target in edges),
        labels={state: frozenset(word) for state, word in marked.items()},
        tasks=tasks(*formulas),
        preference=preference,
    )


@pytest.fixture
def rng() -> random.Random:
    return random.Random(7)


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("!a U b", ("U", ("not", ("ap", "a")), ("ap", "b"))),
        ("a U b U c", ("U", ("ap", "a"), ("U", ("ap", "b"), ("ap", "c")))),
        ("a -> b -> c", ("implies", ("ap", "a"), ("implies", ("ap", "b"), ("ap", "c")))),
        ("a | b & c U d", ("or", ("ap", "a"), ("and", ("ap", "b"), ("U", ("ap", "c"), ("ap", "d"))))),
        ("F a & X !b", ("and", ("F", ("ap", "a")), ("X", ("not", ("ap", "b"))))),
        ("a & b & c", ("and", ("and", ("ap", "a"), ("ap", "b")), ("ap", "c"))),
    ],
)
def test_text_is_read_with_the_precedence_of_the_language(text: str, formula: tuple[Any, ...]) -> None:
    assert parse(text) == formula
    assert parse(to_text(formula)) == formula


@pytest.mark.parametrize("text", ["", "a b", "(a", "a)", "a &", "U a", "a # b", "G a"])
def test_what_is_no_formula_is_not_read(text: str) -> None:
    with pytest.raises(ValueError):
        parse(text)


def test_every_way_of_writing_a_formula_reads_back_the_same(rng: random.Random) -> None:
    for _ in range(500):
        formula = random_formula(rng, ["a", "b", "c_1"], rng.randrange(5))
        assert is_co_safe(formula)
        assert parse(to_text(formula)) == parse(bracketed(formula)) == parse(random_text(formula, rng)) == formula


@pytest.mark.parametrize(
    ("text", "trace", "index"),
    [
        ("true", labels(""), 0),
        ("false", labels("", "", ""), None),
        ("a | !a", labels(""), 0),
        ("X(a | !a)", labels(""), 0),
        ("F a | F !a", labels(""), 0),
        ("(a U b) | (!a U b)", labels("a", "a", "b"), 2),
        ("(a U b) | (!a U b)", labels("a", "", "b"), None),
        ("(a U b) | F !b", labels("a"), 0),
        ("(a U b) | F !b", labels("b"), 0),
        ("F a", labels("b", "", "a", "a"), 2),
        ("X a", labels("a", "a"), 1),
        ("X X b", labels("b", "b", ""), None),
        ("F(a & X b)", labels("a", "a", "b"), 2),
        ("F(a & F b)", labels("b", "a", "b"), 2),
        ("F(a & F b)", labels("b", "ab"), 1),
        ("!a U b", labels("", "a", "b"), None),
        ("!a U b", labels("", "ab"), 1),
        ("a -> F b", labels(""), 0),
        ("a -> F b", labels("a", "", "b"), 2),
        ("F F a & (b U true)", labels("", "a"), 1),
    ],
)
def test_a_task_is_satisfied_at_the_first_good_prefix(text: str, trace: list[Label], index: int | None) -> None:
    assert satisfaction_index(parse(text), trace) == index


def test_good_prefixes_are_those_no_continuation_can_spoil(rng: random.Random) -> None:
    for _ in range(250):
        atoms = ["a", "b"]
        formula = random_formula(rng, atoms, rng.randint(1, 4))
        letters = powerset(atoms)
        judge = monitor(formula)
        state, trace = judge.start, []
        for _ in range(4):
            trace.append(rng.choice(letters))
            state = judge.step(state, trace[-1])
            assert judge.satisfied(state) == is_good_prefix(formula, trace)
            spoiler = judge.violation(state)
            if spoiler is not None:
                assert not holds(formula, [*trace, *spoiler[0]], spoiler[1])
            else:
                for stem, loop in product(letters, letters):
                    assert holds(formula, [*trace, stem], [loop])


def test_formulas_that_are_not_co_safe_have_no_monitor() -> None:
    for text in ("!(a U b)", "F a -> b", "!X a"):
        with pytest.raises(ValueError, match="co-safe"):
            monitor(parse(text))


@pytest.mark.parametrize(
    ("preference", "costs", "violations", "value"),
    [
        ({"kind": "order"}, (6, 5, 2), (0, 0, 0), 4),
        ({"kind": "order", "order": ["t3", "t2", "t1"]}, (6, 5, 2), (0, 0, 0), 0),
        ({"kind": "order", "order": [["t1", "t3"], "t2"]}, (6, 5, 2), (0, 0, 0), 1),
        ({"kind": "order", "order": [["t1", "t2", "t3"]]}, (6, 5, 2), (0, 0, 0), 0),
        ({"kind": "weighted-sum", "weights": {"t1": 1, "t2": 0, "t3": 2.5}}, (6, 5, 2), (0, 0, 0), 11),
        (
            {"kind": "weighted-sum", "weights": {"t1": 1, "t2": 1, "t3": 2}, "over": "violation"},
            (6, 5, 2),
            (1, 0, 3),
            7,
        ),
        ({"kind": "max"}, (6, 5, 2), (0, 0, 0), 6),
        ({"kind": "max", "weights": {"t3": 4}}, (6, 5, 2), (0, 0, 0), 8),
        ({"kind": "deadline", "deadlines": {"t1": {"by": 4}, "t3": {"by": 1.5, "weight": 2}}}, (6, 5, 2), (0, 0, 0), 3),
        ({"kind": "expression", "expression": "t1 * t2 - 3"}, (6, 5, 2), (0, 0, 0), 27),
        ({"kind": "expression", "expression": "(t1 - t2) / 3 + 0.5 * t3"}, (6, 5, 2), (0, 0, 0), Fraction(4, 3)),
        (
            {
                "kind": "sum",
                "terms": [{"kind": "order", "weight": 3}, {"kind": "max", "weight": 1, "over": "violation"}],
            },
            (6, 5, 2),
            (0, 9, 1),
            21,
        ),
    ],
)
def test_preferences_have_the_values_of_their_definitions(
    preference: dict[str, Any], costs: tuple[int, ...], violations: tuple[int, ...], value: int
) -> None:
    assert reference(preference, ("t1", "t2", "t3"))(costs, violations) == value


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_listed_expressions_never_fall_along_a_trajectory(expression: str, rng: random.Random) -> None:
    value = reference({"kind": "expression", "expression": expression}, ("x", "y", "z"))
    for _ in range(300):
        ends = [rng.choice((rng.randrange(12), 99)) for _ in range(3)]
        along = [value(tuple(min(end, g) for end in ends), (0, 0, 0)) for g in range(20)]
        assert along == sorted(along) and along[0] >= 0


PRODUCT = [("s0", 1, "s1"), ("s0", 2, "s2"), ("s1", 9, "s3"), ("s2", 1, "s3"), ("s3", 5, "s4")]
CAPPED = [("s", 1, "A"), ("A", 19, "P"), ("s", 10, "P"), ("P", 10, "B")]
ROUTES = [("s", 2, "x"), ("x", 8, "y"), ("y", 1, "P"), ("s", 2, "z"), ("z", 8, "w"), ("w", 1, "P"), ("P", 29, "Q")]


@pytest.mark.parametrize(
    ("edges", "marked", "formulas", "expression", "front"),
    [
        (PRODUCT, {"s1": "a", "s2": "a", "s4": "b"}, ["F a", "F b"], "phi1 * phi2", [(8, 16), (15, 15)]),
        (CAPPED, {"A": "a", "P": "a", "B": "b"}, ["F a", "F b"], "phi1 + min(phi2, 20)", [(20, 30), (30, 21)]),
        (
            ROUTES,
            {"x": "b", "y": "a", "z": "a", "w": "b", "Q": "c"},
            ["F a", "F b", "F c"],
            "max(3 * phi1, phi3) + 2 * phi2",
            [(40, 44)],
        ),
    ],
    ids=["product", "capped", "max-plus-sum"],
)
def test_points_that_pruning_by_cost_and_mu_would_lose_are_found(
    edges: list[tuple[str, int, str]],
    marked: dict[str, str],
    formulas: list[str],
    expression: str,
    front: list[tuple[int, int]],
) -> None:
    problem = graph(edges, marked, formulas, {"kind": "expression", "expression": expression})
    assert exact_front(problem, max_cost=60) == front


@pytest.fixture
def example() -> GraphProblem:
    """The paper's Examples 1-3."""
    regions = {"dirt": (2, 0, 2, 0), "plant": (1, 1, 1, 1), "rock": (1, 2, 1, 2), "charge": (2, 2, 2, 2)}
    formulas = tasks("F charge", "F (plant & F rock)", "!plant U dirt")
    return grid_problem((3, 3), (0, 0), regions, formulas, {"kind": "order"})


def test_the_papers_example_has_its_plan_and_its_front(example: GraphProblem) -> None:
    outcome = replay(example, ["E", "E", "W", "N", "N", "E"])
    assert (outcome.cost, outcome.task_costs, outcome.mu, outcome.ends) == (6, (6, 5, 2), 4, True)
    assert exact_front(example, max_cost=20) == [(6, 4), (9, 3)]


def test_the_papers_example_misses_charge_with_the_action_it_prints(example: GraphProblem) -> None:
    outcome = replay(example, ["E", "E", "W", "N", "N", "W"])
    assert outcome.satisfied == (False, True, True)
    assert outcome.task_costs[0] == outcome.cost == 6
    assert not outcome.ends


@pytest.mark.parametrize(
    ("first", "second", "front"),
    [
        (((5, 8), (0, 7), (9, 9)), ((6, 1), (9, 9), (9, 8)), [(31, 10), (32, 0)]),
        (((9, 4), (0, 1), (6, 5)), ((4, 2), (8, 3), (7, 3)), [(27, 16), (29, 9), (36, 0)]),
    ],
)
def test_grid_instances_have_the_fronts_of_an_independent_solver(
    first: tuple[tuple[int, int], ...], second: tuple[tuple[int, int], ...], front: list[tuple[int, int]]
) -> None:
    regions = {f"x{x}y{y}": (x, y, x, y) for x, y in (*first, *second)}
    visits = [[f"x{x}y{y}" for x, y in cells] for cells in (first, second)]
    formulas = tasks(*(f"F({a} & F({b}) & F({c}))" for a, b, c in visits))
    problem = grid_problem((10, 10), (0, 0), regions, formulas, {"kind": "order"})
    assert exact_front(problem, max_cost=front[-1][0]) == front


def relaxed(formula: str, *entries: tuple[str, str, int], skip: int | None = None) -> JudgedTask:
    return JudgedTask("phi1", parse(formula), tuple(Relaxation(p, parse(b), w) for p, b, w in entries), skip)


def line(task: JudgedTask, *marked: str) -> GraphProblem:
    """Lay states out in a row of unit costs; a second task asks for the end of it."""
    last = f"s{len(marked) - 1}"
    edges = tuple(Edge(f"s{k}", "go", 1, f"s{k + 1}") for k in range(len(marked) - 1))
    states = {f"s{k}": frozenset(word) | ({"end"} if f"s{k}" == last else set()) for k, word in enumerate(marked)}
    weights = {"phi1": 1, "phi2": 1}
    return GraphProblem(
        "s0",
        edges,
        states,
        (task, JudgedTask("phi2", parse("F end"))),
        {"kind": "weighted-sum", "weights": weights, "over": "violation"},
    )


@pytest.mark.parametrize(
    ("task", "marked", "front"),
    [
        (relaxed("F a", ("a", "b", 5)), ("", "b", ""), [(2, 5)]),
        (relaxed("F a", ("a", "b", 5)), ("b", ""), [(1, 5)]),
        (relaxed("F a", ("a", "b", 5)), ("b", "a"), [(1, 0)]),
        (relaxed("F a", ("a", "b", 5), skip=4), ("b", ""), [(1, 4)]),
        (relaxed("F a", skip=4), ("", "a"), [(1, 0)]),
        (relaxed("F(a & b)", ("a", "c", 2), ("b", "c", 3)), ("c", ""), [(1, 5)]),
        (relaxed("F(a & b)", ("a", "true", 2), ("b", "c", 3)), ("", "b", ""), [(2, 2)]),
        (relaxed("F(a & X a)", ("a", "true", 2)), ("", "", ""), [(2, 4)]),
        (relaxed("a U end", ("a", "true", 2)), ("", "a", "", ""), [(3, 4)]),
        (relaxed("F a"), ("b", ""), []),
    ],
)
def test_relaxations_are_paid_each_time_and_may_join(
    task: JudgedTask, marked: tuple[str, ...], front: list[tuple[int, int]]
) -> None:
    assert exact_front(line(task, *marked), max_cost=10) == front


def test_a_skipped_task_costs_the_whole_plan() -> None:
    problem = line(relaxed("F a", skip=4), "", "a", "", "")
    outcome = replay(problem, ["go"] * 3, [{"task": "phi1", "step": 0, "skip": True, "cost": 4}])
    assert outcome.task_costs == (3, 3)
    assert outcome.violations == (4, 0)
    assert outcome.satisfied == (False, True)
    assert outcome.ends


def test_skipping_every_task_needs_no_action() -> None:
    problem = line(relaxed("F a", skip=4), "", "")
    problem = replace(problem, tasks=(problem.tasks[0], replace(problem.tasks[1], skip=3)))
    assert exact_front(problem, max_cost=10) == [(0, 7), (1, 4)]


@pytest.mark.parametrize(
    "entry",
    [
        {"task": "phi1", "step": 0, "assume": "a", "cost": 5},
        {"task": "phi1", "step": 1, "assume": "a", "cost": 4},
        {"task": "phi1", "step": 0, "skip": True, "cost": 5},
        {"task": "phi3", "step": 1, "assume": "a", "cost": 5},
    ],
    ids=["when does not hold", "wrong price", "may not be skipped", "no such task"],
)
def test_relaxations_that_are_not_offered_are_refused(entry: dict[str, Any]) -> None:
    problem = line(relaxed("F a", ("a", "b", 5)), "", "b", "")
    with pytest.raises(ValueError):
        replay(problem, ["go", "go"], [entry])


def test_zero_cost_loops_end_and_cost_nothing() -> None:
    edges = [("s", 0, "t"), ("t", 0, "s"), ("t", 0, "t"), ("s", 3, "u")]
    problem = graph(edges, {"t": "a", "u": "b"}, ["F(b & F b)", "F a"], {"kind": "order"})
    assert exact_front(problem, max_cost=9) == [(3, 3)]


def listed_front(problem: GraphProblem, max_cost: int) -> list[tuple[Any, Any]]:
    """Find the front by listing every plan and every way of relaxing it, judged by `replay`."""
    points = set()
    for actions in _all_actions(problem, problem.start, max_cost):
        states = replay(problem, actions).states
        ways = [list(_all_relaxations(problem, task, states)) for task in problem.tasks]
        for chosen in product(*ways):
            try:
                outcome = replay(problem, actions, [entry for way in chosen for entry in way])
            except ValueError:
                continue
            if outcome.ends:
                points.add((outcome.cost, outcome.mu))
    return [
        (cost, mu)
        for cost, mu in sorted(points)
        if not any(c <= cost and m <= mu and (c, m) != (cost, mu) for c, m in points)
    ]


def _all_actions(problem: GraphProblem, state: str, budget: Any) -> Iterator[list[str]]:
    yield []
    for edge in problem.outgoing.get(state, []):
        if edge.cost <= budget:
            yield from ([edge.action, *rest] for rest in _all_actions(problem, edge.target, budget - edge.cost))


def _all_relaxations(
    problem: GraphProblem, task: JudgedTask, states: tuple[str, ...]
) -> Iterator[list[dict[str, Any]]]:
    if task.skip is not None:
        yield [{"task": task.name, "step": 0, "skip": True, "cost": task.skip}]
    offers = []
    for step, state in enumerate(states):
        for entry in task.relax:
            if entry.assume not in problem.label(state) and holds_now(entry.when, problem.label(state)):
                offers.append({"task": task.name, "step": step, "assume": entry.assume, "cost": entry.cost})
    for taken in product((False, True), repeat=len(offers)):
        yield [offer for offer, take in zip(offers, taken, strict=True) if take]


@pytest.mark.parametrize("kind", ["order", "expression", "sum", "relaxed"])
def test_fronts_are_those_of_listing_every_plan(kind: str) -> None:
    compared = 0
    for seed in range(150):
        if kind == "relaxed":
            problem = random_problem(seed, kind="sum", tasks=2, relaxed=True)
        else:
            problem = random_problem(seed, kind=kind)
        if any(edge.cost == 0 for edge in problem.edges):
            continue
        cheapest = cheapest_cost(problem)
        bound = 3 if cheapest is None else cheapest + 3
        if bound <= (5 if kind == "relaxed" else 9):
            assert exact_front(problem, max_cost=bound) == listed_front(problem, bound)
            compared += 1
    assert compared >= 10


@pytest.mark.parametrize("relaxed", [False, True])
def test_every_point_comes_with_a_plan_that_replays_to_it(relaxed: bool) -> None:
    for seed in range(200):
        kind = ("sum", "max", "weighted-sum")[seed % 3] if relaxed else ("order", "expression", "deadline")[seed % 3]
        problem = random_problem(seed, kind=kind, relaxed=relaxed, decimals=seed % 4 // 3)
        cheapest = cheapest_cost(problem)
        plans = [] if cheapest is None else exact_plans(problem, max_cost=cheapest + 8)
        assert [plan.cost for plan in plans[:1]] == [cost for cost in [cheapest] if cost is not None]
        for plan in plans:
            outcome = replay(problem, plan.actions, plan.relaxations)
            assert (outcome.cost, outcome.mu, outcome.ends) == (plan.cost, plan.preference, True)


def test_random_problems_are_the_same_for_the_same_seed_and_often_have_a_choice() -> None:
    assert random_problem(3).scenario() == random_problem(3).scenario()
    fronts = []
    for seed in range(300):
        problem = random_problem(seed)
        problem = replace(
            problem,
            preference={"kind": "expression", "expression": named("max(x, y, z) - min(x, y, z)", problem.names)},
        )
        cheapest = cheapest_cost(problem)
        fronts.append([] if cheapest is None else exact_front(problem, max_cost=cheapest + 12))
    assert sum(len(front) > 1 for front in fronts) >= 5
    assert sum(bool(front) for front in fronts) >= 200


def test_a_scenario_names_all_that_its_file_needs() -> None:
    problem = graph([("s", 1, "t")], {"t": "a"}, ["F(a & F b)"], {"kind": "order"})
    edge = Edge("t", "back", Fraction(1, 2), "s")
    task = replace(problem.tasks[0], relax=(Relaxation("b", parse("!c"), 2),), skip=9)
    scenario = replace(problem, edges=(*problem.edges, edge), tasks=(task,)).scenario()
    assert scenario == {
        "model": {
            "kind": "graph",
            "start": "s",
            "propositions": ["b", "c"],
            "transitions": [
                {"from": "s", "to": "t", "cost": 1},
                {"from": "t", "to": "s", "action": "back", "cost": 0.5},
            ],
            "labels": {"t": ["a"]},
        },
        "tasks": [
            {
                "name": "phi1",
                "formula": "F ( a & F b )",
                "relax": [{"assume": "b", "when": "! c", "cost": 2}],
                "skip": 9,
            }
        ],
        "preference": {"kind": "order"},
    }
