"""A scenario in one line: what it is about, without planning."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import dropwhile, takewhile

from prefplan.models.graph import GraphModel
from prefplan.models.grid import GridModel
from prefplan.preferences.objective import Measure
from prefplan.scenario.decode import Model, Scenario


@dataclass(frozen=True)
class Overview:
    """Entry of a scenario in the list.

    Attributes:
        name: its name for other commands.
        kind: of its model: `graph`, `grid` or `manipulation`.
        tasks: number of tasks.
        contract: of its preference.
        summary: the first sentence of the comment that its file begins with; empty if it has none.
    """

    name: str
    kind: str
    tasks: int
    contract: str
    summary: str


def overview(scenario: Scenario) -> Overview:
    """Return the entry of a scenario, without building its transition system."""
    names = [task.name for task in scenario.tasks]
    contract = Measure.of(scenario.preference.terms(names), len(names)).contract
    return Overview(scenario.name, kind_of(scenario.model), len(names), contract, first_sentence(scenario.text))


def kind_of(model: Model) -> str:
    """Return a model's kind as scenario files call it."""
    match model:
        case GraphModel():
            return "graph"
        case GridModel():
            return "grid"
    return "manipulation"


def first_sentence(text: str) -> str:
    """Return the first sentence of a file's introduction."""
    return re.split(r"(?<=[.!?])\s", introduction(text), maxsplit=1)[0]


def introduction(text: str) -> str:
    """Return the first paragraph of the comment that opens a file, on one line, without the file's name before it."""
    opening = re.match(r"(?:[ \t]*#[^\n]*\n)*", text)
    assert opening is not None
    lines = [line.strip().lstrip("#").strip() for line in opening[0].splitlines()]
    paragraph = " ".join(takewhile(bool, dropwhile(lambda line: not line, lines)))
    return re.sub(r"^\S+\.toml: ", "", paragraph)
