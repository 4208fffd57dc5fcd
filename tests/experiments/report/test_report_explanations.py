"""What a report says of plans is derived from them, and true."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

import prefplan as pp
from experiments import scenarios
from experiments.report.differences import Parking, parkings
from experiments.report.explanations import Explanation, Told, explain, explain_cheapest, titles
from experiments.report.plan_checks import check_plan
from experiments.report.timeline import plan_timeline, timeline
from experiments.report.wishes import in_words, wishes
from prefplan.preferences.kinds import Deadline, Due, Expression, Max, Order, Sum, WeightedSum
from prefplan.scenario.decode import Scenario

SHIPPED = ("case_study_1", "case_study_2_skip20", "case_study_3", "case_study_3_energy", "example", "kitchen")


@cache
def told(name: str) -> tuple[Scenario, tuple[Told, ...]]:
    scenario = scenarios.find(name)
    problem = scenario.problem()
    front = pp.pareto_front(problem)
    names = ["the cheapest", *(f"plan {i}" for i in range(1, len(front)))]
    return scenario, tuple(
        Told(plan, plan_timeline(problem, plan), name) for plan, name in zip(front, names, strict=True)
    )


def explained(name: str, i: int, j: int) -> Explanation:
    scenario, plans = told(name)
    return explain(scenario, plans[i], plans[j])


@pytest.mark.parametrize(
    ("name", "i", "j", "headline"),
    [
        ("case_study_3", 1, 0, "7 more than the cheapest: pink is parked in bin1 so that phi1 (blue) is done first."),
        (
            "case_study_1",
            1,
            0,
            "2 more than the cheapest: from tacos it goes to p4, not to p3, so that phi2, wished second, is done "
            "25 after its turn instead of 26 after it.",
        ),
        (
            "case_study_1",
            2,
            1,
            "2 more than plan 1: from cheese it goes to p3, not to tacos, so that phi2 and phi4 are done before phi5.",
        ),
        (
            "case_study_1",
            5,
            4,
            "14 more than plan 4: it goes first to tacos, not to grocer, so that phi1 is done first.",
        ),
        (
            "case_study_2_skip20",
            1,
            0,
            "10 more than the cheapest: from tacos it goes to p3, not to grocer, so that phi4 is done as it is written "
            "instead of relaxed for 12 and phi5 is done as it is written instead of skipped for 20, though phi1 is "
            "relaxed for 15.",
        ),
        (
            "example",
            1,
            0,
            "3 more than the cheapest: it goes first to charge, not to dirt, so that phi1 is done first.",
        ),
        ("kitchen", 1, 0, "3 more than the cheapest: it takes 1 more transit so that ben (pie) is done second."),
        (
            "kitchen",
            6,
            5,
            "3 more than plan 5: mug is parked on board rather than on stove so that cleo (fish) is done third.",
        ),
    ],
)
def test_a_plan_says_why_it_costs_more(name: str, i: int, j: int, headline: str) -> None:
    assert explained(name, i, j).headline == headline


@pytest.mark.parametrize("name", SHIPPED)
def test_every_plan_that_costs_more_gains_something_that_is_said(name: str) -> None:
    _, plans = told(name)
    for i in range(1, len(plans)):
        for j in {0, i - 1}:
            headline = explained(name, i, j).headline
            assert headline.startswith(f"{output_number(plans[i].plan.cost, plans[j].plan.cost)} more than ")
            assert headline.endswith(".") and "  " not in headline and ": ." not in headline
            assert " so that " in headline


def output_number(one: float, other: float) -> str:
    return f"{one - other:.6f}".rstrip("0").rstrip(".")


def test_the_details_of_case_study_3_are_those_of_its_plans() -> None:
    assert explained("case_study_3", 1, 0).details == (
        "Its preference is 0 instead of 17.",
        "Done earlier: phi1 (blue) at 27 instead of 34.",
        "Done later: phi2 (pink) at 41 instead of 17.",
        "Tasks are done in the order phi1 (blue), phi2 (pink); in the other plan phi2 (pink), phi1 (blue).",
        "Only in this plan: grasp pink, transport pink bin1, release pink bin1.",
        "Put aside for a while in this plan: pink in bin1.",
    )


def test_the_cheapest_plan_says_what_it_falls_short_of() -> None:
    scenario, plans = told("case_study_1")
    explanation = explain_cheapest(scenario, plans[0])
    assert explanation.headline == "No plan costs less."
    assert explanation.details[0] == (
        "Its preference of 29: phi2, wished second, adds 26; phi4, wished fourth, adds 3."
    )


@pytest.mark.parametrize("name", SHIPPED)
def test_timelines_agree_with_the_plans(name: str) -> None:
    _, plans = told(name)
    for one in plans:
        assert one.timeline.spent[-1] == one.plan.cost
        for task, track in one.timeline.tracks.items():
            end = one.plan.cost if track.satisfied is None else one.timeline.spent[track.satisfied]
            assert one.plan.task_costs[task] == end
            if track.satisfied:
                assert track.satisfied in track.advances


@pytest.mark.parametrize("name", SHIPPED)
def test_wishes_add_up_to_the_preference(name: str) -> None:
    scenario, plans = told(name)
    for one in plans:
        assert sum(wish.adds for wish in wishes(scenario.preference, one.plan)) == pytest.approx(one.plan.preference)


@pytest.mark.parametrize("name", SHIPPED)
def test_plans_pass_their_checks(name: str) -> None:
    scenario, plans = told(name)
    for one in plans:
        checks = check_plan(scenario.problem(), one.plan, one.timeline)
        assert checks and all(check.holds for check in checks)


@pytest.mark.parametrize(
    ("change", "refuted"),
    [
        ({"cost": 33}, "total cost"),
        ({"preference": 0}, "preference"),
        ({"task_costs": {"phi1": 34, "phi2": 18}}, "cost of phi2"),
    ],
)
def test_a_plan_that_is_not_what_it_says_fails_its_checks(change: dict[str, object], refuted: str) -> None:
    scenario, plans = told("case_study_3")
    plan = replace(plans[0].plan, **change)  # type: ignore[arg-type]
    checks = check_plan(scenario.problem(), plan, plans[0].timeline)
    assert [check.name for check in checks if not check.holds] == [refuted]


def test_a_plan_that_is_cut_short_fails_its_checks() -> None:
    scenario, plans = told("case_study_3")
    short = replace(plans[0].plan, actions=plans[0].plan.actions[:-1])
    checks = check_plan(scenario.problem(), short, plan_timeline(scenario.problem(), short))
    assert "phi1" in [check.name for check in checks if not check.holds]


def test_a_relaxation_that_is_not_on_offer_fails_its_check() -> None:
    scenario, plans = told("case_study_2_skip20")
    plan = plans[0].plan
    dearer = tuple(replace(bought, cost=1) for bought in plan.relaxations)
    problem = scenario.problem()
    plan = replace(plan, relaxations=dearer)
    checks = check_plan(problem, plan, plan_timeline(problem, plan))
    assert "phi5 relaxed for 1" in [check.name for check in checks if not check.holds]


def test_what_a_task_asks_for_is_not_parked() -> None:
    scenario, plans = told("kitchen")
    problem = scenario.problem()
    assert parkings(scenario.model, problem, plans[0].timeline) == ()
    assert parkings(scenario.model, problem, plans[5].timeline) == (Parking("pie", "plate3"), Parking("mug", "stove"))


def test_tasks_are_named_after_the_object_each_alone_is_about() -> None:
    assert titles(told("case_study_3")[0]) == {"phi1": "phi1 (blue)", "phi2": "phi2 (pink)"}
    assert titles(told("example")[0]) == {"phi1": "phi1", "phi2": "phi2", "phi3": "phi3"}


def test_a_skipped_task_has_no_states() -> None:
    _, plans = told("case_study_2_skip20")
    track = plans[0].timeline.tracks["phi5"]
    assert track.states is None and track.satisfied is None and track.advances == ()
    assert "phi5" not in plans[0].timeline.order


def test_a_timeline_of_observations_reads_what_was_observed() -> None:
    scenario, _ = told("example")
    labels = [frozenset[str](), frozenset({"plant"}), frozenset({"charge"})]
    seen = timeline(scenario.problem(), ["N", "E"], [1, 1], labels, ())
    phi3 = scenario.problem().automata[2]
    assert seen.tracks["phi1"].satisfied == 2
    assert seen.tracks["phi3"].states == (0, phi3.dead, phi3.dead)


@pytest.mark.parametrize(
    ("preference", "adds", "words"),
    [
        (Order(("b", ("a", "c"))), {"b": 6, "a": 0, "c": 0}, "in this order: b, a and c in any order."),
        (WeightedSum({"a": 2, "b": 0, "c": 1}), {"a": 8, "b": 0, "c": 2}, "2 × a + c"),
        (Deadline({"b": Due(5, 3)}), {"b": 9}, "b by 5 (weight 3)"),
        (
            Sum(((Order(), 2), (Deadline({"b": Due(5)}), 1))),
            {"a": 4, "b": 8 + 3, "c": 0},
            "the sum of 2 parts. (1) (weight 2)",
        ),
        (Max({"a": 3}), {}, "The task that comes off worst counts"),
        (Expression("a * b"), {}, "The preference is a * b"),
    ],
)
def test_a_preference_is_told_in_words_and_amounts(preference: pp.Preference, adds: dict[str, int], words: str) -> None:
    plan = pp.Plan(8, 0, {"a": 4, "b": 8, "c": 2}, {"a": 0, "b": 0, "c": 0}, (), ())
    found: dict[str, float] = {}
    for wish in wishes(preference, plan):
        found[wish.task] = found.get(wish.task, 0) + wish.adds
    assert found == adds
    assert words in in_words(preference, ["a", "b", "c"])
