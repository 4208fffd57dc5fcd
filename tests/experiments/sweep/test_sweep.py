"""`prefplan sweep`: killed and interrupted processes lose no rollout."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from command_line import Run, assert_is_error
from jobs_for_processes import DEADLY, DEADLY_ONCE, Jobs
from scenario_texts import PLACES_NEARBY, cup_scenario

from experiments.cli.choice import Wanted
from experiments.commands.command_line import main
from experiments.sweep import workers
from experiments.sweep.faults import random_faults
from experiments.sweep.job import Sweep, pack
from experiments.sweep.workers import on_this_machine
from prefplan import load, pareto_front
from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.execution.faults.fault import kinds, read_fault
from sim.world.randomization import read_perturbation

ROOT = Path(__file__).parents[3]
PROGRAM = [sys.executable, "-c", "import sys; from experiments.program import main; sys.exit(main())"]

CUP = cup_scenario(places=PLACES_NEARBY)

ROLLOUTS = 3
SWEEP = ["sweep", "cup.toml", "--rollouts", str(ROLLOUTS), "--jobs", "1", "--seed", "7"]

Records = dict[int, dict[str, Any]]


@pytest.fixture
def cup(run: Run, tmp_path: Path) -> Path:
    """The current folder, with a small scenario in it."""
    (tmp_path / "cup.toml").write_text(CUP)
    return tmp_path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Records:
    """The results of an undisturbed sweep, rolled out in this process."""
    file = tmp_path_factory.mktemp("undisturbed") / "cup.toml"
    file.write_text(CUP)
    return {number: timeless(sweep_of(file).record(number)) for number in range(ROLLOUTS)}


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Roll out without processes, each of which takes seconds to load the simulation."""
    monkeypatch.setattr(
        workers, "on_this_machine", lambda sweep, numbers, **options: (sweep.record(k) for k in numbers)
    )


def sweep_of(file: Path) -> Sweep:
    """Return the sweep of the only plan of a scenario, into the folder `out`."""
    scenario = load(file)
    return Sweep(
        packed=pack(scenario),
        given="cup.toml",
        wanted=Wanted(),
        plan=pareto_front(scenario.problem())[0],
        seed=7,
        perturbation=read_perturbation("position=5,angle=5"),
        faults=None,
        folder=Path("out"),
    )


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT)}


def results(folder: Path) -> Records:
    """Return the records in a folder by number, asserting that each is there once."""
    lines = (folder / "rollouts.jsonl").read_text().splitlines()
    records = [json.loads(line) for line in lines[1:]]
    assert len({record["rollout"] for record in records}) == len(records)
    return {record["rollout"]: timeless(record) for record in records}


def timeless(record: dict[str, Any]) -> dict[str, Any]:
    """Return a record as in its file, without measured times."""
    written: dict[str, Any] = json.loads(json.dumps(record))
    return {key: value for key, value in written.items() if key not in ("cpu_seconds", "wall_seconds")}


