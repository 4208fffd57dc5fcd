"""The ledger of plans and of observed actions."""

from __future__ import annotations

from fractions import Fraction

import pytest
from scenario_texts import shipped, shipped_front

from prefplan import Ledger, Problem

SHIPPED = ("case_study_1", "case_study_2_skip20", "case_study_3", "case_study_3_energy", "example")


@pytest.fixture(scope="module")
def example() -> Problem:
    return shipped("example").problem()


@pytest.mark.parametrize("name", SHIPPED)
def test_a_plan_costs_what_it_says(name: str) -> None:
    problem = shipped(name).problem()
    for plan in shipped_front(name):
        ledger = Ledger.of_plan(problem, plan)
        end = ledger.final
        assert (end.cost, end.preference) == (plan.cost, plan.preference)
        assert (end.task_costs, end.violation_costs) == (plan.task_costs, plan.violation_costs)
        values = [entry.preference for entry in ledger.entries]
        assert len(values) == len(plan.actions) + 1 and values == sorted(values)
        for task, step in ledger.satisfied.items():
            assert plan.task_costs[task] == (plan.cost if step is None else ledger.entry(step).cost)
            assert not step or step in ledger.advances(task)


def test_a_ledger_of_observations_reads_what_was_observed(example: Problem) -> None:
    labels = [frozenset[str](), frozenset({"plant"}), frozenset({"charge"})]
    seen = Ledger.of(example, ["N", "E"], [1, 1], labels)
    dead = example.automata[2].dead
    assert seen.satisfied["phi1"] == 2 and seen.states["phi3"] == (0, dead, dead)
    assert [entry.satisfied for entry in seen.entries][:2] == [frozenset(), frozenset()]
    assert "phi1" in seen.final.satisfied and seen.order[0] == "phi1"


def test_a_skipped_task_has_no_states_and_what_is_paid_counts_from_its_step_on() -> None:
    name = "case_study_2_skip20"
    ledger = Ledger.of_plan(shipped(name).problem(), shipped_front(name)[0])
    assert ledger.states["phi5"] is None and ledger.satisfied["phi5"] is None and ledger.advances("phi5") == ()
    assert "phi5" not in ledger.order and "phi5" not in ledger.final.satisfied

    for step, entry in enumerate(ledger.entries):
        paid = sum(bought.cost for bought in ledger.relaxations if bought.step <= step)
        assert sum(entry.violation_costs.values()) == paid


def test_decimal_costs_add_up_exactly(example: Problem) -> None:
    ledger = Ledger.of(example, ["N"] * 3, [0.1, 0.2, 0.3], [frozenset()] * 4)
    assert ledger.spent == (0, Fraction(1, 10), Fraction(3, 10), Fraction(6, 10))
    assert ledger.final.cost == 0.6
