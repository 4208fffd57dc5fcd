"""Forged logs: none is proved, and what contradicts the claims is refuted with default options."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from forged_logs import claiming, telling
from hostile_bench import BENCH, logged_bench, write_bench
from scipy.spatial.transform import Rotation

from experiments.report import recordings
from experiments.runs import evidence
from prefplan.scenario.decode import Scenario
from sim.evidence.certificate import certify
from sim.evidence.log import Log, encode
from sim.evidence.replay import RecordedWorld
from sim.external.bundle import packed
from sim.simulation.recorder import STATE


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    return write_bench(tmp_path_factory.mktemp("verifier"))


def digest_of(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def elsewhere(log: Log, part: str = "mujoco", value: str = "3.0.0") -> Log:
    return telling(log, versions=log.about.versions | {part: value})


def test_the_honest_log_is_proved_and_elsewhere_consistent(bench_log: Log, scenario: Scenario) -> None:
    assert certify(bench_log, scenario=scenario).verdict == "proved"
    assert certify(bench_log).verdict == "consistent"
    rng = np.random.default_rng(0)
    noisy = replace(bench_log, qpos=bench_log.qpos + 1e-12 * rng.normal(size=bench_log.qpos.shape))
    for log in (elsewhere(noisy), elsewhere(noisy, "machine", "Plan9 mips")):
        certificate = certify(log, scenario=scenario)
        assert certificate.verdict == "consistent", certificate.refuted


def test_a_fault_that_was_asked_for_and_not_done_is_told_as_that(bench_log: Log, scenario: Scenario) -> None:
    certificate = certify(
        telling(bench_log, setting=bench_log.about.setting | {"faults": ["slip@99"]}), scenario=scenario
    )
    assert certificate.check("faults").words == "none; asked for, too, but not done: slip@99"
    assert "slip" not in certificate.check("scenario").words


def test_a_run_in_an_easier_scene_is_refuted_in_the_verifier_s(scenario: Scenario, tmp_path: Path) -> None:
    easy = BENCH.replace('mass="0.05"', 'mass="0.02"')
    log = logged_bench(tmp_path, scene=easy)
    assert certify(log).verdict == "consistent", "without the verifier's scenario it is told as not proved"
    assert not certify(log, scenario=scenario).check("scenario").holds
    forged = telling(log, files=packed(scenario.model))  # type: ignore[arg-type]
    assert not certify(forged, scenario=scenario).check("simulated again").holds


def crept(log: Log, obj: str, far: float) -> Log:
    """Return a log in which an object creeps evenly, for the whole run."""
    qpos, first = log.qpos.copy(), log.about.joints[obj]
    qpos[:, first] += far * np.linspace(0, 1, len(qpos))
    return replace(log, qpos=qpos)


def turned(log: Log, obj: str, degrees: float) -> Log:
    """Return a log in which an object turns evenly about the vertical, for the whole run."""
    qpos, first = log.qpos.copy(), log.about.joints[obj]
    turns = Rotation.from_euler("z", np.linspace(0, degrees, len(qpos))[:, None], degrees=True)
    rotations = Rotation.from_quat(qpos[:, first + 3 : first + 7], scalar_first=True)
    qpos[:, first + 3 : first + 7] = (turns * rotations).as_quat(scalar_first=True)
    return replace(log, qpos=qpos)


def test_a_bystander_that_turns_slowly_is_refuted_also_in_a_log_of_another_version(bench_log: Log) -> None:
    for log in (turned(bench_log, "can", 10), elsewhere(turned(bench_log, "can", 10))):
        assert not certify(log).check("simulated again").holds


def test_a_bystander_that_creeps_is_refuted_also_in_a_log_of_another_version(
    bench_log: Log, scenario: Scenario
) -> None:
    for log in (crept(bench_log, "can", 0.012), elsewhere(crept(bench_log, "can", 0.012))):
        words = certify(log).check("simulated again").words
        assert words.startswith("can is ") and certify(log, scenario=scenario).verdict == "refuted"


def test_a_completed_run_told_as_not_completed_is_refuted_unless_it_was_interrupted(bench_log: Log) -> None:
    log = claiming(bench_log, completed=False, preference=None)
    assert [check.name for check in certify(log).refuted] == ["not completed"]
    assert certify(telling(log, setting=log.about.setting | {"interrupted": True})).confirmed


def with_state(log: Log, change: Callable[[mujoco.MjModel, mujoco.MjData], None]) -> Log:
    """Return a log whose first step begins in a changed state."""
    world = RecordedWorld(log)
    data, rows = mujoco.MjData(world.mujoco), log.interventions.copy()
    mujoco.mj_setState(world.mujoco, data, rows[0, 1:], STATE)
    change(world.mujoco, data)
    mujoco.mj_getState(world.mujoco, data, rows[0, 1:], STATE)
    return replace(log, interventions=rows)


def pushed(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    data.body("can").xfrc_applied[0] = 1e-4


def carried(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    data.qfrc_applied[int(model.joint("joint2").dofadr[0])] = 1e-4


def late(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    data.time = 1e-3


@pytest.mark.parametrize("change", [pushed, carried, late])
def test_a_force_or_a_time_in_the_state_before_a_step_is_refuted(
    bench_log: Log, change: Callable[[mujoco.MjModel, mujoco.MjData], None]
) -> None:
    """The state holds more than positions: a force from outside would act in all later steps."""
    forged = with_state(bench_log, change)
    for log in (forged, elsewhere(forged)):
        assert not certify(log).check("simulated again").holds


def test_the_seed_the_robot_and_the_faults_are_part_of_what_is_proved(bench_log: Log, scenario: Scenario) -> None:
    words = certify(bench_log, scenario=scenario).check("scenario").words
    assert words == "the given one, with the robot panda, seed 3"


def test_a_certificate_names_its_log_and_a_page_vouches_for_what_holds_now(
    bench_log: Log, scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "plan_0"
    path.with_suffix(".npz").write_bytes(encode(bench_log))
    path.with_suffix(".json").write_text('{"made_from": "all of this"}')
    found = recordings._earlier(scenario, path, "all of this", None)
    assert found is not None and found.certificate["log_sha256"] == digest_of(path.with_suffix(".npz"))
    assert json.loads(path.with_suffix(".certificate.json").read_text()) == found.certificate
    assert recordings._earlier(scenario, path, "something else", None) is None
    path.with_suffix(".npz").write_bytes(encode(crept(bench_log, "can", 0.012)))
    assert recordings._earlier(scenario, path, "all of this", None) is None
    assert json.loads(path.with_suffix(".certificate.json").read_text())["verdict"] == "refuted"


def test_ctrl_c_keeps_the_log_the_json_and_a_certificate_that_are_marked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from experiments.commands.command_line import main
    from sim.evidence.log import read_log
    from sim.execution.executor import Execution

    write_bench(tmp_path)
    command = ["-q", "run", str(tmp_path / "bench.toml"), "--no-video", "--out"]

    def interrupt(*given: object, **options: object) -> None:
        raise KeyboardInterrupt

    def files(out: str) -> tuple[dict[str, object], dict[str, object], Path]:
        found = [json.loads((tmp_path / out / name).read_text()) for name in ("cost.json", "cost.certificate.json")]
        return found[0], found[1], tmp_path / out / "cost.npz"

    # While the log is checked: the run itself was completed.
    with monkeypatch.context() as patch:
        patch.setattr(evidence, "certify", interrupt)
        assert main([*command, str(tmp_path / "checked")]) == 130
    outcome, certificate, log = files("checked")
    assert outcome["complete"] is False and certificate["interrupted"] is True and certificate["verdict"] is None
    assert certificate["log_sha256"] == digest_of(log)
    # While the arm moves, in the third action.
    honest = Execution.step

    def third(self: Execution, *given: object, **options: object) -> object:
        return interrupt() if len(self.steps) == 2 else honest(self, *given, **options)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setattr(Execution, "step", third)
        assert main([*command, str(tmp_path / "moving")]) == 130
    outcome, certificate, log = files("moving")
    assert outcome["complete"] is False and certificate["interrupted"] is True
    assert certificate["verdict"] == "proved" and not certificate["claimed"]
    assert read_log(log).about.setting["interrupted"] is True
