"""Rules: fronts against exhaustive search, the prices of broken rules, and errors."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import judge
import pytest
from judge.preferences import reference
from judge.problems import GraphProblem
from judge.rules import JudgedRule, front_with_rules

from prefplan import PrefplanError, cheapest_plan, pareto_front
from prefplan.claims import Claims
from prefplan.claims import judge as judged
from prefplan.front import NoPlanError
from prefplan.ledger import Ledger
from prefplan.problem import Problem
from prefplan.scenario.decode import from_dict, loads


def drawn(seed: int) -> tuple[GraphProblem, list[JudgedRule], Mapping[str, Any]]:
    """Return a random problem, one or two rules, and a preference over both."""
    rng = random.Random(f"rules {seed}")
    problem = judge.random_problem(seed, kind="weighted-sum", relaxed=rng.random() < 0.4)
    prices = [rng.choice((None, None, 1, 2, 4)) for _ in range(rng.choice((1, 1, 2)))]
    rules = [
        JudgedRule(f"rule{k}", judge.random_formula(rng, "abc", rng.choice((1, 2, 3))), price)
        for k, price in enumerate(prices)
    ]
    names = [*problem.names, *(rule.name for rule in rules if rule.skip is not None)]
    terms = [{"kind": "weighted-sum", "over": "violation", "weights": {n: rng.choice((0, 1, 2)) for n in names}}]
    kind = rng.choice(("order", "weighted-sum", "max", "none"))
    if kind != "none":
        own = judge.random_preference(rng, problem.names, kind)
        terms.append(own if kind != "order" else {**own, "order": list(problem.names)})
    return problem, rules, {"kind": "sum", "terms": [{**term, "weight": 1} for term in terms]}


def solved(problem: GraphProblem, rules: list[JudgedRule], preference: Mapping[str, Any]) -> Problem:
    data = problem.scenario()
    data["model"]["propositions"] = sorted(set("abc") - frozenset().union(*problem.labels.values()))
    data["preference"] = preference
    data["rules"] = [
        {"name": rule.name, "formula": f"!({judge.to_text(rule.bad)})"}
        | ({} if rule.skip is None else {"skip": rule.skip})
        for rule in rules
    ]
    return from_dict(data).problem()


def test_fronts_under_rules_agree_with_exhaustive_search() -> None:
    found = broken = none = 0
    for seed in range(100):
        problem, rules, preference = drawn(seed)
        bound = 12
        ours = pareto_front(solved(problem, rules, preference), max_cost=bound)
        everything = [*problem.names, *(rule.name for rule in rules)]
        theirs = front_with_rules(problem, rules, _reference(preference, problem.names, everything), max_cost=bound)
        assert [(plan.cost, plan.preference) for plan in ours] == theirs, seed
        found += len(ours) > 1
        broken += any(purchase.rule for plan in ours for purchase in plan.relaxations)
        none += not theirs
    assert min(found, broken, none) > 5


def _reference(preference: Mapping[str, Any], tasks: tuple[str, ...], everything: list[str]) -> Any:
    """Return the preference as a function of the costs of tasks and rules, in which terms over cost see tasks alone."""
    terms = []
    for term in preference["terms"]:
        if term.get("over") == "violation":
            terms.append(reference(term, everything))
        else:
            own = reference(term, tasks)
            terms.append(lambda costs, paid, own=own: own(costs[: len(tasks)], paid[: len(tasks)]))
    return lambda costs, paid: sum(term(costs, paid) for term in terms)


def test_what_plans_claim_of_rules_is_derived_again_from_their_labels() -> None:
    checked = 0
    for seed in range(60):
        problem = solved(*drawn(seed))
        for plan in pareto_front(problem, max_cost=12):
            ledger = Ledger.of_plan(problem, plan)
            claims = Claims(True, plan.cost, plan.task_costs, plan.violation_costs, plan.preference, plan.relaxations)
            verdict = judged(
                claims, problem.tasks, problem.preference, ledger.labels, ledger.costs, rules=problem.rules
            )
            assert [check for check in verdict.checks if not check.holds] == [], seed
            checked += sum(check.name.startswith("rule ") for check in verdict.checks)
    assert checked > 30


HALL = """
[model]
kind = "graph"
start = "door"
transitions = [
  { from = "door", to = "carpet", cost = 1 },
  { from = "carpet", to = "desk", cost = 1 },
  { from = "door", to = "stones", cost = 3 },
  { from = "stones", to = "desk", cost = 3 },
]
[model.labels]
carpet = ["carpet"]
desk = ["desk"]
door = ["wet"]
[[tasks]]
name = "arrive"
formula = "F desk"
[[rules]]
name = "clean"
formula = "G !carpet"
"""

PAID = HALL + 'skip = 2\n[preference]\nkind = "weighted-sum"\nover = "violation"\nweights = { clean = 1 }\n'


def hall(text: str) -> Problem:
    return loads(text).problem()


def test_a_rule_is_broken_for_its_price_when_that_happens() -> None:
    cheap, clean = pareto_front(hall(PAID))
    assert (cheap.cost, cheap.preference, cheap.violation_costs) == (2, 2, {"arrive": 0, "clean": 2})
    assert [(p.task, p.step, p.rule) for p in cheap.relaxations] == [("clean", 1, True)]
    assert (clean.cost, clean.preference, clean.relaxations) == (6, 0, ())
    assert cheap.task_costs == {"arrive": 2}
    assert [entry.preference for entry in Ledger.of_plan(hall(PAID), cheap).entries] == [0, 2, 2]


TWO_PRICES = """
[model]
kind = "graph"
start = "s"
transitions = [
  { from = "s", to = "t", cost = 1 },
  { from = "s", to = "s", cost = 1 },
  { from = "t", to = "s", cost = 2 },
]
[model.labels]
s = ["p", "q"]
t = ["q", "r"]
[[tasks]]
name = "back"
formula = "F (r & F p)"
relax = [{ assume = "r", when = "p", cost = 4 }]
[[tasks]]
name = "both"
formula = "p M r"
relax = [{ assume = "r", when = "p", cost = 2 }]
[[rules]]
name = "kept"
formula = "G q"
skip = 2
[[rules]]
name = "broken"
formula = "!p"
skip = 3
[preference]
kind = "weighted-sum"
over = "violation"
weights = { back = 2, both = 1, kept = 2, broken = 1 }
"""


def test_a_front_within_some_percent_pays_for_no_rule_that_is_kept() -> None:
    problem = hall(TWO_PRICES)
    assert [(plan.cost, plan.preference) for plan in pareto_front(problem)] == [(0, 13), (3, 5)]
    for plan in pareto_front(problem, within=20):
        assert plan.violation_costs["kept"] == 0 and plan.violation_costs["broken"] == 3


def test_an_obligation_that_is_pending_when_the_plan_ends_breaks_no_rule() -> None:
    later = PAID.replace("G !carpet", "G (desk -> X carpet)")
    (plan,) = pareto_front(hall(later))
    assert (plan.actions, plan.preference) == (("carpet", "desk"), 0)
    at_once = PAID.replace("G !carpet", "G (carpet -> X wet)")
    assert [(plan.cost, plan.preference) for plan in pareto_front(hall(at_once))] == [(2, 2), (6, 0)]


@pytest.mark.parametrize(
    ("weights", "penalty"), [("", 2), ("weights = { clean = 3 }", 6), ("weights = { clean = 0 }", 0)]
)
def test_a_rule_weighs_1_in_a_maximum_unless_it_is_told_otherwise(weights: str, penalty: int) -> None:
    text = HALL + f'skip = 2\n[preference]\nkind = "max"\nover = "violation"\n{weights}\n'
    assert pareto_front(hall(text))[0].preference == penalty


def test_a_rule_without_a_price_is_kept_and_blamed_where_no_plan_keeps_it() -> None:
    order = '[preference]\nkind = "order"\n'
    assert cheapest_plan(hall(HALL + order)).actions == ("stones", "desk")
    with pytest.raises(NoPlanError) as caught:
        cheapest_plan(
            hall(
                HALL.replace("G !carpet", "G (!carpet & !stones)").replace(
                    'carpet = ["carpet"]', 'carpet = ["carpet"]\nstones = ["stones"]'
                )
                + order
            )
        )
    assert (caught.value.reason.kind, caught.value.reason.tasks) == ("rule", ("clean",))
    assert str(caught.value) == "every plan breaks the rule clean"
    with pytest.raises(NoPlanError, match="every plan breaks the rule clean"):
        cheapest_plan(hall(HALL.replace("G !carpet", "G !wet") + order))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("G !carpet", "F desk", "rules[0].formula: no safety formula: no finite plan breaks 'F desk'"),
        ("G !carpet", "G !rug", "rules[0].formula: unknown proposition 'rug'"),
        ('"clean"', '"arrive"', "rules[0].name: 'arrive' is used twice"),
        ("skip = 2", "skip = -1", "rules[0].skip: negative cost -1"),
        (
            'kind = "weighted-sum"\nover = "violation"\nweights = { clean = 1 }',
            'kind = "order"',
            "rules[0].skip: no term",
        ),
        ("{ clean = 1 }", "{ tidy = 1 }", "preference.weights: unknown task 'tidy'"),
    ],
)
def test_mistakes_in_rules_are_named(old: str, new: str, message: str) -> None:
    with pytest.raises(PrefplanError) as caught:
        hall(PAID.replace(old, new))
    assert message in str(caught.value)


BLOCKS = """
[model]
kind = "manipulation"
start = "home"
costs = {{ transit = 3, grasp = 1, transport = 5, release = 1 }}
[model.locations]
p0 = {{ at = [0.4, 0.0] }}
p1 = {{ at = [0.4, 0.1] }}
p2 = {{ at = [0.4, 0.2] }}
box = {{ at = [0.6, 0.0], capacity = 2, marks = "clean" }}
[model.objects]
a = {{ start = "p0" }}
b = {{ start = "p1" }}
[[tasks]]
name = "one"
formula = "F a_box"
[[tasks]]
name = "two"
formula = "F (b_p2 & F b_box)"
[[rules]]
name = "rule"
formula = "{rule}"
[preference]
kind = "order"
order = ["two", "one"]
"""


@pytest.mark.parametrize(
    "rule",
    [
        "G (holding_a -> X a_box)",
        "G !(a_box & b_p1)",
        "!a_box U[0,6] b_p2",
        "G (b_p1 | holding_b | b_clean | b_p2)",
        "b_p2 R !holding_a",
        "G !b_p2",
    ],
)
def test_models_that_are_not_listed_keep_rules_as_listed_ones_do(rule: str) -> None:
    text = BLOCKS.format(rule=rule)
    listed = pareto_front(hall(text))
    scenario = loads(text)
    large = replace(scenario, model=replace(scenario.model, listed_states=0)).problem()
    generated = pareto_front(large)
    assert [(p.cost, p.preference) for p in generated] == [(p.cost, p.preference) for p in listed]
    assert generated.reason == listed.reason
    for plan in generated:
        assert not large.broken(Ledger.of_plan(large, plan).labels)
