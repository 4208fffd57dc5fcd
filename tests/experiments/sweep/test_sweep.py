"""`prefplan sweep`: processes that are killed and interrupted, on this machine and on a cluster, and nothing lost."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from scenario_texts import PLACES_NEARBY, cup_scenario

from experiments.commands.command_line import main
from experiments.sweep import workers
from experiments.sweep.job import Sweep, pack, roll_out
from experiments.sweep.workers import on_this_machine
from prefplan import load, pareto_front
from prefplan.models.manipulation.model import ManipulationModel
from sim.execution.faults import SPELLINGS, read_fault
from sim.world.randomization import read_perturbation

ROOT = Path(__file__).parents[3]
PROGRAM = [sys.executable, "-c", "import sys; from experiments.program import main; sys.exit(main())"]

CUP = cup_scenario(places=PLACES_NEARBY)

ROLLOUTS = 16
SWEEP = ["sweep", "cup.toml", "--rollouts", str(ROLLOUTS), "--jobs", "2", "--seed", "7"]

Records = dict[int, dict[str, Any]]


@pytest.fixture
def cup(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a small scenario in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cup.toml").write_text(CUP)
    return tmp_path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Records:
    """What a sweep finds that nobody disturbs."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "cup.toml").write_text(CUP)
    done = subprocess.run([*PROGRAM, *SWEEP], cwd=folder, env=environment(), capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return results(folder / "out" / "cup" / "sweep_cost")


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT)}


def results(folder: Path) -> Records:
    """Return the records in a folder by number, asserting that each is there once, without what a clock measured."""
    lines = (folder / "rollouts.jsonl").read_text().splitlines()
    records = [json.loads(line) for line in lines[1:]]
    assert len({record["rollout"] for record in records}) == len(records)
    timeless = [{k: v for k, v in record.items() if k not in ("cpu_seconds", "wall_seconds")} for record in records]
    return {record["rollout"]: record for record in timeless}


def begin(*more: str) -> subprocess.Popen[str]:
    """Start a sweep into the folder `out`."""
    command = [*PROGRAM, *SWEEP, "--out", "out", *more]
    return subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def await_records(count: int, process: subprocess.Popen[str], folder: Path = Path("out")) -> None:
    """Wait until so many rollouts are recorded."""
    file = folder / "rollouts.jsonl"
    while not file.exists() or file.read_bytes().count(b"\n") < 1 + count:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def without_folder(records: Records) -> Records:
    """Return records without the command that replays them: it names the folder of the sweep."""
    return {i: {k: v for k, v in record.items() if k != "replay"} for i, record in records.items()}


