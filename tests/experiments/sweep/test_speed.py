"""Where the time of a run goes."""

from __future__ import annotations

import mujoco
import pytest
from scenario_texts import PAST_A_TOWER

from experiments.sweep import speed
from prefplan.scenario.decode import loads


def test_the_parts_of_a_run_add_up_and_nothing_stays_timed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(speed, "load", lambda name: loads(PAST_A_TOWER, name=name))
    before = mujoco.mj_step
    assert speed.main(["--repeats", "1", "--scenario", "kitchen"]) == 0
    assert mujoco.mj_step is before
    lines = capsys.readouterr().out.splitlines()
    rows = dict(line.strip("| ").split(" | ") for line in lines[2:])
    shares = {part: float(rows[part].rstrip("%")) for part in (*speed.PARTS, speed.REST)}
    assert sum(shares.values()) == pytest.approx(100, abs=0.5)
    assert all(share > 0 for part, share in shares.items() if "search" not in part)
    planning = sum(share for part, share in shares.items() if part.startswith("planning"))
    assert float(rows["planning in all"].rstrip("%")) == pytest.approx(planning, abs=0.3)
    assert float(rows["run over bare steps"]) > 1
