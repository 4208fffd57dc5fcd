"""The sentences of a report are derived from its plans, and true."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from scenario_texts import shipped_front, task_tables

import prefplan as pp
from experiments.report.data import check_plan, page_data
from experiments.report.differences import Parking, parkings
from experiments.report.explanations import Explanation, NamedPlan, explain, explain_cheapest
from experiments.report.preference_words import in_words, shares
from experiments.runs.formula_words import titles, words_of
from prefplan import Ledger, Scenario
from prefplan.preferences.kinds import Deadline, Due, Expression, Max, Order, Sum, WeightedSum
from prefplan.scenario.decode import loads
from prefplan.text.names import DisplayNames

CAMPUS = """
[model]
kind = "graph"
start = "gate"
transitions = [
  { from = "gate", to = "lab", cost = 2 },
  { from = "gate", to = "roof", cost = 9 },
  { from = "lab", to = "roof", cost = 4 },
  { from = "roof", to = "lab", cost = 2 },
]
[model.labels]
roof = ["view"]
lab = ["sample"]
""" + task_tables(look="F view", test="F sample")

SHIPPED = ("case_study_1", "case_study_2_skip20", "case_study_3", "case_study_3_energy", "example", "kitchen")


@cache
def named(name: str) -> tuple[Scenario, tuple[NamedPlan, ...]]:
    scenario = pp.load(name)
    problem = scenario.problem()
    return scenario, tuple(
        NamedPlan(plan, Ledger.of_plan(problem, plan), f"plan {i}" if i else "the cheapest")
        for i, plan in enumerate(shipped_front(name))
    )


def explained(name: str, i: int, j: int) -> Explanation:
    scenario, plans = named(name)
    return explain(scenario, plans[i], plans[j])


def refuted(name: str, plan: pp.Plan) -> list[str]:
    """Return the names of the checks that a plan fails."""
    problem = named(name)[0].problem()
    return [check.name for check in check_plan(problem, plan, Ledger.of_plan(problem, plan)) if not check.holds]


@pytest.mark.parametrize(
    ("name", "i", "j", "headline"),
    [
        (
            "case_study_3",
            1,
            0,
            "7 more than the cheapest: pink is put aside in bin 1 so that blue is done before pink.",
        ),
        (
            "case_study_1",
            1,
            0,
            "2 more than the cheapest: after tacos it goes to p4 instead of p3, so that phi2, preferred second, is off "
            "by 25 instead of 26.",
        ),
        (
            "case_study_1",
            2,
            1,
            "2 more than plan 1: after cheese it goes to p3 instead of tacos, so that phi2 and phi4 are done "
            "before phi5.",
        ),
        (
            "case_study_2_skip20",
            1,
            0,
            "10 more than the cheapest: after tacos it goes to grocer instead of cheese, so that phi4 is done as "
            "written instead of relaxed for 12 and phi5 is done as written instead of skipped for 20, although phi1 "
            "is relaxed for 15.",
        ),
        (
            "example",
            1,
            0,
            "3 more than the cheapest: it goes first to charge instead of dirt, so that phi1 is done before phi2 and "
            "phi3.",
        ),
        (
            "kitchen",
            1,
            0,
            "3 more than the cheapest: it takes 1 more transit so that ada (soup) and ben (pie) are done before cleo "
            "(fish).",
        ),
        (
            "kitchen_energy",
            9,
            6,
            "55.953 more than plan 6: pie is put aside on plate3 instead of on plate2 so that cleo (fish) is done "
            "before tidy (mug).",
        ),
    ],
)
def test_a_plan_says_why_it_costs_more(name: str, i: int, j: int, headline: str) -> None:
    assert explained(name, i, j)[0] == headline


def test_a_plan_on_a_graph_says_what_it_reaches_in_another_order() -> None:
    scenario = loads(CAMPUS)
    problem = scenario.problem()
    cheapest, preferred = (NamedPlan(p, Ledger.of_plan(problem, p), "the cheapest") for p in pp.pareto_front(problem))
    assert explain(scenario, preferred, cheapest)[0] == (
        "5 more than the cheapest: it first reaches view instead of sample, so that look is done before test."
    )


def test_a_plan_that_skips_every_task_has_no_order() -> None:
    weighed = 'kind = "weighted-sum"\nover = "violation"\nweights = { look = 1, test = 1 }'
    scenario = loads(CAMPUS.replace("[[tasks]]", "[[tasks]]\nskip = 3").replace('kind = "order"', weighed))
    problem = scenario.problem()
    idle, *_, busy = (NamedPlan(p, Ledger.of_plan(problem, p), "the cheapest") for p in pp.pareto_front(problem))
    assert not idle.ledger.order and busy.ledger.order
    assert not [line for line in explain(scenario, busy, idle)[1] if line.startswith("Order")]


def test_a_rule_has_no_place_in_the_order_of_the_tasks() -> None:
    scenario = loads(CAMPUS + '[[rules]]\nname = "apart"\nformula = "G !(view & sample)"\n')
    _, later = page_data(scenario, pp.pareto_front(scenario.problem()), {})["plans"]
    assert later["explanations"][0]["headline"].endswith("so that look is done before test.")


def test_a_plan_that_keeps_a_deadline_says_so() -> None:
    preferred = named("example")[1][-1].plan
    due = Due(preferred.task_costs["phi1"])
    scenario = replace(pp.load("example"), preference=Deadline({"phi1": due}))
    problem = scenario.problem()
    cheapest, *_, kept = (NamedPlan(p, Ledger.of_plan(problem, p), "the cheapest") for p in pp.pareto_front(problem))
    headline, _ = explain(scenario, kept, cheapest)
    assert kept.plan.preference == 0 and "misses" not in headline
    late = cheapest.plan.task_costs["phi1"] - due.by
    assert headline.endswith(f"so that phi1 is as preferred, by {due.by}, instead of off by {late}.")


@pytest.mark.parametrize("name", SHIPPED)
def test_every_plan_that_costs_more_gains_something(name: str) -> None:
    _, plans = named(name)
    for i in range(1, len(plans)):
        for j in {0, i - 1}:
            headline = explained(name, i, j)[0]
            extra = f"{plans[i].plan.cost - plans[j].plan.cost:.6f}".rstrip("0").rstrip(".")
            assert headline.startswith(f"{extra} more than {plans[j].name}: ")
            assert headline.endswith(".") and "  " not in headline and ": ." not in headline
            assert " so that " in headline


def test_the_details_of_case_study_3_are_those_of_its_plans() -> None:
    assert explained("case_study_3", 1, 0)[1] == [
        "Its penalty is 0 instead of 17.",
        "Done earlier: blue at 27 instead of 34.",
        "Done later: pink at 41 instead of 17.",
        "Order of the tasks: blue, pink; in the other plan: pink, blue.",
        "Only in this plan: grasp pink, transport pink bin 1, release pink bin 1.",
        "For a while, in this plan: pink is put aside in bin 1.",
    ]


@pytest.mark.parametrize(
    ("name", "headline", "detail"),
    [
        (
            "case_study_1",
            "No plan costs less.",
            "Its penalty of 29: phi2, preferred second, adds 26; phi4, preferred fourth, adds 3.",
        ),
        ("case_study_2_skip20", "No plan costs less.", "phi5 is skipped, for 20."),
    ],
)
def test_the_cheapest_plan_says_what_its_preference_is_made_of(name: str, headline: str, detail: str) -> None:
    scenario, plans = named(name)
    found, details = explain_cheapest(scenario, plans[0])
    assert found == headline and detail in details


def test_a_penalty_beyond_all_numbers_of_a_scenario_is_explained() -> None:
    weights = 'kind = "weighted-sum"\nover = "violation"\nweights = { look = 1e399 }'
    tasks = task_tables(look="F view", preference=weights).replace('"F view"', '"F view"\nskip = 1e399')
    scenario = loads(CAMPUS.partition("[[tasks]]")[0] + tasks)
    problem = scenario.problem()
    cheapest = pp.pareto_front(problem)[0]
    found, details = explain_cheapest(scenario, NamedPlan(cheapest, Ledger.of_plan(problem, cheapest), "A"))
    assert "costs nothing" in found and "1e+798" in details[0]


@pytest.mark.parametrize("name", SHIPPED)
def test_plans_pass_their_checks_and_shares_add_up(name: str) -> None:
    scenario, plans = named(name)
    for one in plans:
        assert refuted(name, one.plan) == []
        assert sum(share.adds for share in shares(scenario.preference, one.plan)) == pytest.approx(one.plan.preference)


@pytest.mark.parametrize(
    ("change", "claim"),
    [
        ({"cost": 33}, "total cost"),
        ({"preference": 0}, "preference"),
        ({"task_costs": {"phi1": 34, "phi2": 18}}, "task cost phi2"),
    ],
)
def test_a_plan_that_is_not_what_it_says_fails_its_checks(change: dict[str, object], claim: str) -> None:
    plan = named("case_study_3")[1][0].plan
    assert refuted("case_study_3", replace(plan, **change)) == [claim]  # type: ignore[arg-type]
    short = replace(plan, actions=plan.actions[:-1])
    assert "completed" in refuted("case_study_3", short)


def test_what_a_task_asks_for_is_not_parked() -> None:
    scenario, plans = named("kitchen")
    assert parkings(scenario.model, plans[0].ledger) == ()
    assert parkings(scenario.model, plans[5].ledger) == (Parking("pie", "on counter"), Parking("mug", "on board"))


def test_tasks_are_named_after_the_object_each_alone_is_about() -> None:
    assert titles(named("case_study_3")[0]) == {"phi1": "blue", "phi2": "pink"}
    assert titles(named("example")[0]) == {"phi1": "phi1", "phi2": "phi2", "phi3": "phi3"}


@pytest.mark.parametrize(
    ("preference", "adds", "words"),
    [
        (Order(("b", ("a", "c"))), {"b": 6, "a": 0, "c": 0}, "order of the tasks: b, a and c in any order."),
        (WeightedSum({"a": 2, "b": 0, "c": 1}), {"a": 8, "b": 0, "c": 2}, "2 × a + c"),
        (
            WeightedSum({"a": 2, "b": 0, "c": 1}, over="violation"),
            {"a": 2, "b": 0, "c": 0},
            "the tasks' violation costs",
        ),
        (Deadline({"b": Due(5, 3)}), {"b": 9}, "b, by 5 (weight 3)"),
        (
            Sum(((Order(), 2), (Deadline({"b": Due(5)}), 1))),
            {"a": 4, "b": 8 + 3, "c": 0},
            "the sum of 2 parts. (1) (weight 2)",
        ),
        (Max({"a": 3}), {}, "The worst task counts"),
        (Expression("a * b"), {}, "The penalty is a * b"),
    ],
)
def test_a_preference_is_told_in_words_and_shares(preference: pp.Preference, adds: dict[str, int], words: str) -> None:
    plan = pp.Plan(8, 0, {"a": 4, "b": 8, "c": 2}, {"a": 1, "b": 0, "c": 0}, (), ())
    found: dict[str, float] = {}
    for share in shares(preference, plan):
        found[share.task] = found.get(share.task, 0) + share.adds
    assert found == adds
    assert words in in_words(preference, ["a", "b", "c"], DisplayNames())


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("F tray", "eventually tray"),
        ("F (grocer & F p2)", "eventually (grocer and eventually p2)"),
        ("F ((a & b) & F c)", "eventually (a and b and eventually c)"),
        ("a U b U c", "a until (b until c)"),
        ("X X (a & b)", "one action later one action later (a and b)"),
        ("(lid -> open) U full", "(no lid or open) until full"),
        ("true | false", "anything or the impossible"),
    ],
)
def test_a_formula_in_words_keeps_its_parts_together(formula: str, words: str) -> None:
    assert words_of(pp.parse(formula)) == words


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("G !(view & sample)", "never: view and sample; it may be broken once, for 3"),
        ("G (sample -> !F view)", "never: sample and eventually view; it may be broken once, for 3"),
        ("X !view", "never: one action later view; it may be broken once, for 3"),
    ],
)
def test_a_rule_says_what_never_holds(formula: str, words: str) -> None:
    rule = f'[[rules]]\nname = "apart"\nformula = "{formula}"\nskip = 3\n'
    preference = '[preference]\nkind = "max"\nover = "violation"\n'
    scenario = loads(CAMPUS.partition("[preference]")[0] + rule + preference, name="campus")
    front = pp.pareto_front(scenario.problem())
    assert [one["words"] for one in page_data(scenario, front, {})["rules"]] == [words]