def begin() -> subprocess.Popen[str]:
    """Start a sweep into the folder `out`, in a separate process session."""
    pipe = subprocess.PIPE
    command = [*PROGRAM, *SWEEP, "--out", "out", "--json"]
    return subprocess.Popen(command, env=environment(), stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def await_records(count: int, process: subprocess.Popen[str]) -> None:
    """Wait until this many rollouts are recorded."""
    file = Path("out", "rollouts.jsonl")
    while not file.exists() or file.read_bytes().count(b"\n") < 1 + count:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


@pytest.mark.slow
@pytest.mark.usefixtures("in_this_process")  # what goes on; what is interrupted is a program of its own
def test_an_interrupted_sweep_says_what_there_is_and_goes_on_with_nothing_lost_and_nothing_twice(
    cup: Path, undisturbed: Records, capsys: pytest.CaptureFixture[str]
) -> None:
    sweep = begin()
    await_records(1, sweep)  # long before the last one
    os.killpg(sweep.pid, signal.SIGINT)  # as a terminal does: to the workers as well
    printed, errors = sweep.communicate()
    assert (sweep.returncode, errors) == (130, "prefplan: interrupted; the same command continues it\n")
    summary, there = json.loads(printed), results(cup / "out")
    assert summary["complete"] is False and 1 <= summary["done"] == len(there) < ROLLOUTS
    assert json.loads((cup / "out" / "summary.json").read_text()) == summary
    assert there.items() <= undisturbed.items()

    file = cup / "out" / "rollouts.jsonl"
    kept = file.read_bytes()
    file.write_bytes(kept + b'{"rollout": 15, "seed"')  # as if it had been killed while writing
    assert main([*SWEEP, "--out", "out", "--json"]) == 0
    printed, errors = capsys.readouterr()
    assert errors == "" and file.read_bytes().startswith(kept)
    assert results(cup / "out") == undisturbed
    summary = json.loads(printed)
    assert summary["complete"] is True and summary["done"] == summary["completed"] == ROLLOUTS


@pytest.fixture
def job(cup: Path) -> Sweep:
    return sweep_of(cup / "cup.toml")


@pytest.mark.slow
def test_a_job_that_kills_its_process_twice_is_recorded_as_crashed(tmp_path: Path) -> None:
    once = tmp_path / "killed_once"
    records = list(on_this_machine(Jobs(once), [DEADLY, 5, DEADLY_ONCE], jobs=2))
    assert sorted(record["job"] for record in records) == [DEADLY, 5, DEADLY_ONCE] and once.exists()
    (crashed,) = (record for record in records if not record["completed"])
    assert crashed["job"] == DEADLY
    assert crashed["reason"] == "the process that carried it out ended without a result, twice"


def test_a_rollout_without_a_result_is_a_class_of_failures(job: Sweep) -> None:
    crashed = job.crashed(3, "it ended")
    assert (crashed["rollout"], crashed["class"], crashed["reason"]) == (3, "crashed", "it ended")
    assert crashed["replay"].startswith("prefplan run cup.toml") and not crashed["completed"]


def test_rollouts_differ_and_are_certified_and_timed(job: Sweep, undisturbed: Records) -> None:
    one, other = undisturbed[0], job.record(1)
    measured = ("sim_seconds", "placement_error_mm", "speed_share", "torque_share")
    assert one["seed"] != other["seed"] and [one[key] for key in measured] != [other[key] for key in measured]
    assert timeless(other) == undisturbed[1]
    assert one["certified"] is one["agrees"] is True and one["refuted"] == []
    assert other["cpu_seconds"] > 0 and other["wall_seconds"] > 0


def test_faults_are_drawn_by_seed_and_spelled_as_run_takes_them(job: Sweep) -> None:
    model = load("cup.toml").model
    assert isinstance(model, ManipulationModel)
    faulty = replace(job, faults="random")
    drawn = [faulty.rollout_faults(number, model) for number in range(200)]
    assert drawn == [faulty.rollout_faults(number, model) for number in range(200)]
    assert {len(faults) for faults in drawn} == {1, 2, 3}
    every = [fault for faults in drawn for fault in faults]
    assert {fault.kind for fault in every} == set(kinds())
    assert all(read_fault(str(fault), model) == fault for fault in every)
    assert {fault.action for fault in every} == {1, 2, 3, 4}
    assert job.rollout_faults(0, model) == ()
    slips = [replace(job, faults="slip").rollout_faults(number, model) for number in range(20)]
    assert {(len(faults), faults[0].kind) for faults in slips} == {(1, "slip")}


def test_only_faults_that_can_happen_in_a_scene_are_drawn(job: Sweep, arch_model: ManipulationModel) -> None:
    own = replace(arch_model, scene="lab.xml")
    drawn_kinds = {fault.kind for seed in range(100) for fault in random_faults(own, 4, seed=seed, kind="random")}
    assert drawn_kinds == set(kinds()) - {"foreign"}
    drawn = [random_faults(arch_model, 4, seed=seed, kind="foreign")[0] for seed in range(50)]
    assert {fault.argument for fault in drawn} == {place.name for place in arch_model.locations if not place.on}
    with pytest.raises(SimulationError, match="foreign: cannot happen: .* not in lab.xml"):
        random_faults(own, 4, seed=0, kind="foreign")
    fixed = replace(arch_model, objects=tuple(replace(obj, fixed=True) for obj in arch_model.objects))
    with pytest.raises(SimulationError, match="^move: cannot happen: every object is fixed$"):
        random_faults(fixed, 4, seed=0, kind="move")
    idle = replace(job, faults="random", plan=replace(job.plan, actions=()))
    assert idle.rollout_faults(0, arch_model) == ()


def test_a_sweep_with_faults_that_cannot_happen_is_refused(run: Run, cup: Path) -> None:
    (cup / "cup.toml").write_text(
        CUP.replace('start = "desk"', 'start = "desk", fixed = true').replace("F cup_tray", "F cup_desk")
    )
    result = run("sweep", "cup.toml", "--rollouts", "1", "--faults", "miss")
    assert_is_error(result, "prefplan: --faults miss: cannot happen: no object is ever grasped")


def test_an_error_of_the_program_is_the_record_of_one_rollout(job: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: Any, **options: Any) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("experiments.sweep.job.run_plan", broken)
    record = job.record(5)
    assert (record["completed"], record["class"]) == (False, "error: ZeroDivisionError")
    assert record["reason"] == "ZeroDivisionError: division by zero"


@pytest.fixture
def call(run: Run, cup: Path) -> Run:
    """Return a function that calls `prefplan sweep cup.toml`."""
    return partial(run, "sweep", "cup.toml")


@pytest.mark.usefixtures("in_this_process")
def test_more_rollouts_add_to_those_there_are(call: Run, cup: Path) -> None:
    assert call("--rollouts", "1")[0] == 0
    file = cup / "out" / "cup" / "sweep_cost" / "rollouts.jsonl"
    first = file.read_bytes()
    status, out, err = call("--rollouts", "2")
    assert (status, err) == (0, "")
    assert "cup, plan cost: 2 of 2 rollouts" in out and "2 of 2 (100.0%)" in out
    assert file.read_bytes().startswith(first) and file.read_bytes().count(b"\n") == 3
    assert json.loads(call("--rollouts", "1", "--json")[1])["done"] == 1

    status, out, err = call("--seed", "1", "--perturb", "position=8")
    assert (status, out) == (2, "")
    assert "holds another experiment (perturb 'position=5,angle=5', not 'position=8', seed 0, not 1)" in err
    (cup / "cup.toml").write_text(CUP + "\n# changed\n")
    assert "holds another experiment (scenario_sha256 " in call()[2]


@pytest.mark.usefixtures("in_this_process")
def test_a_sweep_of_another_scene_is_another_experiment(call: Run, cup: Path) -> None:
    lab = '<mujoco><worldbody><geom type="box" size="1 1 0.1" pos="0 0 -0.1"/></worldbody></mujoco>'
    (cup / "cup.toml").write_text(CUP.replace("[model]", '[model]\nscene = "lab.xml"'))
    (cup / "lab.xml").write_text(lab)
    assert call("--rollouts", "1")[0] == 0
    (cup / "lab.xml").write_text(lab.replace("1 1 0.1", "1 1.1 0.1"))
    assert "holds another experiment (files {'lab.xml': " in call("--rollouts", "2")[2]


@pytest.mark.usefixtures("in_this_process")
def test_the_command_of_a_record_repeats_its_rollout(run: Run, call: Run, cup: Path) -> None:
    assert call("--rollouts", "2", "--faults", "random")[0] == 0
    record = results(cup / "out" / "cup" / "sweep_cost")[1]
    assert record["replay"].endswith("--out out/cup/sweep_cost/rollout_1")
    printed = run(*shlex.split(record["replay"])[1:], "--no-video", "--json").json
    assert [entry["fault"] for entry in printed["faults"]] == record["faults"] != []
    assert (printed["sim_seconds"], printed["replans"]) == (record["sim_seconds"], record["replans"])
    assert printed["max_placement_error_mm"] == record["placement_error_mm"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rollouts", "0"], "'--rollouts': 0 is not in the range x>=1"),
        (["--faults", "slp"], "--faults: unknown name 'slp' (did you mean 'slip'?)"),
        (["--perturb", "weight=1"], "--perturb: unknown perturbation 'weight' (valid: position, angle"),
    ],
)
def test_bad_input_is_told_in_a_sentence(call: Run, arguments: list[str], message: str) -> None:
    assert_is_error(call(*arguments), message)
