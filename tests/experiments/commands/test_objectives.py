"""`prefplan front` and `prefplan plan` with several costs and preferences, by name."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import pytest
from command_line import Run, assert_is_error
from scenario_texts import task_tables

DEPOT = """
[model]
kind = "graph"
start = "depot"
transitions = [
  { from = "depot", to = "hill", cost = { time = 1, energy = 5 } },
  { from = "depot", to = "plain", cost = { time = 3, energy = 2.5 } },
  { from = "hill", to = "goal", cost = { time = 1, energy = 1 } },
  { from = "plain", to = "goal", cost = { time = 1, energy = 1 } },
]
[model.labels]
goal = ["there"]
hill = ["view"]
""" + task_tables(arrive="F there", preference="")


@pytest.fixture
def depot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A goal that can be reached by a fast path and by one that saves energy."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "depot.toml"
    file.write_text(DEPOT)
    return file


def test_a_front_has_a_column_for_each_cost_and_preference(
    run: Run, depot: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    result = run("front", "depot.toml")
    assert (result.status, result.err) == (0, "")
    rows = [line.split() for line in result.out.splitlines()[1:4]]
    assert rows == [["#", "time", "energy", "arrive"], ["0", "2", "6", "2"], ["1", "4", "3.5", "4"]]
    assert "Pareto front of time and energy" in result.out


def test_points_in_json_have_every_objective_by_name(run: Run, depot: Path) -> None:
    points = run("front", "depot.toml", "--json").json["front"]
    assert [(point["costs"], point["preferences"], point["cost"], point["preference"]) for point in points] == [
        ({"time": 2, "energy": 6}, {}, 2, None),
        ({"time": 4, "energy": 3.5}, {}, 4, None),
    ]
    [point] = run("front", "example", "--max-cost", "8", "--json").json["front"]
    assert (point["costs"], point["preferences"]) == ({"cost": point["cost"]}, {"preference": point["preference"]})


@pytest.mark.parametrize(
    ("options", "times"),
    [
        (["--at-most", "energy=5"], [4]),
        (["--at-most", "energy=6", "--at-most", "time=3"], [2]),
        (["--at-most", "cost=3"], [2]),
        (["--at-most", "cost=3", "--at-most", "time=4"], [2]),
        (["--objective", "energy"], [4]),
        (["--objective", "cost"], [2]),
        (["--max-cost", "3"], [2]),
    ],
)
def test_fronts_within_bounds_and_of_some_objectives(
    run: Run, depot: Path, options: list[str], times: list[int]
) -> None:
    result = run("front", "depot.toml", "--json", *options)
    assert (result.status, [point["cost"] for point in result.json["front"]]) == (0, times)


@pytest.mark.parametrize(
    ("options", "time"),
    [
        ([], 2),
        (["--objective", "energy"], 4),
        (["--objective", "energy", "--at-most", "time=3"], 2),
        (["--plan", "1"], 4),
    ],
)
def test_one_plan_by_the_name_of_an_objective(run: Run, depot: Path, options: list[str], time: int) -> None:
    result = run("plan", "depot.toml", "--json", *options)
    assert (result.status, result.json["plan"]["cost"]) == (0, time)
    assert f"time {time}, energy" in run("plan", "depot.toml", *options).out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["front", "depot.toml", "--objective", "enrgy"],
            "--objective: unknown objective 'enrgy' (did you mean 'energy'?)",
        ),
        (
            ["plan", "depot.toml", "--objective", "energy", "--plan", "0"],
            ": --objective: chooses the plan instead of --plan; give one of them",
        ),
        (["plan", "depot.toml", "--objective", "preference"], "unknown objective 'preference' (valid: time, energy)"),
        (
            ["plan", "depot.toml", "--at-most", "speed=3"],
            ": --at-most: unknown objective 'speed' (valid: time, energy)",
        ),
        (
            ["front", "depot.toml", "--at-most", "enrgy=3"],
            ": --at-most: unknown objective 'enrgy' (did you mean 'energy'?)",
        ),
        (["front", "depot.toml", "--at-most", "time"], "'--at-most': 'time' is not NAME=VALUE, such as energy=40"),
        (
            ["front", "depot.toml", "--max-preference", "3"],
            ": --max-preference: there is no preference (valid: time, energy)",
        ),
        (
            ["plan", "depot.toml", "--max-preference", "3"],
            ": --max-preference: there is no preference (valid: time, energy)",
        ),
    ],
)
def test_names_that_do_not_exist_are_refused(run: Run, depot: Path, arguments: list[str], message: str) -> None:
    assert_is_error(run(*arguments), message)


def test_max_preference_bounds_the_first_preference_whatever_the_others_are_called(run: Run, depot: Path) -> None:
    named = "".join(
        f'[[preferences]]\nname = "{name}"\nkind = "weighted-sum"\nweights = {{ arrive = {weight} }}\n'
        for name, weight in (("late", 1), ("preference", 100))
    )
    depot.write_text(DEPOT + named)
    for command in ("front", "plan"):
        assert run(command, "depot.toml", "--max-preference", "2").status == 0


def test_pictures_and_reports_take_the_bounds_that_a_front_needs(run: Run, depot: Path) -> None:
    odd = 'name = "odd"\nkind = "expression"\nexpression = "abs(arrive - look) / (1 + arrive)"\nof = "energy"\n'
    depot.write_text(f"{DEPOT}{task_tables(look='F (view | there)', preference='')}[[preferences]]\n{odd}")
    for words in (["front", "depot.toml"], ["report", "depot.toml"], ["draw", "plans", "depot.toml", "depot.svg"]):
        assert_is_error(run(*words), "a bound on the cost that it counts in is needed (--at-most energy=VALUE")
        assert run(*words, "--at-most", "energy=6").status == 0
        assert run(*words, "--at-most", "energy=6", "--at-most", "preference=0.1", "--at-most", "cost=3").status == 3


def test_bounds_by_name_hold_for_one_cost_and_one_preference_too(run: Run) -> None:
    by_name = run("front", "example", "--at-most", "cost=8", "--json").json["front"]
    assert by_name == run("front", "example", "--max-cost", "8", "--json").json["front"]
    preferred = run("front", "example", "--at-most", "preference=3", "--json").json["front"]
    assert preferred == run("front", "example", "--max-preference", "3", "--json").json["front"]
    assert [point["cost"] for point in preferred] == [9]


def test_the_rover_trades_time_for_energy_and_order(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    points = run("front", "rover", "--json", "--plot", "rover.svg").json["front"]
    assert "<svg" in (tmp_path / "rover.svg").read_text()
    worth = [(*point["costs"].values(), *point["preferences"].values()) for point in points]
    assert len(points) == 15 and worth[0] == (68, 134, 35) and worth[-1] == (102, 89, 0)
    pairs = permutations(worth, 2)
    assert all(any(a < b for a, b in zip(one, other, strict=True)) for one, other in pairs)
