"""`prefplan measure`, and plans with costs that it measured."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from command_line import Run
from joblib.externals.loky.process_executor import TerminatedWorkerError
from scenario_texts import cup_scenario, shipped_front
from skill_runs import contacts

from experiments import scenarios
from experiments.runs import run_plan
from experiments.runs.outcome import outcome_json
from prefplan import load, pareto_front
from prefplan.models.manipulation.measured_costs import measurements_file
from sim.execution import cost_measurement

SCENARIO = cup_scenario(costs='{ measured = "energy" }')

MEASURED = [name for name in scenarios.names() if measurements_file(scenarios.FOLDER / f"{name}.toml").exists()]

EXECUTED = {"case_study_3_energy": -1, "kitchen_energy": 4}
"""Plans that are carried out: the preferred one, and in the kitchen the one with the least accurate costs."""

PAIRS = 2 + 2 + 2 + 2 + 2
"""Transits from the start pose and between the places, transports, grasps, releases."""


@pytest.fixture
def scenario(run: Run, tmp_path: Path) -> Path:
    path = tmp_path / "cup.toml"
    path.write_text(SCENARIO)
    return path


BENCH = """<mujoco><worldbody>
<geom type="box" size="1 1 0.1" pos="0 0 -0.1"/><site name="here" pos="0.45 0.2 0"/>
<body name="mug"><freejoint/><geom type="box" size="0.02 0.02 0.02"/></body>
</worldbody></mujoco>"""


def test_measurements_in_a_scene_of_the_users_own_are_those_of_its_scenario(
    scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    (scenario.parent / "bench.xml").write_text(BENCH)
    places = {"desk": '{ site = "here" }', "tray": "{ at = [0.45, -0.2] }"}
    text = cup_scenario(costs='{ measured = "energy" }', places=places).replace(
        "[model]", '[model]\nscene = "bench.xml"'
    )
    scenario.write_text(text.replace('start = "desk" }', 'start = "desk", body = "mug" }'))
    monkeypatch.setattr(cost_measurement, "measure_all", lambda scene, wanted, jobs: iter(()))
    assert run("measure", "cup.toml", "--jobs", "1")[0] == 0
    assert "were made with" not in run("front", "cup.toml").err
    (scenario.parent / "bench.xml").write_text(BENCH.replace('pos="0.45 0.2 0"', 'pos="0.45 0.25 0"'))
    result = run("front", "cup.toml")
    assert result.status == 2 and "the measurements were made with another bench.xml; `prefplan measure`" in result.err


def test_of_another_robot_it_is_told_whose_costs_are_predicted(scenario: Path, run: Run) -> None:
    assert run("measure", "cup.toml", "--jobs", "1").status == 0
    result = run("run", "cup.toml", "--robot", "panda_suction", "--no-video")
    words = "model.costs.measured: costs are predicted for panda, not for panda_suction"
    assert result.status == 0 and f"warning: cup.toml: {words}\n" in result.err


def test_what_was_measured_is_planned_with_and_comes_true(scenario: Path, run: Run) -> None:
    status, _, err = run("front", "cup.toml")
    assert status == 2 and "nothing was measured yet; `prefplan measure`" in err

    status, out, _ = run("measure", "cup.toml", "--json", "--jobs", "1")
    assert status == 0
    printed = json.loads(out)
    assert printed["complete"] is True and printed["failed"] == [] and len(printed["actions"]) == PAIRS
    assert json.loads(measurements_file(scenario).read_text())["actions"] == printed["actions"]
    assert all(one["time"] > 0 and one["travel"] > 0 and one["energy"] > 0 for one in printed["actions"])

    (plan,) = pareto_front(load(scenario).problem())
    status, out, _ = run("run", "cup.toml", "--no-video", "--seed", "2")
    assert status == 0 and f"J, predicted {plan.cost:g} J" in out
    measured = json.loads(Path("out/cup/cost.json").read_text())["measured"]
    assert measured["quantity"] == "energy" and measured["predicted"] == plan.cost
    assert measured["executed"] == pytest.approx(plan.cost, rel=0.05)


def stand_in(limit: int | None = None, end: type[BaseException] = KeyboardInterrupt) -> Callable[..., Iterator[Any]]:
    """Return a stand-in for measurements that takes no time, and ends early after some actions."""

    def measure_all(scene: Any, wanted: Any, *, jobs: int) -> Iterator[Any]:
        for count, pair in enumerate(wanted):
            if count == limit:
                raise end
            yield cost_measurement.Measurement(pair, {"time": 1.0, "travel": 2.0, "energy": 3.0}, 1)

    return measure_all


@pytest.mark.parametrize(
    ("end", "status", "words"),
    [(KeyboardInterrupt, 130, "interrupted"), (TerminatedWorkerError, 4, "a process that measured was killed")],
)
def test_what_ends_early_keeps_what_is_done_and_the_next_run_does_the_rest(
    scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch, end: type[BaseException], status: int, words: str
) -> None:
    monkeypatch.setattr(cost_measurement, "measure_all", stand_in(3, end))
    result = run("measure", "cup.toml")
    assert (result.status, result.err) == (
        status,
        f"prefplan: {words}; the same command measures the other 7 actions\n",
    )
    status, _, err = run("front", "cup.toml")
    assert status == 2 and "costs.measured: the measurement was interrupted; `prefplan measure` with" in err
    monkeypatch.setattr(cost_measurement, "measure_all", stand_in())
    status, out, err = run("measure", "cup.toml")
    assert (status, err) == (0, "") and "10 actions are in" in out and "3 of them before" in out
    assert run("front", "cup.toml")[0] == 0


def test_a_crash_keeps_what_is_done(scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost_measurement, "measure_all", stand_in(3, RuntimeError))
    with pytest.raises(RuntimeError):
        run("measure", "cup.toml")
    assert len(json.loads(measurements_file(scenario).read_text())["actions"]) == 3


@pytest.mark.parametrize("changed", ["sources", "format", "geometry"])
def test_what_was_measured_otherwise_is_measured_anew(
    scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch, changed: str
) -> None:
    monkeypatch.setattr(cost_measurement, "measure_all", stand_in())
    run("measure", "cup.toml")
    if changed == "geometry":
        scenario.write_text(SCENARIO.replace("-0.25", "-0.26"))
    else:
        contents = json.loads(measurements_file(scenario).read_text())
        measurements_file(scenario).write_text(json.dumps(contents | {changed: 1}))
    # Planning still works after the skills have changed.
    assert run("front", "cup.toml")[0] == (0 if changed == "sources" else 2)
    status, out, _ = run("measure", "cup.toml")
    assert status == 0 and "before" not in out
    assert run("front", "cup.toml")[0] == 0


def test_an_action_that_never_works_out_is_told(scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def measure_all(scene: Any, wanted: Any, *, jobs: int) -> Iterator[Any]:
        first, *rest = stand_in()(scene, wanted, jobs=jobs)
        yield cost_measurement.Failure(first.pair, "`transit tray`: a wall")
        yield from rest

    monkeypatch.setattr(cost_measurement, "measure_all", measure_all)
    status, out, err = run("measure", "cup.toml", "--json")
    assert (status, err) == (4, "prefplan: not measured: `transit tray`: a wall\n")
    printed = json.loads(out)
    assert printed["complete"] is False and len(printed["actions"]) == PAIRS - 1
    assert printed["failed"] == [
        {"action": "transit", "from": "desk", "to": "tray", "reason": "`transit tray`: a wall"}
    ]
    status, out, _ = run("front", "cup.toml", "--abstract")
    assert status == 0 and "Not measured, and left out: transit from 'desk' to 'tray' (`transit tray`: a wall)." in out


def test_the_file_can_be_written_elsewhere(scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost_measurement, "measure_all", stand_in())
    assert run("measure", "cup.toml", "--out", "there/measured.json")[0] == 0
    assert Path("there/measured.json").exists() and not measurements_file(scenario).exists()


def test_a_folder_in_place_of_the_file_is_refused_before_anything_is_measured(
    scenario: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cost_measurement, "measure_all", lambda scene, wanted, jobs: pytest.fail("it is measured"))
    assert run("measure", "cup.toml", "--out", ".") == (2, "", "prefplan: .: is a folder; name a file\n")


def test_every_scenario_that_ships_with_measurements_is_carried_out_below() -> None:
    assert set(EXECUTED) == set(MEASURED)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "index"), EXECUTED.items())
def test_plans_still_take_what_was_measured(name: str, index: int) -> None:
    scenario = load(name)
    outcome = run_plan.run_plan(scenario, run_plan.scene_of(scenario), shipped_front(name)[index], seed=1)
    assert outcome.run.completed, outcome.run.reason
    assert [step.action for step in outcome.run.steps] == list(outcome.plan.actions)
    assert contacts(outcome.run.events) == [] and outcome.run.placement_error < 0.002
    measured = outcome_json(outcome)["measured"]
    assert measured["executed"] == pytest.approx(measured["predicted"], rel=0.05)


def test_energy_gives_the_arch_the_same_trade_off_as_numbers_do() -> None:
    front, numbers = shipped_front("case_study_3_energy"), shipped_front("case_study_3")
    assert [plan.actions for plan in front][0] == [plan.actions for plan in numbers][0]
    assert len(front) == len(numbers) == 2 and front[-1].preference == 0


def test_energy_tells_more_of_the_kitchens_trade_offs_apart() -> None:
    numbers = shipped_front("kitchen")
    points = [(plan.cost, plan.preference) for plan in numbers]
    assert points == [(58, 65), (61, 51), (64, 44), (65, 34), (68, 17), (78, 14), (81, 0)]
    assert numbers[0].task_costs == {"tidy": 10, "cleo": 24, "ben": 41, "ada": 58}
    assert numbers[-1].task_costs == {"ada": 34, "ben": 54, "cleo": 71, "tidy": 81}
    front = shipped_front("kitchen_energy")
    assert len(front) == 10
    assert (front[0].cost, front[-1].cost, front[-1].preference) == (519.591, 715.773, 0)
