"""Rules: fronts against exhaustive search, the prices of broken rules, and errors."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import judge
import pytest
from judge.preferences import reference
from judge.problems import GraphProblem
from judge.rules import JudgedRule, front_with_rules

from prefplan import (
    GridModel,
    Order,
    Plan,
    Planner,
    PrefplanError,
    Rule,
    Sum,
    Task,
    TransitionSystem,
    WeightedSum,
    cheapest_plan,
    pareto_front,
)
from prefplan.claims import Claims
from prefplan.claims import judge as judged
from prefplan.front import NoPlanError
from prefplan.ledger import Ledger
from prefplan.problem import Problem
from prefplan.product.reduction import GeneratedProduct, product_of
from prefplan.scenario.decode import from_dict, loads

BAD_PREFIXES = (
    "F x",
    "!y U (x & !y)",
    "F (x & X !y)",
    "F (x & X (y | X y))",
    "F (x & F (y & z))",
    "F (x & X !y & X X !y)",
)
"""What breaks `G !x`, `!x W y`, `G (x -> X y)`, `G (x -> G[1,2] !y)`, `G (x -> G (y -> !z))`, `G (x -> F[1,2] y)`."""


BOUND = 16
"""Largest total cost of the plans that are compared."""


def drawn_rule(rng: random.Random, atoms: str, name: str, price: int | None) -> JudgedRule:
    """Return a rule of a shape that people write, or of any."""
    if rng.random() < 0.3:
        return JudgedRule(name, judge.random_formula(rng, atoms, rng.choice((1, 2, 3))), price)
    meant = dict(zip("xyz", rng.sample(atoms, 3), strict=True))
    bad = "".join(meant.get(letter, letter) for letter in rng.choice(BAD_PREFIXES))
    return JudgedRule(name, judge.parse(bad), price)


def drawn(seed: int, most: int = 8) -> tuple[GraphProblem, list[JudgedRule], Mapping[str, Any]]:
    """Return a random problem, some rules, of which at most two may be broken, and a preference over both.

    Few of the rules are such that no plan keeps them.
    """
    rng = random.Random(f"rules {seed}")
    atoms = "abcde" if seed % 2 else "abc"
    if seed % 2:
        problem = judge.random_errands(seed, "weighted-sum")
    else:
        problem = judge.random_problem(seed, kind="weighted-sum", relaxed=rng.random() < 0.4)
    rules = [drawn_rule(rng, atoms, f"rule{k}", rng.choice((1, 2, 4))) for k in range(rng.choice((0, 1, 1, 2)))]
    number = rng.randint(max(len(rules), 1), most)
    for _ in range(3 * number):
        if len(rules) == number:
            break
        rule = drawn_rule(rng, atoms, f"rule{len(rules)}", None)
        unkept = [each for each in (*rules, rule) if each.skip is None]
        if rng.random() < 0.05 or front_with_rules(problem, unkept, lambda costs, paid: 0, max_cost=BOUND):
            rules.append(rule)
    rng.shuffle(rules)
    names = [*problem.names, *(rule.name for rule in rules if rule.skip is not None)]
    terms = [{"kind": "weighted-sum", "over": "violation", "weights": {n: rng.choice((0, 1, 2)) for n in names}}]
    kind = rng.choice(("order", "weighted-sum", "max", "none"))
    if kind != "none":
        own = judge.random_preference(rng, problem.names, kind)
        terms.append(own if kind != "order" else {**own, "order": list(problem.names)})
    return problem, rules, {"kind": "sum", "terms": [{**term, "weight": 1} for term in terms]}


def solved(problem: GraphProblem, rules: list[JudgedRule], preference: Mapping[str, Any]) -> Problem:
    data = problem.scenario()
    data["model"]["propositions"] = sorted(set("abcde") - frozenset().union(*problem.labels.values()))
    data["preference"] = preference
    data["rules"] = [
        {"name": rule.name, "formula": f"!({judge.to_text(rule.bad)})"}
        | ({} if rule.skip is None else {"skip": rule.skip})
        for rule in rules
    ]
    return from_dict(data).problem()


def test_fronts_under_rules_agree_with_exhaustive_search() -> None:
    found = broken = none = 0
    for seed in range(90):
        problem, rules, preference = drawn(seed)
        ours = pareto_front(solved(problem, rules, preference), max_cost=BOUND)
        everything = [*problem.names, *(rule.name for rule in rules)]
        theirs = front_with_rules(problem, rules, _reference(preference, problem.names, everything), max_cost=BOUND)
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


@pytest.mark.parametrize("completed", [True, False])
def test_a_broken_rule_refutes_only_a_run_that_claims_to_be_completed(completed: bool) -> None:
    """A run that failed may have broken a rule, which its log says."""
    rule, task = Rule("dry", "G !wet"), Task("go", "F home")
    claims = Claims(completed, 1, {"go": 1}, {"go": 0}, 0 if completed else None)
    trace = [frozenset[str](), frozenset({"wet", "home"})]
    verdict = judged(claims, [task], Order(), trace, [Fraction(1)], rules=[rule])
    (found,) = (check for check in verdict.checks if check.words == "broken by action 1")
    assert (found.holds, found.finding) == (not completed, not completed)


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


def test_a_front_pays_for_no_rule_that_is_kept() -> None:
    front = pareto_front(hall(TWO_PRICES))
    assert [(plan.cost, plan.preference) for plan in front] == [(0, 13), (3, 5)]
    for plan in front:
        assert plan.violation_costs["kept"] == 0 and plan.violation_costs["broken"] == 3


def test_a_rule_that_nothing_keeps_is_broken_at_the_start() -> None:
    (cheap,) = pareto_front(hall(PAID.replace("G !carpet", "false")))
    assert (cheap.cost, cheap.preference) == (2, 2)
    assert [(purchase.task, purchase.step) for purchase in cheap.relaxations] == [("clean", 0)]
    with pytest.raises(NoPlanError, match="every plan breaks the rule clean"):
        cheapest_plan(hall(HALL.replace("G !carpet", "false") + '[preference]\nkind = "order"\n'))


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
        ("G !carpet", "F desk", "rules[0].formula: no safety formula: 'F desk' asks for something at any"),
        ("G !carpet", "!carpet U desk", "never comes; with `W` in place of `U` it need not come"),
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

PRICED = """kind = "sum"
[[preference.terms]]
kind = "weighted-sum"
over = "violation"
weight = 1
weights = { rule = 1 }
[[preference.terms]]
kind = "order"
weight = 1
order"""


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
@pytest.mark.parametrize("price", [None, 3, 30])
def test_models_that_are_not_listed_keep_rules_as_listed_ones_do(rule: str, price: int | None) -> None:
    text = BLOCKS.format(rule=rule)
    if price is not None:
        text = text.replace("[preference]", f"skip = {price}\n[preference]").replace('kind = "order"\norder', PRICED)
    listed = pareto_front(hall(text))
    scenario = loads(text)
    large = replace(scenario, model=replace(scenario.model, listed_states=0)).problem()
    generated = pareto_front(large)
    assert [(p.cost, p.preference) for p in generated] == [(p.cost, p.preference) for p in listed]
    assert generated.reason == listed.reason
    assert isinstance(product_of(large), GeneratedProduct)
    for plan in generated:
        paid = {purchase.task: purchase.step for purchase in plan.relaxations}
        assert large.broken(Ledger.of_plan(large, plan).labels) == paid


def test_rules_multiply_no_task() -> None:
    cells = [(7, 2), (1, 8), (4, 5), (9, 9), (2, 1), (6, 7), (3, 9), (8, 4), (0, 6)]
    regions = {f"r{k}": [(*cell, *cell)] for k, cell in enumerate(cells)}
    system = GridModel((10, 10), (0, 0), regions=regions).transition_system()
    tasks = [Task(f"t{k}", f"F (r{k} & F r{k + 3} & F r{k + 6})") for k in range(3)]
    apart = [Rule(f"apart{k}", f"G (r{k} -> G[1,6] !r{k + 1})") for k in range(6)]
    order = [Rule(f"after{k}", f"!r{k} W r{(k + 4) % 9}", skip=k + 1) for k in range(8)]
    weighed = WeightedSum({rule.name: 1 for rule in order}, over="violation")
    problem = Problem(system, tasks, Sum(((Order(), 1), (weighed, 1))), rules=[*apart, *order])
    assert [dfa.size for dfa in problem.weighted_automata] == [dfa.size for dfa in problem.automata]
    front = pareto_front(problem)
    assert front.complete and front.stats.states < 200_000
    for plan in front:
        paid = {purchase.task: purchase.step for purchase in plan.relaxations}
        assert problem.broken(Ledger.of_plan(problem, plan).labels) == paid


def test_many_tasks_and_a_start_that_breaks_a_rule_have_no_plan() -> None:
    regions = {f"p{k}": [(k % 5 + 1, k // 5 + 1) * 2] for k in range(8)} | {"home": [(0, 0, 0, 0)]}
    system = GridModel((6, 6), (0, 0), regions=regions).transition_system()
    tasks = [Task(f"t{k}", f"F p{k}") for k in range(8)]
    front = pareto_front(Problem(system, tasks, Order(), rules=[Rule("away", "G !home")]))
    assert (front.plans, front.complete) == ((), True) and front.reason is not None


def test_of_equally_cheap_plans_that_keep_many_rules_the_one_with_fewest_actions_is_found() -> None:
    chosen = random.Random(3)
    cells = [(x, y) for x in range(20) for y in range(20)]
    steps = [
        ((x, y), name, (x + dx, y + dy), chosen.choice([0, 0, 1]))
        for x, y in cells
        for name, (dx, dy) in {"E": (1, 0), "W": (-1, 0), "N": (0, 1), "S": (0, -1)}.items()
        if (x + dx, y + dy) in cells
    ]
    labels = {cell: [f"p{i}"] for i, cell in enumerate(chosen.sample(cells, 12))}
    tasks = {f"t{i}": f"F (p{2 * i} & F p{2 * i + 1})" for i in range(3)}
    rules = [Rule(f"r{k}", f"!p{6 + k} W p{k}") for k in range(4)]

    def cheapest(factor: int, each: int) -> Plan:
        priced = [(s, name, t, factor * cost + each) for s, name, t, cost in steps]
        system = TransitionSystem.from_transitions(priced, start=(0, 0), labels=labels)
        return Planner(Problem(system, tasks, Order(), rules=rules)).cheapest()

    plan, counted = cheapest(1, 0), cheapest(1000, 1)
    assert (plan.cost, len(plan.actions)) == divmod(int(counted.cost), 1000)
