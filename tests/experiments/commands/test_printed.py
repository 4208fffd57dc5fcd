"""What Python prints of fronts and plans is what the program prints."""

from __future__ import annotations

import re

import pytest
from command_line import Result, call
from scenario_texts import shipped_front

import prefplan as pp

SCENARIOS = ("example", "rover", "case_study_2", "case_study_3")
"""One cost and one preference, several of them, relaxations, and actions of several words."""


def told(text: str) -> str:
    """Return a text without the time of the search, and without the spaces that fill a column."""
    return re.sub(r" +$", "", re.sub(r"\d+\.\d\d s,", "", text), flags=re.MULTILINE)


def program(capsys: pytest.CaptureFixture[str], *arguments: str) -> Result:
    result = call(capsys, *arguments)
    assert result.status == 0
    return result


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_front_is_printed_as_the_program_prints_it(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert told(program(capsys, "front", name).out) == told(f"{name}: {shipped_front(name)}\n")


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_plan_is_printed_as_the_program_prints_it(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program(capsys, "plan", name).out == f"{name}: {pp.cheapest_plan(pp.load(name))}\n"


def test_the_assumptions_of_a_front_are_printed() -> None:
    example = pp.load("example")
    mean = pp.Function(lambda costs, violations: float(costs.sum()), contract="componentwise")
    front = pp.pareto_front(pp.Problem(example.model, example.tasks, mean))
    claim = "That the preference is componentwise is a claim of the scenario, tested on random costs only."
    assert front.assumptions == (claim,) and claim in str(front).splitlines()
