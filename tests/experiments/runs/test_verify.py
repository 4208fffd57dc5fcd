"""`prefplan verify`: true logs confirmed, forged ones refuted, other files refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from scenario_texts import CUP

from experiments.commands.command_line import main
from sim.evidence.log import encode, read_log


@pytest.fixture(scope="module")
def cup(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a run, and nothing else of it."""
    folder = tmp_path_factory.mktemp("cup")
    (folder / "cup.toml").write_text(CUP)
    assert main(["run", str(folder / "cup.toml"), "--no-video", "--seed", "3", "--out", str(folder)]) == 0
    (folder / "cup.toml").unlink()
    (folder / "cost.json").unlink()
    return folder / "cost.npz"


@pytest.fixture
def forged(cup: Path, tmp_path: Path) -> Path:
    log = read_log(cup)
    claims = replace(log.about.claims, cost=9)
    path = tmp_path / "forged.npz"
    path.write_bytes(encode(replace(log, about=replace(log.about, claims=claims))))
    return path


def test_a_run_leaves_its_certificate(cup: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written = json.loads(cup.with_name("cost.certificate.json").read_text())
    assert main(["verify", str(cup), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
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
    cup: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sim.robots.panda.mesh_folder", lambda: None)
    log = read_log(cup)
    path = tmp_path / "mug.npz"  # under another name, so that the scene is built again
    path.write_bytes(encode(replace(log, about=replace(log.about, scenario="mug"))))
    assert main(["verify", str(path)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("mug: completed: confirmed\n")
    assert "ok  action 1 to 4: 4 actions, the frames agree with the log" in printed
    assert "ok  completed: tidy satisfied" in printed
    assert "with plain shapes of the arm" in printed


def test_a_forged_log_is_refuted(forged: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(forged)]) == 4
    printed = capsys.readouterr().out
    assert "cup: completed: refuted\n" in printed
    assert "NO  total cost: 9 is claimed, but it is 10\n" in printed
    assert main(["verify", str(forged), "--json"]) == 4
    printed = json.loads(capsys.readouterr().out)
    assert printed["confirmed"] is False and printed["completed"] is True


@pytest.mark.parametrize("name", ["none.npz", "cost.certificate.json", "."])
def test_what_is_no_log_is_refused(cup: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(cup.parent / name)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.startswith("prefplan: ") and captured.err.count("\n") == 1
