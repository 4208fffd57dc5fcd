"""Scenario files of each kind, and what is said of one that is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pytest

from prefplan import Front, Scenario, ScenarioError, load, pareto_front

ROOT = Path(__file__).parents[1]


def task_tables(*, preference: str = 'kind = "order"', **formulas: str) -> str:
    """Return the tables of tasks, by their names, and of a preference unless it is empty."""
    tasks = "".join(f'\n[[tasks]]\nname = "{name}"\nformula = "{text}"\n' for name, text in formulas.items())
    return tasks + (f"\n[preference]\n{preference}\n" if preference else "")


GRID = """
[model]
kind = "grid"
size = [4, 3]
start = [0, 0]
cost = 1
[model.regions]
cheese = [2, 0, 3, 1]
pizza = [[0, 2, 0, 2], [3, 2, 3, 2]]
[model.obstacles]
wall = [1, 1, 1, 2]
""" + task_tables(eat="F cheese", bake="!cheese U pizza", preference='kind = "order"\norder = ["bake", "eat"]')

GRAPH = """
[model]
kind = "graph"
start = "s0"
propositions = ["rock"]
transitions = [
  { from = "s0", to = "s1", action = "east", cost = 1 },
  { from = "s1", to = "s2", cost = 0.5 },
]
[model.labels]
s2 = ["plant"]
""" + task_tables(phi1="F plant", preference='kind = "weighted-sum"\nweights = { phi1 = 0.1 }')

TABLE = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
[model.locations]
left = { at = [0.50, 0.03] }
right = { at = [0.50, -0.03] }
top = { on = ["left", "right"] }
san = { at = [0.45, 0.30], marks = "clean" }
bin = { at = [0.40, -0.30], capacity = 2, kind = "bin" }
[model.objects]
blue = { start = "left", rgba = [0.1, 0.3, 0.9, 1] }
pink = { start = "right", fixed = false }
""" + task_tables(
    phi1="F (blue_clean & blue_bin)", preference='kind = "deadline"\ndeadlines = { phi1 = { by = 20, weight = 2 } }'
)

DETOUR = """
[model]
kind = "graph"
start = "s"
propositions = ["never"]
transitions = [
  { from = "s", to = "shop", cost = 1 },
  { from = "shop", to = "bank", cost = 2.5 },
  { from = "s", to = "bank", cost = 3 },
  { from = "bank", to = "shop", cost = 2 },
]
[model.labels]
shop = ["bread"]
bank = ["money"]
""" + task_tables(pay="F money", buy="F bread")

COSTS = "{ transit = 3, grasp = 1, transport = 5, release = 1 }"

PLACES = {"desk": "{ at = [0.45, 0.10] }", "tray": '{ at = [0.45, -0.25], kind = "bin" }'}

PLACES_NEARBY = PLACES | {"tray": "{ at = [0.45, -0.10] }"}
"""Places between which the arm is soon."""

TIDY = task_tables(tidy="F cup_tray")


def cup_scenario(tasks: str = TIDY, *, costs: str = COSTS, places: Mapping[str, str] = PLACES) -> str:
    """Return a scenario file of a cup that begins on the desk.

    Args:
        tasks: The tables of the tasks and of the preference.
        costs: The value of `model.costs`.
        places: The values of `model.locations`, in their order.
    """
    lines = "\n".join(f"{name} = {place}" for name, place in places.items())
    return f"""
[model]
kind = "manipulation"
start = "home"
costs = {costs}
[model.locations]
{lines}
[model.objects]
cup = {{ start = "desk" }}
{tasks}"""


CUP = cup_scenario()

WALLS = """[model.fixtures]
front = { kind = "box", at = [0.485, -0.15, 0.025], size = [0.02, 0.3, 0.05] }
side = { kind = "box", at = [0.4, -0.185, 0.025], size = [0.14, 0.02, 0.05] }
[model.locations]"""

CORNER = cup_scenario(
    places={"desk": "{ at = [0.45, -0.15] }", "tray": "{ at = [0.45, 0.15] }", "rest": "{ at = [0.4, 0.32] }"}
).replace("[model.locations]", WALLS)
"""A cup in a corner between two walls."""

PAST_A_TOWER = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 1, grasp = 1, transport = 1, release = 1 }
[model.locations]
left = { at = [0.5, 0.2] }
middle = { at = [0.5, 0.0] }
shelf = { on = ["middle"] }
top = { on = ["shelf"] }
right = { at = [0.5, -0.2] }
[model.objects]
cup = { start = "left" }
tin = { start = "middle", kind = "cylinder", size = [0.05, 0.06] }
box = { start = "shelf" }
can = { start = "top", kind = "cylinder", size = [0.05, 0.06] }
""" + task_tables(over="F cup_right")

RELAXED_CUP = cup_scenario(
    """
[[tasks]]
name = "serve"
formula = "F (cup_clean & cup_tray)"
relax = [{ assume = "cup_clean", when = "cup_tray", cost = 4 }]

[[tasks]]
name = "wash"
formula = "F cup_clean"
skip = 5

[preference]
kind = "weighted-sum"
over = "violation"
weights = { serve = 1, wash = 1 }
""",
    costs="{ transit = 0.5, grasp = 0.1, transport = 0.7, release = 0.2 }",
    places={"desk": PLACES["desk"], "tub": '{ at = [0.45, 0.32], marks = "clean" }', "tray": PLACES["tray"]},
)
"""A cup that may be served unwashed, for a price."""


def shipped(name: str) -> Scenario:
    """Return a scenario that comes with the program."""
    return load(ROOT / "experiments" / "scenarios" / f"{name}.toml")


@cache
def shipped_front(name: str) -> Front:
    """Return the whole front of such a scenario, planned once for all tests of a process."""
    return pareto_front(shipped(name).problem())


def error_of(file: Path, text: str) -> str:
    """Return the first line of the error that a scenario makes, without the file's name, which must come first."""
    file.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load(file).problem()
    first = str(caught.value).split("\n")[0]
    assert first.startswith(f"{file}: ")
    return first.removeprefix(f"{file}: ")


def with_change(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)
