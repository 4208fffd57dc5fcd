"""`prefplan verify`: true logs confirmed, forged ones refuted, other files refused."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import Run, assert_is_error
from forged_logs import telling
from scenario_texts import CUP, PLACES_NEARBY, cup_scenario

from experiments.runs import evidence
from experiments.runs.certificates import Proof, certificate_json
from sim.evidence.certificate import certify
from sim.evidence.log import encode, read_log


@pytest.fixture
def forged(run_log: Path, tmp_path: Path) -> Path:
    log = read_log(run_log)
    claims = replace(log.about.claims, cost=9)
    path = tmp_path / "forged.npz"
    path.write_bytes(encode(replace(log, about=replace(log.about, claims=claims))))
    return path


def test_a_run_leaves_its_certificate(run_log: Path, tmp_path: Path, run: Run) -> None:
    written = json.loads(run_log.with_name("cost.certificate.json").read_text())
    (tmp_path / "cup.toml").write_text(CUP)
    result = run("verify", str(run_log), "--scenario", str(tmp_path / "cup.toml"), "--json")
    assert result.status == 0
    printed = result.json
    assert printed == written
    assert list(printed) == [
        "verdict",
        "confirmed",
        "agrees",
        "interrupted",
        "log_sha256",
        "scenario",
        "robot",
        "versions",
        "setting",
        "claimed",
        "completed",
        "task_costs",
        "preference",
        "checks",
    ]
    assert printed["verdict"] == "proved" and printed["completed"] and not printed["interrupted"]
    assert printed["log_sha256"] == hashlib.sha256(run_log.read_bytes()).hexdigest()
    assert printed["confirmed"] and printed["task_costs"] == {"tidy": 10}
    assert printed["setting"] == {"seed": 3, "perturbation": "position=5,angle=5"}
    assert all(check["holds"] for check in printed["checks"])


def test_what_is_claimed_is_told_apart_from_what_is_found(run_log: Path) -> None:
    log = read_log(run_log)
    found = certify(log)
    for claimed, completed in ((True, False), (False, True)):
        told = telling(log, claims=replace(log.about.claims, completed=claimed))
        printed = certificate_json(Proof(run_log, told, replace(found, completed=completed)))
        assert (printed["claimed"], printed["completed"]) == (claimed, completed)


def test_people_see_every_check_also_in_a_log_of_another_version(run_log: Path, tmp_path: Path, run: Run) -> None:
    log, path = read_log(run_log), tmp_path / "mug.npz"
    path.write_bytes(encode(telling(log, versions=log.about.versions | {"mujoco": "3.0.0"})))
    status, printed, _ = run("verify", str(path))
    assert status == 5
    assert printed.startswith("cup: completed: consistent\n") and "(mujoco 3.0.0 then, " in printed
    assert "ok  action 1 to 4: 4 actions, the frames agree with the log" in printed
    assert "ok  completed: tidy satisfied" in printed
    assert "ok  contacts: only with the grasped object; " in printed


def test_a_forged_log_is_refuted(forged: Path, run: Run) -> None:
    status, printed, _ = run("verify", str(forged))
    assert status == 4
    assert "cup: completed: refuted\n" in printed
    assert "NO  total cost: 9 is claimed, but it is 10\n" in printed
    result = run("verify", str(forged), "--json")
    assert result.status == 4
    printed = result.json
    assert printed["confirmed"] is False and printed["completed"] is True


def test_a_run_that_its_log_refutes_was_not_carried_out(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = evidence.claims_of
    monkeypatch.setattr(evidence, "claims_of", lambda outcome: replace(honest(outcome), cost=9))
    (tmp_path / "cup.toml").write_text(cup_scenario(places=PLACES_NEARBY))
    result = run("run", "cup.toml", "--no-video")
    assert result.status == 4 and "cup: wrongly called completed after 4 of 4 actions" in result.out
    told = json.loads(Path("out/cup/cost.json").read_text())
    assert told["completed"] is told["certified"] is False
    assert told["reason"] == "the log refutes it: total cost: 9 is claimed, but it is 10"


def test_a_log_is_proved_in_the_verifier_s_scenario(run_log: Path, tmp_path: Path, run: Run) -> None:
    (tmp_path / "same.toml").write_text(f"# with a comment\n{CUP}")
    result = run("verify", str(run_log), "--scenario", str(tmp_path / "same.toml"))
    assert result.status == 0 and result.out.startswith("same: completed: proved\n")
    assert "ok  scenario: the given one, with the robot panda, perturbation position=5,angle=5, seed 3\n" in result.out
    assert "frames, every digit equal\n" in result.out


@pytest.mark.parametrize(
    ("scenario", "require", "status"),
    [(True, "proved", 0), (True, "consistent", 0), (False, None, 5), (False, "consistent", 0), (False, "proved", 4)],
)
def test_scripts_say_what_they_require(
    scenario: bool, require: str | None, status: int, run_log: Path, tmp_path: Path, run: Run
) -> None:
    (tmp_path / "cup.toml").write_text(CUP)
    options = ["--scenario", str(tmp_path / "cup.toml")] if scenario else []
    result = run("verify", str(run_log), *options, *(["--require", require] if require else []))
    assert result.status == status
    assert ("not proved: that the log is of your scenario" in result.out) != scenario


def test_another_scenario_refutes(run_log: Path, tmp_path: Path, run: Run) -> None:
    (tmp_path / "dearer.toml").write_text(CUP.replace("transit = 3", "transit = 4"))
    result = run("verify", str(run_log), "--scenario", str(tmp_path / "dearer.toml"))
    words = "model.costs.transit is 3 in the log, 4 in the given one"
    assert result.status == 4 and f"NO  scenario: the log is of another one: {words}\n" in result.out


@pytest.mark.parametrize("name", ["none.npz", "cost.certificate.json", "."])
def test_what_is_no_log_is_refused(run_log: Path, name: str, run: Run) -> None:
    result = run("verify", str(run_log.parent / name))
    assert_is_error(result, "prefplan: ")
    assert result.err.count("\n") == 1