@pytest.mark.slow
def test_a_killed_sweep_goes_on_with_nothing_lost_and_nothing_twice(cup: Path, undisturbed: Records) -> None:
    sweep = begin()
    await_records(3, sweep)
    sweep.kill()
    sweep.wait()
    file = cup / "out" / "rollouts.jsonl"
    kept = file.read_bytes()
    kept = kept[: kept.rfind(b"\n") + 1]
    assert 3 <= kept.count(b"\n") - 1 < ROLLOUTS
    file.write_bytes(kept + b'{"rollout": 15, "seed"')  # as if it had been killed while writing
    again = begin("--json")
    printed, errors = again.communicate()
    assert (again.returncode, errors) == (0, "")
    assert file.read_bytes().startswith(kept)
    assert without_folder(results(cup / "out")) == without_folder(undisturbed)
    summary = json.loads(printed)
    assert summary["complete"] is True and summary["done"] == summary["completed"] == ROLLOUTS


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_finished_and_says_what_there_is(cup: Path, undisturbed: Records) -> None:
    sweep = subprocess.Popen(
        [*PROGRAM, *SWEEP, "--out", "out", "--json"],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    await_records(3, sweep)
    os.killpg(sweep.pid, signal.SIGINT)  # as a terminal does: to the workers as well
    printed, errors = sweep.communicate()
    assert (sweep.returncode, errors) == (130, "prefplan: interrupted; the same command goes on\n")
    summary, there = json.loads(printed), results(cup / "out")
    assert summary["complete"] is False and 3 <= summary["done"] == len(there) < ROLLOUTS
    assert json.loads((cup / "out" / "summary.json").read_text()) == summary
    assert without_folder(there).items() <= without_folder(undisturbed).items()


@pytest.fixture
def job(cup: Path) -> Sweep:
    scenario = load("cup.toml")
    plan = pareto_front(scenario.problem())[0]
    return Sweep(
        packed=pack(scenario),
        given="cup.toml",
        which="cost",
        plan=plan,
        seed=7,
        perturbation=read_perturbation("position=5,angle=5"),
        faults=False,
        folder=Path("out"),
    )


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_rollout_that_kills_its_process_twice_is_recorded_as_crashed(
    job: Sweep, cup: Path, jobs: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    once = cup / "killed_once"

    def deadly(sweep: Sweep, number: int) -> dict[str, Any]:
        if number == 3 or (number == 6 and not once.exists()):
            if number == 6:
                once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return {"rollout": number, "completed": True}

    monkeypatch.setattr(workers, "roll_out", deadly)
    records = list(on_this_machine(job, range(10), jobs=jobs))
    assert sorted(record["rollout"] for record in records) == list(range(10))
    assert once.exists()
    (crashed,) = (record for record in records if not record["completed"])
    assert (crashed["rollout"], crashed["class"]) == (3, "crashed")
    assert crashed["reason"] == "the process that carried it out ended without an answer, twice"


def test_a_rollout_is_a_function_of_the_sweep_and_its_number(job: Sweep) -> None:
    one, again, other = roll_out(job, 0), roll_out(job, 0), roll_out(job, 1)
    assert {k: v for k, v in one.items() if "_seconds" not in k} == {
        k: v for k, v in again.items() if "_seconds" not in k
    }
    measured = ("sim_seconds", "placement_error_mm", "speed_share", "torque_share")
    assert one["seed"] != other["seed"] and [one[key] for key in measured] != [other[key] for key in measured]
    assert one["certified"] is one["agrees"] is True and one["refuted"] == []
    assert one["cpu_seconds"] > 0 and one["wall_seconds"] > 0


def test_faults_are_drawn_by_seed_and_spelled_as_run_takes_them(job: Sweep) -> None:
    model = load("cup.toml").model
    assert isinstance(model, ManipulationModel)
    faulty = replace(job, faults=True)
    drawn = [faulty.rollout_faults(number, model) for number in range(200)]
    assert drawn == [faulty.rollout_faults(number, model) for number in range(200)]
    assert {len(faults) for faults in drawn} == {1, 2, 3}
    every = [fault for faults in drawn for fault in faults]
    assert {fault.kind for fault in every} == set(SPELLINGS)
    assert all(read_fault(str(fault), model) == fault for fault in every)
    assert {fault.action for fault in every} == {1, 2, 3, 4}
    assert job.rollout_faults(0, model) == ()


@pytest.mark.slow
def test_a_rollout_with_faults_can_be_replayed(job: Sweep, capsys: pytest.CaptureFixture[str]) -> None:
    faulty = replace(job, faults=True)
    for number in range(3):
        record = roll_out(faulty, number)
        assert record["agrees"] is True, record["refuted"]
        assert record["completed"] or record["reason"]
    _, *arguments = shlex.split(record["replay"])
    assert main([*arguments, "--no-video", "--json"]) == (0 if record["completed"] else 4)
    printed = json.loads(capsys.readouterr().out)
    assert [entry["fault"] for entry in printed["faults"]] == record["faults"]
    assert (printed["sim_seconds"], printed["replans"]) == (record["sim_seconds"], record["replans"])


def test_an_error_of_the_program_is_the_record_of_one_rollout(job: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: Any, **options: Any) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("experiments.sweep.job.carry_out", broken)
    record = roll_out(job, 5)
    assert (record["completed"], record["class"]) == (False, "error: ZeroDivisionError")
    assert record["reason"] == "ZeroDivisionError: division by zero"


@pytest.mark.slow
def test_a_rollout_can_be_replayed(cup: Path, undisturbed: Records, capsys: pytest.CaptureFixture[str]) -> None:
    record = undisturbed[4]
    program, *arguments = shlex.split(record["replay"])
    assert program == "prefplan"
    assert main([*arguments, "--no-video", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["sim_seconds"] == record["sim_seconds"]
    assert printed["max_placement_error_mm"] == record["placement_error_mm"]


@pytest.fixture
def call(cup: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Return a function that calls `prefplan sweep cup.toml`: exit status, output, errors."""

    def sweep(*arguments: str) -> tuple[int, str, str]:
        try:
            status = main(["sweep", "cup.toml", *arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return sweep


@pytest.mark.slow
def test_more_rollouts_add_to_those_there_are(call: Any, cup: Path) -> None:
    assert call("--rollouts", "1", "--jobs", "1")[0] == 0
    file = cup / "out" / "cup" / "sweep_cost" / "rollouts.jsonl"
    first = file.read_bytes()
    status, out, err = call("--rollouts", "3", "--jobs", "1")
    assert (status, err) == (0, "")
    assert "cup, plan cost: 3 of 3 rollouts" in out and "3 of 3 (100.0%)" in out
    assert file.read_bytes().startswith(first) and file.read_bytes().count(b"\n") == 4
    assert json.loads(call("--rollouts", "2", "--json")[1])["done"] == 2

    status, out, err = call("--seed", "1", "--perturb", "position=8")
    assert (status, out) == (2, "")
    assert "holds another experiment (perturb position=5,angle=5, not position=8, seed 0, not 1)" in err
    (cup / "cup.toml").write_text(CUP + "\n# changed\n")
    assert "holds another experiment (other scenario sha256)" in call()[2]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rollouts", "0"], "'0' is not a whole number >= 1"),
        (["--jobs", "many"], "'many' is not a whole number >= 1"),
        (["--perturb", "weight=1"], "--perturb: unknown perturbation 'weight' (valid: position, angle"),
        (["--plan", "4"], "--plan 4: the front has one plan, 0"),
        (["--out", "cup.toml"], "cup.toml: cannot be made"),
        (["--cluster", "nonsense"], "--cluster nonsense: no Dask scheduler answers"),
    ],
)
def test_bad_input_is_told_in_a_sentence(
    call: Any, arguments: list[str], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "CLUSTER_TIMEOUT_S", 1)
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    assert message in err and "Traceback" not in err


class Cluster:
    """A scheduler and two workers on loopback."""

    def __init__(self, folder: Path) -> None:
        self.file, self.log = folder / "scheduler.json", folder / "log"
        scheduler = self._start("scheduler", "--port", "0", "--no-dashboard", "--no-show", "--host", "127.0.0.1")
        while not self.file.exists() or not self.file.read_text():
            assert scheduler.poll() is None, self.log.read_text()
            time.sleep(0.05)
        self.address = json.loads(self.file.read_text())["address"]
        self.workers = [self._start("worker", "--nthreads", "1", "--no-nanny", "--no-dashboard") for _ in range(2)]
        self.processes = [*self.workers, scheduler]

    def _start(self, role: str, *options: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "dask", role, "--scheduler-file", str(self.file), *options]
        with self.log.open("a") as log:
            return subprocess.Popen(command, cwd=ROOT, env=environment(), stdout=log, stderr=log, text=True)

    def stop(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    pytest.importorskip("distributed")
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.stop()


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_finds_the_same(cup: Path, cluster: Cluster, undisturbed: Records) -> None:
    sweep = begin("--json", "--cluster", cluster.address)
    await_records(4, sweep)
    cluster.workers[0].send_signal(signal.SIGKILL)
    assert (cup / "out" / "rollouts.jsonl").read_bytes().count(b"\n") - 1 < ROLLOUTS, "the loss was in the middle"
    printed, errors = sweep.communicate()
    assert sweep.returncode == 0, errors
    assert cluster.workers[0].wait() == -signal.SIGKILL and cluster.workers[1].poll() is None
    assert json.loads(printed)["done"] == ROLLOUTS
    assert without_folder(results(cup / "out")) == without_folder(undisturbed)
