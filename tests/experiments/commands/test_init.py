"""`prefplan init`: the scenarios to start from can be planned as they are."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from command_line import Run

from experiments.commands.command_line import main
from experiments.starters import KINDS, starter


@pytest.mark.parametrize("kind", KINDS)
def test_a_starter_is_sound_has_a_trade_off_and_shows_calls(run: Run, kind: str) -> None:
    assert run("init", "mine", "--kind", kind).status == 0
    shown = re.findall(r"^#   prefplan (\S.*?)(?:   .*)?$", starter(kind, file="mine.toml"), re.MULTILINE)
    check, front, plan_or_run = map(shlex.split, shown)
    checked = run(*check, "--json")
    assert (checked.status, checked.err) == (0, "")
    assert (checked.json["kind"], checked.json["warnings"]) == (kind, [])
    assert checked.json["scene"] is (True if kind == "manipulation" else None)
    found = run(*front, "--json")
    assert (found.status, found.json["complete"]) == (0, True)
    assert len(found.json["front"]) >= 2
    assert kind == "manipulation" or run(*plan_or_run).status == 0  # the run is carried out below


def other_preferences(kind: str) -> list[str]:
    """Return the preferences that a starter's comments offer."""
    lines = re.findall(r'^#   (kind = "\S+")\s+(\S.*)$', starter(kind, file="mine.toml"), re.MULTILINE)
    return [f"{kind}\n{rest}" for kind, rest in lines]


@pytest.mark.parametrize("kind", KINDS)
def test_every_preference_that_the_comments_offer_can_be_had(run: Run, tmp_path: Path, kind: str) -> None:
    offered = other_preferences(kind)
    assert len(offered) == 5
    run("init", "mine", "--kind", kind)
    text = (tmp_path / "mine.toml").read_text()
    without_prices = re.sub(r"^(relax|skip) = .*\n", "", text, flags=re.MULTILINE)
    for preference in offered:
        start, _, _ = without_prices.partition("[preference]")
        (tmp_path / "other.toml").write_text(f"{start}[preference]\n{preference}\n")
        assert run("check", "other.toml", "--quick").status == 0, preference


@pytest.mark.parametrize("kind", ["grid", "manipulation"])
def test_the_prices_that_the_comments_offer_can_be_had(run: Run, tmp_path: Path, kind: str) -> None:
    text = re.sub(r"^# (relax|skip) = ", r"\1 = ", starter(kind, file="mine.toml"), flags=re.MULTILINE)
    start, _, _ = text.partition("[preference]")
    (tmp_path / "mine.toml").write_text(f'{start}[preference]\nkind = "max"\nover = "violation"\n')
    found = run("check", "mine.toml", "--json", "--quick")
    assert found.status == 0
    assert sorted(task["relaxations"] for task in found.json["tasks"])[-1] == 1
    assert any(task["skip"] for task in found.json["tasks"])


@pytest.mark.parametrize("kind", KINDS)
def test_the_tables_that_the_comments_offer_can_be_had(run: Run, tmp_path: Path, kind: str) -> None:
    offered = r"^# (?=\[|mud = |wall = |name = |formula = )"
    (tmp_path / "mine.toml").write_text(re.sub(offered, "", starter(kind, file="mine.toml"), flags=re.MULTILINE))
    found = run("check", "mine.toml", "--json", "--quick")
    assert (found.status, found.err) == (0, "")


def test_the_file_is_named_as_said(run: Run, tmp_path: Path) -> None:
    for name in ("here", "below/there.toml", str(tmp_path / "far" / "v1.5")):
        result = run("init", name)
        assert (result.status, result.err) == (0, "")
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.toml")) == [
        "below/there.toml",
        "far/v1.5.toml",
        "here.toml",
    ]
    assert (tmp_path / "below/there.toml").read_text().startswith("# there.toml: ")


def test_a_file_is_never_overwritten(run: Run, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("precious")
    result = run("init", "mine")
    assert (result.status, result.out) == (2, "")
    assert result.err.startswith("prefplan: mine.toml: ") and len(result.err.splitlines()) == 1
    assert (tmp_path / "mine.toml").read_text() == "precious"


@pytest.mark.slow
def test_the_arm_carries_its_starter_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["init", "mine", "--kind", "manipulation"]) == 0
    assert main(["run", "mine.toml", "--no-video"]) == 0
