"""Scenario files: their decoded values, files that are no scenario, and tasks that can never be satisfied."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from scenario_texts import GRAPH, GRID, TABLE, with_change

from prefplan import (
    Deadline,
    Due,
    GridModel,
    Location,
    ManipulationModel,
    NoPlanError,
    Object,
    Order,
    PrefplanError,
    ScenarioError,
    Task,
    WeightedSum,
    cheapest_plan,
    load,
    pareto_front,
)


def test_a_grid_scenario(file: Path) -> None:
    file.write_text(GRID)
    scenario = load(file)
    assert (scenario.name, scenario.path) == ("case", file)
    assert scenario.model == GridModel(
        (4, 3),
        (0, 0),
        1,
        regions={"cheese": ((2, 0, 3, 1),), "pizza": ((0, 2, 0, 2), (3, 2, 3, 2))},
        obstacles={"wall": ((1, 1, 1, 2),)},
    )
    assert scenario.tasks == (Task("eat", "F cheese"), Task("bake", "!cheese U pizza"))
    assert scenario.preference == Order(("bake", "eat"))
    assert [(plan.cost, plan.preference) for plan in pareto_front(scenario.problem())] == [(6, 0)]


def test_a_graph_scenario(file: Path) -> None:
    file.write_text(GRAPH)
    scenario = load(str(file))
    assert scenario.problem().system.propositions == {"plant", "rock"}
    plan = cheapest_plan(scenario.problem())
    assert (plan.cost, plan.preference, plan.actions) == (1.5, 0.15, ("east", "s2"))
    assert isinstance(scenario.preference, WeightedSum)


def test_a_manipulation_scenario(file: Path) -> None:
    file.write_text(TABLE)
    scenario = load(file)
    assert isinstance(scenario.model, ManipulationModel)
    assert scenario.model.locations == (
        Location("left", at=(0.50, 0.03)),
        Location("right", at=(0.50, -0.03)),
        Location("top", on=("left", "right")),
        Location("san", at=(0.45, 0.30), marks="clean"),
        Location("bin", at=(0.40, -0.30), capacity=2, kind="bin"),
    )
    assert scenario.model.objects == (Object("blue", "left", rgba=(0.1, 0.3, 0.9, 1)), Object("pink", "right"))
    assert scenario.preference == Deadline({"phi1": Due(20, 2)})
    assert cheapest_plan(scenario.problem()).cost == 3 + 1 + 5 + 1 + 1 + 5 + 1


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        (GRID, "cost = 1\n", ""),
        (GRID, 'order = ["bake", "eat"]\n', ""),
        (GRID, '["bake", "eat"]', '[["eat", "bake"]]'),
        (GRID, "[model.obstacles]\nwall = [1, 1, 1, 2]\n", ""),
        (GRID, "wall = [1, 1, 1, 2]", "true = [1, 1, 1, 2]"),
        (GRAPH, ', action = "east", cost = 1', ""),
        (GRAPH, 'propositions = ["rock"]\n', ""),
        (GRAPH, "F plant", "F (plant & !rock)"),
        (TABLE, 'start = "home"', 'start = "the parking pose"'),
        (TABLE, 'start = "home"', 'start = "san"'),
        (TABLE, ", weight = 2", ""),
        (TABLE, "phi1 = { by = 20, weight = 2 }", ""),
    ],
)
def test_what_may_be_left_out_or_said_otherwise(file: Path, text: str, old: str, new: str) -> None:
    file.write_text(with_change(text, old, new))
    assert pareto_front(load(file).problem())


def test_a_file_may_begin_with_a_byte_order_mark(file: Path) -> None:
    file.write_bytes(b"\xef\xbb\xbf" + GRID.encode())
    assert pareto_front(file)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="nowhere.toml: no such file$"):
        load(tmp_path / "nowhere.toml")


def test_a_pipe_in_the_folder_is_not_read_to_list_scenarios(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.toml")
    with pytest.raises(ScenarioError, match="no scenario named 'missing'"):
        load("missing")


def test_a_folder_is_no_scenario(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="cannot be read"):
        load(tmp_path)


@pytest.mark.parametrize("content", [b"size = [4, 3", b"size = 1\nsize = 2", b"\xff\xfe", b"F cheese"])
def test_a_file_that_is_not_toml(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    with pytest.raises(ScenarioError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}: not TOML: ")


@pytest.mark.parametrize(
    ("text", "old", "new", "sentence"),
    [
        (GRAPH, "F plant", "F rock", "task phi1 can never be satisfied"),
        (GRAPH, "F plant", "plant", "task phi1 can never be satisfied"),
        (GRID, "[[0, 2, 0, 2], [3, 2, 3, 2]]", "[3, 0, 3, 0]", "task bake can never be satisfied"),
        (TABLE, "F (blue_clean & blue_bin)", "F (blue_top & blue_bin)", "task phi1 can never be satisfied"),
        (
            GRID,
            "F cheese",
            "!pizza U cheese",
            "tasks eat, bake cannot be satisfied together, though any fewer of them can",
        ),
    ],
)
def test_tasks_that_can_never_be_satisfied_are_blamed(file: Path, text: str, old: str, new: str, sentence: str) -> None:
    file.write_text(with_change(text, old, new))
    problem = load(file).problem()
    with pytest.raises(NoPlanError) as caught:
        cheapest_plan(problem)
    assert str(caught.value) == str(pareto_front(problem).reason) == sentence


def test_all_errors_have_one_root() -> None:
    assert issubclass(ScenarioError, PrefplanError)
    assert issubclass(NoPlanError, PrefplanError)
