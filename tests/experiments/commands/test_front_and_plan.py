"""`prefplan front` and `prefplan plan`: text and JSON, bounds, and why there is no plan."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from command_line import Run, assert_is_error
from scenario_texts import DETOUR, PLACES, cup_scenario, task_tables

from experiments.checks import diagnosis
from experiments.cli.choice import Wanted, choose
from experiments.regression.assertions import assert_completed
from experiments.runs import geometry
from prefplan.front import Front, UnfinishedError
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.scenario.decode import load


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Print as on a terminal without colours."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")


def cells(table: str) -> list[list[str]]:
    """Return the rows of a printed table, without its frame."""
    rows = [line.replace("┃", "│").split("│")[1:-1] for line in table.splitlines() if line.startswith(("│", "┃"))]
    return [[cell.strip() for cell in row] for row in rows]


def test_a_front_is_a_table_of_costs_and_its_plans(run: Run, detour: Path, terminal: None) -> None:
    result = run("front", "detour.toml")
    assert (result.status, result.err) == (0, "")
    assert cells(result.out) == [
        ["#", "cost", "penalty", "pay", "buy"],
        ["0", "3.5", "2.5", "3.5", "1"],
        ["1", "5", "0", "3", "5"],
    ]
    assert "1. shop, 2. bank" in result.out and "1. bank, 2. shop" in result.out


def test_off_a_terminal_a_front_is_plain_columns(run: Run, detour: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    out = run("front", "detour.toml").out
    rows = [line.split() for line in out.splitlines()[1:4]]
    assert rows == [
        ["#", "cost", "penalty", "pay", "buy"],
        ["0", "3.5", "2.5", "3.5", "1"],
        ["1", "5", "0", "3", "5"],
    ]
    assert out.isascii()


def test_no_color_turns_colours_off_on_a_terminal(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "CHECKS", (diagnosis.python,))
    colour = re.compile(r"\x1b\[[0-9;]*3[0-7]")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert colour.search(run("doctor").out)
    monkeypatch.setenv("NO_COLOR", "1")
    assert not colour.search(run("doctor").out)


def test_a_plan_is_told_with_its_costs(run: Run, detour: Path) -> None:
    result = run("plan", "detour.toml", "--objective", "preference")
    assert (result.status, result.err) == (0, "")
    assert "cost 5, penalty 0" in result.out
    assert "1. bank, 2. shop" in result.out


LOOP = """
[model]
kind = "graph"
start = "s0"
transitions = [
{transitions}
]
[model.labels]
s35 = ["end"]
[[tasks]]
name = "all"
formula = "F end"
[preference]
kind = "order"
"""


def test_the_front_shortens_a_long_plan_which_plan_shows_whole(run: Run, tmp_path: Path) -> None:
    steps = (f'{{ from = "s{k}", to = "s{k + 1}", action = "go r{k + 1}", cost = 1 }},' for k in range(35))
    Path("my loop.toml").write_text(LOOP.replace("{transitions}", "\n".join(steps)))
    out = run("front", "my loop.toml").out
    assert "30. go r30\n" in out and "go r31" not in out
    assert out.endswith("... and 5 more actions; `prefplan plan 'my loop.toml' --plan 0` prints all\n")
    assert "35. go r35" in run("plan", "my loop.toml", "--plan", "0").out
    bounded = run("front", "my loop.toml", "--max-preference", "9").out
    assert bounded.endswith("... and 5 more actions; with --json, all are printed\n")


def test_a_task_that_is_skipped_is_not_called_satisfied(run: Run, detour: Path) -> None:
    text = DETOUR.replace("F bread", "F never", 1).replace('"F never"', '"F never"\nskip = 2')
    detour.write_text(
        text.replace('kind = "order"', 'kind = "weighted-sum"\nover = "violation"\nweights = { buy = 1 }')
    )
    out = run("plan", "detour.toml").out
    assert "  pay satisfied at cost 3\n  buy not satisfied\n" in out and "  buy is skipped, for 2\n" in out


def test_a_narrow_terminal_cuts_no_number_of_a_front(run: Run, detour: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"FORCE_COLOR": "1", "TERM": "xterm", "NO_COLOR": "1", "COLUMNS": "30"}.items():
        monkeypatch.setenv(name, value)
    lines = re.sub(r"\x1b\[[0-9;]*m", "", run("front", "detour.toml").out).splitlines()
    table = [line for line in lines if line.startswith(("┃", "│"))]
    assert table and max(map(len, table)) <= 30 and "…" not in "".join(table)


def test_no_columns_are_as_many_as_a_line_needs(run: Run, detour: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS")
    shown = run("plan", "detour.toml").out
    monkeypatch.setenv("COLUMNS", "0")
    assert run("plan", "detour.toml").out == shown != ""


def test_a_terminal_too_narrow_for_a_front_still_shows_all_its_numbers(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {"FORCE_COLOR": "1", "TERM": "xterm", "NO_COLOR": "1", "COLUMNS": "10"}.items():
        monkeypatch.setenv(name, value)
    lines = re.sub(r"\x1b\[[0-9;]*m", "", run("front", "example").out).splitlines()
    rows = [line.split("│")[1:-1] for line in lines if line.startswith("│")]
    assert [[int(cell) for cell in row] for row in rows] == [[0, 6, 4, 6, 5, 2], [1, 9, 3, 4, 9, 6]]


def test_moves_on_a_grid_are_counted(run: Run) -> None:
    assert "2E N W N E" in run("plan", "example").out


POINT = {"cost", "preference", "task_costs", "plan"}

STATS = {"states": int, "expanded": int, "generated": int, "build_seconds": float, "seconds": float}


def assert_is_heading(found: dict[str, Any]) -> None:
    assert (found["scenario"], found["tasks"]) == ("detour", ["pay", "buy"])
    assert (found["contract"], found["complete"]) == ("additive", True)
    assert {key: type(value) for key, value in found["stats"].items()} == STATS


def test_a_front_as_json(run: Run, detour: Path) -> None:
    result = run("front", "detour.toml", "--json")
    assert (result.status, result.err) == (0, "")
    assert list(result.json) == [*HEADING, "complete", "front", "stats"]
    assert_is_heading(result.json)
    assert '"cost": 5,' in result.out, "a whole number"
    assert [{key: point[key] for key in POINT} for point in result.json["front"]] == [
        {"cost": 3.5, "preference": 2.5, "task_costs": {"pay": 3.5, "buy": 1}, "plan": ["shop", "bank"]},
        {"cost": 5, "preference": 0, "task_costs": {"pay": 3, "buy": 5}, "plan": ["bank", "shop"]},
    ]


def test_a_plan_as_json(run: Run, detour: Path) -> None:
    result = run("plan", "detour.toml", "--json")
    assert (result.status, result.err) == (0, "")
    assert list(result.json) == [*HEADING, "complete", "plan", "stats"]
    assert_is_heading(result.json)
    assert result.json["plan"]["plan"] == ["shop", "bank"]


@pytest.mark.parametrize(
    ("options", "cost"),
    [
        ([], 3.5),
        (["--objective", "cost"], 3.5),
        (["--plan", "preference"], 5),
        (["--plan", "0", "--max-preference", "2.5"], 3.5),
        (["--plan", "1"], 5),
        (["--max-preference", "2.5"], 3.5),
        (["--max-preference", "2.4"], 5),
        (["--max-preference", "0"], 5),
        (["--plan", "0", "--max-preference", "2.4"], 5),
        (["--plan", "0", "--at-most", "preference=2.4"], 5),
        (["--objective", "preference", "--max-preference", "0"], 5),
    ],
)
def test_one_plan_by_choice_and_bound(run: Run, detour: Path, options: list[str], cost: float) -> None:
    result = run("plan", "detour.toml", "--json", *options)
    assert (result.status, result.json["plan"]["cost"]) == (0, cost)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--plan", "2"], "--plan 2: the front has plans 0 to 1"),
        (["--plan", "1", "--max-preference", "2.4"], "--plan 1: the front has one plan, 0"),
    ],
)
def test_a_number_without_a_plan_within_the_bound(run: Run, detour: Path, options: list[str], message: str) -> None:
    assert_is_error(run("plan", "detour.toml", *options), message)


@pytest.mark.parametrize("command", ["front", "plan"])
def test_the_proposition_that_no_state_carries_is_named(run: Run, detour: Path, command: str) -> None:
    detour.write_text(DETOUR.replace("F bread", "F never"))
    result = run(command, "detour.toml")
    assert (result.status, result.err) == (
        3,
        "prefplan: task buy can never be satisfied\n"
        "prefplan: tasks[1].formula: no state that can be reached carries 'never'\n",
    )


@pytest.mark.parametrize(("limit", "costs"), [("3.5", [3.5]), ("4.99", [3.5]), ("5", [3.5, 5]), ("1000", [3.5, 5])])
def test_a_bound_on_cost_is_inclusive(run: Run, detour: Path, limit: str, costs: list[float]) -> None:
    result = run("front", "detour.toml", "--json", "--max-cost", limit)
    assert (result.status, [point["cost"] for point in result.json["front"]]) == (0, costs)


@pytest.mark.parametrize(
    ("changes", "arguments", "reason", "told"),
    [
        ({}, "front --max-cost 3.49", ("bound", [], 3.5), "smallest possible is 3.5"),
        ({"F bread": "F never"}, "front", ("task", ["buy"], None), "buy can never be satisfied"),
        ({"F bread": "F never"}, "plan", ("task", ["buy"], None), "buy can never be satisfied"),
        (
            {"F bread": "!money U (bread & X X money)"},
            "plan",
            ("task", ["buy"], None),
            "task buy can never be satisfied",
        ),
        ({"F bread": "bread | (never U X money)"}, "front --max-cost 0.5", ("bound", [], 3), "smallest possible is 3"),
        (
            {'kind = "order"': 'kind = "weighted-sum"\nweights = { pay = 1, buy = 0.1 }'},
            "plan --max-preference 3.49",
            ("bound", [], 3.5),
            "smallest possible is 3.5",
        ),
        (
            {"F money": "!bread U money", "F bread": "!money U bread"},
            "front",
            ("conflict", ["pay", "buy"], None),
            "tasks pay, buy cannot be satisfied together",
        ),
    ],
)
def test_without_a_plan_the_status_is_3_and_it_is_said_why(
    run: Run, detour: Path, changes: dict[str, str], arguments: str, reason: tuple[Any, ...], told: str
) -> None:
    text = DETOUR
    for old, new in changes.items():
        text = text.replace(old, new)
    detour.write_text(text)
    command, *options = arguments.split()
    result = run(command, "detour.toml", *options, "--json")
    assert result.status == 3 and told in result.err
    found = ["front"] if command == "front" else ["front", "plan"]
    assert list(result.json) == [*HEADING, "complete", *found, "reason", "stats"]
    assert (result.json["scenario"], result.json["tasks"]) == ("detour", ["pay", "buy"])
    assert (result.json["front"], result.json.get("plan")) == ([], None)
    assert result.json["reason"] == dict(zip(("kind", "tasks", "smallest"), reason, strict=True))
    result = run(command, "detour.toml", *options)
    assert (result.status, result.out) == (3, "") and told in result.err


@pytest.mark.parametrize(("option", "ended"), [("--max-seconds", "time"), ("--max-memory", "memory")])
@pytest.mark.parametrize("wanted", ["cost", "preference", "0"])
def test_a_limit_before_any_plan_is_known_has_status_4(
    run: Run, detour: Path, option: str, ended: str, wanted: str
) -> None:
    result = run("plan", "detour.toml", "--plan", wanted, option, "0", "--json")
    assert result.status == 4
    assert list(result.json) == [
        "scenario",
        "tasks",
        "contract",
        "claimed",
        "resolution",
        "complete",
        "plan",
        "ended",
        "complete_below",
        "within",
        "stats",
    ]
    assert (result.json["complete"], result.json["plan"], result.json["ended"]) == (False, None, ended)
    assert len(result.err.splitlines()) == 1 and "no plan is known yet" in result.err


@pytest.mark.parametrize(
    "command", ["front ring.toml", "plan ring.toml", "check ring.toml", "draw plans ring.toml ring.svg"]
)
def test_time_is_counted_from_the_first_line_of_a_file_on(run: Run, tmp_path: Path, command: str) -> None:
    (tmp_path / "ring.gr").write_text("p sp 9 9\n" + "".join(f"a {k + 1} {(k + 1) % 9 + 1} 1\n" for k in range(9)))
    model = '[model]\nkind = "graph"\nfile = "ring.gr"\nstart = 1\n[model.labels]\n5 = ["goal"]\n'
    (tmp_path / "ring.toml").write_text(
        model + '[[tasks]]\nname = "go"\nformula = "F goal"\n[preference]\nkind = "order"\n'
    )
    result = run(*command.split(), "--max-seconds", "0")
    assert (result.status, result.out, result.err) == (4, "", "prefplan: stopped by the time limit\n")
    assert not (tmp_path / "ring.svg").exists()


@pytest.mark.parametrize(("below", "number", "best"), [(20, 1, None), (15, 1, 1), (15, 3, 2), (5, 0, 0), (None, 2, 2)])
def test_a_front_that_was_stopped_has_the_plan_of_an_index_or_the_nearest(
    detour: Path, below: int | None, number: int, best: int | None
) -> None:
    """`best` is the index of the plan reported as the best so far, None if the plan asked for is certain."""
    plans = tuple(Plan(cost, -cost, {}, {}, (), ()) for cost in (5, 15, 25))
    planner = Planner(load("detour.toml").problem())
    planner.front = lambda **_: Front(plans, ended="interrupt", complete_below=below)  # type: ignore[method-assign]
    if best is None:
        assert choose(planner, Wanted(number)) is plans[number]
        return
    with pytest.raises(UnfinishedError) as caught:
        choose(planner, Wanted(number), keep_on_interrupt=True)
    assert caught.value.best is plans[best] and caught.value.ended == "interrupt"


def test_a_plan_within_its_limits_is_the_same_plan(run: Run, detour: Path) -> None:
    limited = run("plan", "detour.toml", "--max-seconds", "600", "--max-memory", "1000", "--json")
    assert (limited.status, limited.json["plan"]) == (0, run("plan", "detour.toml", "--json").json["plan"])


HEADING = ("scenario", "tasks", "contract", "claimed", "resolution")

GENERAL = 'kind = "expression"\nexpression = "pay * buy"\ncontract = "general"'


def test_a_general_preference_asks_for_a_bound_and_takes_it(run: Run, detour: Path) -> None:
    detour.write_text(DETOUR.replace('kind = "order"', GENERAL))
    for call in (["front"], ["plan", "--objective", "preference"]):
        assert_is_error(
            run(*call, "detour.toml"), "a bound on the total cost is needed (--max-cost C, in Python max_cost=C)"
        )
        assert run(*call, "detour.toml", "--max-cost", "5").status == 0


@pytest.mark.parametrize("wanted", ["cost", "preference", 0])
def test_run_chooses_among_the_plans_within_the_bound(detour: Path, wanted: str | int) -> None:
    detour.write_text(DETOUR.replace('kind = "order"', GENERAL))
    planner = Planner(load(str(detour)).problem())
    assert choose(planner, Wanted(wanted, max_cost=4)).actions == ("shop", "bank")


ROOF = """[model.fixtures]
roof = { kind = "box", at = [0.45, -0.25, 0.16], size = [0.3, 0.3, 0.02] }
[model.locations]"""
"""A roof over the tray, too low for the hand."""

AWAY = task_tables(tidy="F (cup_tray | (cup_side & F (cup_desk & F cup_side)))")


def roofed() -> str:
    places = PLACES | {"tray": "{ at = [0.45, -0.25] }", "side": "{ at = [0.45, 0.3] }"}
    return cup_scenario(AWAY, places=places).replace("[model.locations]", ROOF)


@pytest.mark.parametrize("command", ["front", "plan"])
def test_what_the_arm_cannot_do_is_not_planned_and_its_price_is_named(run: Run, detour: Path, command: str) -> None:
    Path("roof.toml").write_text(roofed())
    found = run(command, "roof.toml", "--json")
    plan = found.json["front"][0] if command == "front" else found.json["plan"]
    assert (found.status, found.err, plan["plan"][-1]) == (0, "", "release cup side")
    assert [(one["object"], one["location"]) for one in found.json["left_out"]] == [("cup", "tray")]
    assert found.json["geometry"] == "checked" and found.json["if_it_could"][0]["cost"] < plan["cost"]
    [line] = [line for line in run(command, "roof.toml").out.splitlines() if line.startswith("The arm cannot do")]
    assert "cup at tray (" in line
    abstract = run(command, "roof.toml", "--abstract", "--json").json
    assert abstract["geometry"] == "abstract" and "left_out" not in abstract
    said = roofed().replace("[model]", "[model]\nabstract = true", 1)
    Path("said.toml").write_text(said)
    assert run(command, "said.toml", "--json").json["geometry"] == "abstract"


@pytest.mark.slow
def test_a_run_that_is_asserted_is_that_of_a_plan_that_the_arm_can_keep(detour: Path) -> None:
    Path("roof.toml").write_text(roofed())
    outcome = assert_completed("roof.toml")
    assert (outcome.executed[-1], outcome.run.replans) == ("release cup side", 0)


def test_no_plan_is_left_where_the_arm_cannot_do_what_a_task_needs(run: Run, detour: Path) -> None:
    Path("roof.toml").write_text(roofed().replace(AWAY, task_tables(tidy="F cup_tray")))
    found = run("plan", "roof.toml", "--json")
    assert (found.status, found.json["plan"]) == (3, None)
    first, second = found.err.splitlines()
    assert first == "prefplan: task tidy can never be satisfied"
    assert second.startswith("prefplan: The arm cannot do cup at tray (")


def test_that_the_arm_could_not_be_asked_is_said(run: Run, detour: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("near.toml").write_text(cup_scenario(places=PLACES | {"tray": "{ at = [0.45, 0.11] }"}))
    found = run("front", "near.toml", "--json")
    assert (found.status, found.json["geometry"]) == (0, "not checked")
    assert found.err.startswith("prefplan: geometry not checked: near.toml: model.locations.tray: ")
    Path("low.toml").write_text(roofed().replace('start = "home"', 'start = "tray"'))
    found = run("front", "low.toml", "--json")
    assert (found.status, found.json["geometry"]) == (0, "not checked")
    assert found.err.startswith("prefplan: geometry not checked: low.toml: model.start: the hand cannot begin over ")
    monkeypatch.setattr(geometry, "has_simulation", lambda: False)
    found = run("front", "near.toml", "--json")
    assert (found.status, found.json["geometry"]) == (0, "not checked")
    assert found.err == "prefplan: geometry not checked: the simulation is not installed; see `prefplan doctor`\n"
    assert run("front", "near.toml", "--quiet").err == ""
