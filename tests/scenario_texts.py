"""Scenario files of each kind, and what is said of one that is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from prefplan import ScenarioError, load

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

[[tasks]]
name = "eat"
formula = "F cheese"

[[tasks]]
name = "bake"
formula = "!cheese U pizza"

[preference]
kind = "order"
order = ["bake", "eat"]
"""

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

[[tasks]]
name = "phi1"
formula = "F plant"

[preference]
kind = "weighted-sum"
weights = { phi1 = 0.1 }
"""

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

[[tasks]]
name = "phi1"
formula = "F (blue_clean & blue_bin)"

[preference]
kind = "deadline"
deadlines = { phi1 = { by = 20, weight = 2 } }
"""


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
