"""Plans that begin with a past: against plans made at the start, and exhaustive search of past and future together."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import judge
import pytest
from judge.preferences import reference
from judge.rules import JudgedRule, front_with_rules
from scenario_texts import cup_scenario

from prefplan import (
    NoPlanError,
    Order,
    Plan,
    Planner,
    Problem,
    Relaxation,
    Rule,
    Task,
    TransitionSystem,
    WeightedSum,
    claims,
    pareto_front,
)
from prefplan.claims import Claims
from prefplan.product.reduction import GeneratedProduct, product_of
from prefplan.replanning import (
    Past,
    achievable,
    continue_as_preferred,
    continue_cheaply,
    continued,
    damaged,
    keeping_satisfiable,
    tasks_lost_by,
    valued,
    violated,
)
from prefplan.scenario.decode import from_dict, loads

KINDS = [("order", False), ("weighted-sum", False), ("max", False), ("deadline", False), ("expression", False)]
KINDS += [("sum", False), ("weighted-sum", True), ("sum", True)]


def worth(plan: Plan) -> tuple[Any, Any]:
    return plan.cost, plan.preference


def disturbed(seed: int, kind: str, relaxed: bool) -> tuple[judge.GraphProblem, Problem, Past, TransitionSystem]:
    """Draw a problem, a past on its graph with labels and jumps of its own, and a present; for the judge a chain."""
    rng = random.Random(f"past {seed} {kind} {relaxed}")
    world = judge.random_problem(seed, kind=kind, relaxed=relaxed, decimals=seed % 3)
    problem = from_dict(world.scenario()).problem()
    names = list(problem.system.states)
    atoms = sorted(problem.system.propositions)
    length = rng.choice((1, 2, 3, 5))
    states = tuple(f"h{k}" for k in range(length))
    labels = tuple(frozenset(p for p in atoms if rng.random() < 0.35) for _ in states)
    costs = tuple(rng.choice((0, 1, 2, 0.5)) for _ in states)
    actions = tuple(rng.choice(("go", "slip", names[0])) for _ in states)
    present = rng.choice(names)
    targets = (*states[1:], present)
    chain = tuple(
        judge.Edge(source, action, judge.exact(cost), target)
        for source, action, cost, target in zip(states, actions, costs, targets, strict=True)
    )
    judged = replace(
        world,
        start=states[0],
        edges=(*chain, *world.edges),
        labels=dict(world.labels) | dict(zip(states, labels, strict=True)),
        bygone=frozenset(states),
    )
    system = replace(problem.system, start=names.index(present))
    return judged, problem, Past(actions, costs, states, labels), system


@pytest.mark.parametrize(("kind", "relaxed"), KINDS)
def test_past_and_future_together_are_optimal(kind: str, relaxed: bool) -> None:
    found = 0
    for seed in range(16):
        judged, problem, past, system = disturbed(seed, kind, relaxed)
        least = judge.cheapest_cost(judged)
        if least is None:
            with pytest.raises(NoPlanError):
                continue_cheaply(problem, past, system)
            continue
        front = judge.exact_front(judged, max_cost=2 * least + 12)
        expected = [(Fraction(cost), Fraction(mu)) for cost, mu in front]
        plans = [continue_cheaply(problem, past, system)]
        if problem.measure.contract != "general":
            plans.append(continue_as_preferred(problem, past, system))
            for _, mu in front:
                plans.append(continue_cheaply(problem, past, system, max_preference=float(mu)))
        worths = [tuple(Fraction(str(x)) for x in worth(plan)) for plan in plans]
        if "/" not in str(judged.preference):
            assert worths == [expected[0], expected[-1], *expected][: len(worths)]
        for plan in plans:
            assert plan.actions[: len(past.actions)] == past.actions
            assert len(plan.states) == len(plan.actions) + 1
            _, _, labels, (costs, *_) = system.trajectory(plan.actions[len(past.actions) :])
            spent, trace = [judge.exact(cost) for cost in (*past.costs, *costs)], [*past.labels, *labels]
            told = Claims(True, plan.cost, plan.task_costs, plan.violation_costs, plan.preference, plan.relaxations)
            verdict = claims.judge(told, problem.tasks, problem.preference, trace, spent)
            assert [check for check in verdict.checks if not check.holds] == []
        found += 1
    assert found > 5


def test_what_lies_behind_is_paid_even_if_all_could_have_been_dropped() -> None:
    system = TransitionSystem.from_transitions(
        [("s0", "go", "s1", 4), ("s1", "on", "s2", 50)], start="s0", labels={"s2": ["goal"]}
    )
    problem = Problem(system, [Task("visit", "F goal", skip=3)], WeightedSum({"visit": 1}, over="violation"))
    past = Past(("go",), (4,), ("s0",), (frozenset(),))
    plan = continue_cheaply(problem, past, replace(system, start=1))
    assert (worth(plan), plan.actions, plan.task_costs) == ((4, 3), ("go",), {"visit": 4})
    assert worth(Planner(problem).cheapest()) == (0, 3)


def test_what_was_done_after_the_last_task_is_paid_too() -> None:
    system = TransitionSystem.from_transitions([("s0", "go", "s1", 4)], start="s0", labels={"s0": ["goal"]})
    problem = Problem(system, [Task("visit", "F goal")], Order())
    past = Past(("go",), (4,), ("s0",), (frozenset({"goal"}),))
    for go_on in (continue_cheaply, continue_as_preferred):
        plan = go_on(problem, past, replace(system, start=1))
        assert (plan.cost, plan.actions, plan.states) == (4, ("go",), ("s0", "s1"))
        assert plan.task_costs == {"visit": 0}


def test_without_a_past_nothing_changes() -> None:
    problem = from_dict(judge.random_problem(3).scenario()).problem()
    assert continued(problem, Past(), problem.system) == problem


SYSTEM = TransitionSystem.from_transitions(
    [("s", "wait", "s", 1), ("s", "go", "t", 2)], start="s", labels={"t": ["b"]}, propositions=["a", "c"]
)
AVOID = Task("avoid", "!a U b", (Relaxation("b", "c", 2),))


@pytest.mark.parametrize(
    ("labels", "broken", "lost"),
    [
        ([], (), ()),
        ([{"c"}], (), ()),
        ([{"a"}], ("avoid",), ("avoid",)),
        ([{"c"}, {"a"}], ("avoid",), ()),
        ([{"b"}, {"a"}], (), ()),
    ],
)
def test_violated_tasks_are_told_from_those_that_relaxations_mend(
    labels: list[set[str]], broken: tuple[str, ...], lost: tuple[str, ...]
) -> None:
    problem = Problem(SYSTEM, [AVOID, Task("other", "F b")], WeightedSum({"avoid": 1, "other": 1}, over="violation"))
    read = [frozenset(label) for label in labels]
    assert (damaged(problem, read), violated(problem, read)) == (broken, lost)


def test_a_task_that_may_be_skipped_is_never_lost() -> None:
    task = replace(AVOID, skip=4)
    problem = Problem(SYSTEM, [task], WeightedSum({"avoid": 1}, over="violation"))
    assert (damaged(problem, [frozenset("a")]), violated(problem, [frozenset("a")])) == (("avoid",), ())


def test_of_tasks_that_are_lost_the_others_can_still_be_done() -> None:
    problem = Problem(SYSTEM, [Task("avoid", "!a U b"), Task("other", "F b")], Order())
    past = Past(("wait",), (1,), ("s",), (frozenset("a"),))
    with pytest.raises(NoPlanError, match="task avoid can never be satisfied"):
        continue_cheaply(problem, past, SYSTEM)
    rest = achievable(problem, past, SYSTEM)
    assert rest is not None
    fewer, plan = rest
    assert fewer.names == ("other",)
    assert (plan.cost, plan.task_costs, plan.actions) == (3, {"other": 3}, ("wait", "go"))
    assert valued(problem, past, plan, SYSTEM).task_costs == {"avoid": 3, "other": 3}
    assert achievable(Problem(SYSTEM, [Task("never", "F c")], Order()), past, replace(SYSTEM, start=1)) is None


def test_of_tasks_that_conflict_with_each_other_the_last_is_left_out_first() -> None:
    both = [Task("one", "!b U a"), Task("other", "!a U b")]
    there_and_back = TransitionSystem.from_transitions(
        [("s", "to a", "x", 1), ("s", "to b", "y", 1), ("x", "on", "y", 1), ("y", "back", "x", 1)],
        start="s",
        labels={"x": ["a"], "y": ["b"]},
    )
    for tasks in (both, both[::-1]):
        found = achievable(Problem(there_and_back, tasks, Order()), Past(), there_and_back)
        assert found is not None and found[0].names == (tasks[0].name,)


DETOUR = TransitionSystem.from_transitions(
    [("s", "short", "t", 1), ("s", "long", "u", 5), ("t", "on", "v", 1), ("s", "aside", "w", 1), ("w", "back", "s", 1)],
    start="s",
    labels={"t": ["a", "near"], "u": ["far"], "v": ["far"], "w": ["pause"]},
    propositions=["b"],
)
LATER = Task("later", "!a U b")
"""Nothing satisfies it now, and after `short` nothing ever does."""


@pytest.mark.parametrize(
    ("formulas", "left", "cost"),
    [
        ({"goal": "F far"}, ["goal"], 5),
        ({"pause": "F pause", "through": "F near"}, ["pause"], 1),
        ({"through": "F near", "pause": "F pause"}, ["pause"], 1),
        ({"through": "F near"}, None, None),
    ],
)
def test_what_can_still_be_done_leaves_other_tasks_possible(
    formulas: dict[str, str], left: list[str] | None, cost: int | None
) -> None:
    tasks = [LATER, *(Task(name, formula) for name, formula in formulas.items())]
    found = achievable(Problem(DETOUR, tasks, Order()), Past(), DETOUR, others=())
    assert (found and ([*found[0].names], found[1].cost)) == (left and (left, cost))
    at_any_price = achievable(Problem(DETOUR, tasks, Order()), Past(), DETOUR)
    assert at_any_price is not None and at_any_price[0].names == tuple(formulas)
    assert tasks_lost_by(Problem(DETOUR, tasks, Order()), Past(), at_any_price[1], DETOUR) == ("later",)


def test_what_is_lost_already_is_spared_no_more() -> None:
    problem = Problem(DETOUR, [Task("goal", "F far")], Order())
    past = Past(("short",), (1,), ("s",), (frozenset("a"),))
    assert continue_cheaply(keeping_satisfiable(problem, [LATER], [*past.labels, frozenset()]), past, DETOUR).cost == 3
    assert continue_cheaply(keeping_satisfiable(problem, [LATER], [frozenset()]), Past(), DETOUR).cost == 5


PUDDLE = TransitionSystem.from_transitions(
    [("home", "go", "puddle", 1), ("puddle", "on", "shelter", 1)],
    start="home",
    labels={"puddle": ["wet"], "shelter": ["dry"]},
)


def test_rules_that_the_past_broke_stay_broken_though_no_task_is_left() -> None:
    past, now = Past(("go",), (1,), ("home",), (frozenset(),)), replace(PUDDLE, start=1)
    weights = {"t": 1, "r": 1}
    priced = [Rule("r", "G !wet", skip=4)]
    problem = Problem(PUDDLE, [Task("t", "F dry", skip=1)], WeightedSum(weights, over="violation"), rules=priced)
    for go_on, found in ((continue_cheaply, (1, 5)), (continue_as_preferred, (2, 4))):
        plan = go_on(problem, past, now)
        assert (worth(plan), plan.violation_costs["r"]) == (found, 4)
        assert [(bought.task, bought.step) for bought in plan.relaxations if bought.rule] == [("r", 1)]
    assert [worth(plan) for plan in pareto_front(continued(problem, past, now))] == [(1, 5), (2, 4)]
    hard = Problem(PUDDLE, [problem.tasks[0]], WeightedSum({"t": 1}, over="violation"), rules=[Rule("r", "G !wet")])
    for go_on in (continue_cheaply, continue_as_preferred):
        with pytest.raises(NoPlanError, match="every plan breaks the rule r"):
            go_on(hard, past, now)


def test_fronts_after_a_past_agree_with_exhaustive_search_under_rules() -> None:
    found = broken = none = 0
    for seed in range(100):
        judged, problem, past, system = disturbed(seed, "weighted-sum", True)
        rng = random.Random(f"past and rules {seed}")
        prices = (2, 3, *[None] * rng.choice((0, 0, 0, 1)))
        bad = [judge.random_formula(rng, "abc", rng.choice((1, 2))) for _ in prices]
        texts = [f"!({judge.to_text(formula)})" for formula in bad]
        names = [f"rule{k}" for k in range(len(prices))]
        rules = [Rule(*pair, skip=price) for *pair, price in zip(names, texts, prices, strict=True)]
        weights = {**problem.preference.weights, "rule0": 1, "rule1": 2}
        known = replace(problem.system, propositions=frozenset("abc"))
        ruled = Problem(known, problem.tasks, WeightedSum(weights, over="violation"), rules=rules)
        monitors = [JudgedRule(*each) for each in zip(names, bad, prices, strict=True)]
        everything = [*problem.names, *names]
        mu = reference({"kind": "weighted-sum", "over": "violation", "weights": weights}, everything)
        theirs = front_with_rules(judged, monitors, mu, max_cost=float(sum(past.costs)) + 8)
        ours = pareto_front(continued(ruled, past, system), max_cost=float(sum(past.costs)) + 8)
        assert [worth(plan) for plan in ours] == [(float(cost), float(mu)) for cost, mu in theirs], seed
        found += len(theirs) > 1
        broken += any(bought.rule and bought.step <= len(past.actions) for plan in ours for bought in plan.relaxations)
        none += not theirs
    assert min(found, broken, none) > 3


def test_a_large_model_is_not_listed_to_plan_on_in_it() -> None:
    scenario = loads(cup_scenario())
    large = replace(scenario, model=replace(scenario.model, listed_states=0))
    problem, plan = large.problem(), Planner(large.problem()).cheapest()
    past = Past(plan.actions[:2], (4, 1), plan.states[:2], tuple(state.label for state in plan.states[:2]))
    ahead = continued(problem, past, replace(large.model, begin=plan.states[2]).transition_system())
    assert isinstance(product_of(ahead), GeneratedProduct)
    again = Planner(ahead).cheapest()
    assert (again.actions, again.states) == (plan.actions, plan.states)
    spent = sum(problem.system.trajectory(plan.actions[:2])[3][0])
    assert again.cost == plan.cost - spent + 5
