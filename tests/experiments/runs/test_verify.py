"""`prefplan verify`: true logs confirmed, forged ones refuted, other files refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import Run, assert_is_error
from scenario_texts import CUP, PLACES_NEARBY, cup_scenario

from experiments.runs import evidence
from sim.evidence.log import encode, read_log


@pytest.fixture
def forged(signed_log: Path, tmp_path: Path) -> Path:
    log = read_log(signed_log)
    claims = replace(log.about.claims, cost=9)
    path = tmp_path / "forged.npz"
    path.write_bytes(encode(replace(log, about=replace(log.about, claims=claims))))
    return path


def test_a_run_leaves_its_certificate(signed_log: Path, run: Run) -> None:
    written = json.loads(signed_log.with_name("cost.certificate.json").read_text())
    result = run("verify", str(signed_log), "--json")
    assert result.status == 0
    printed = result.json
    assert printed == written
    assert list(printed) == [
        "confirmed",
        "agrees",
        "scenario",
        "levels",
        "proves",
        "versions",
        "setting",
        "claimed",
        "completed",
        "task_costs",
        "preference",
        "checks",
    ]
    assert printed["confirmed"] and printed["completed"] and printed["task_costs"] == {"tidy": 10}
    assert printed["setting"] == {"seed": 3, "perturbation": "position=5,angle=5"}
    assert all(check["holds"] for check in printed["checks"])


def test_people_see_every_check_also_without_the_meshes(
    signed_log: Path, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sim.robots.arms.panda.mesh_folder", lambda: None)
    log = read_log(signed_log)
    path = tmp_path / "mug.npz"  # under another name, so that the scene is built again
    path.write_bytes(encode(replace(log, about=replace(log.about, scenario="mug"))))
    status, printed, _ = run("verify", str(path))
    assert status == 0
    assert printed.startswith("mug: completed: confirmed\n")
    assert "ok  action 1 to 4: 4 actions, the frames agree with the log" in printed
    assert "ok  completed: tidy satisfied" in printed
    assert "with plain shapes of the arm" in printed


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


def test_a_log_is_checked_at_every_level(signed_log: Path, keys: Path, tmp_path: Path, run: Run) -> None:
    (tmp_path / "same.toml").write_text(f"# with a comment\n{CUP}")
    levels = ["--scenario", str(tmp_path / "same.toml"), "--resimulate", "--key", str(keys / "pem.pub")]
    result = run("verify", str(signed_log), *levels, "--json")
    assert result.status == 0
    printed = result.json
    assert printed["levels"] == ["plain", "scenario", "resimulate", "key"] and len(printed["proves"]) == 4
    names = [check["name"] for check in printed["checks"]]
    assert {"signature", "scenario", "simulated again"} < set(names)
    contents = signed_log.read_bytes()
    assert b"PRIVATE" not in contents and (keys / "pem").read_bytes()[30:60] not in contents


def test_another_scenario_and_another_key_refute(signed_log: Path, keys: Path, tmp_path: Path, run: Run) -> None:
    (tmp_path / "dearer.toml").write_text(CUP.replace("transit = 3", "transit = 4"))
    result = run("verify", str(signed_log), "--scenario", str(tmp_path / "dearer.toml"))
    words = "model.costs.transit is 3 in the log, 4 in the given one"
    assert result.status == 4 and f"NO  scenario: the log is of another one: {words}\n" in result.out
    result = run("verify", str(signed_log), "--key", str(keys / "ssh.pub"))
    assert result.status == 4 and "NO  signature: the file is not what the owner of the key signed\n" in result.out


@pytest.mark.parametrize("name", ["none", "pem"])
def test_what_is_no_public_key_is_refused(signed_log: Path, keys: Path, name: str, run: Run) -> None:
    result = run("verify", str(signed_log), "--key", str(keys / name))
    assert (result.status, result.out) == (2, "") and result.err.startswith(f"prefplan: {keys / name}: ")


@pytest.mark.parametrize("name", ["none.npz", "cost.certificate.json", "."])
def test_what_is_no_log_is_refused(signed_log: Path, name: str, run: Run) -> None:
    result = run("verify", str(signed_log.parent / name))
    assert_is_error(result, "prefplan: ")
    assert result.err.count("\n") == 1
