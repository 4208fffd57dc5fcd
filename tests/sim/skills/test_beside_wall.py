"""Objects that were knocked over beside a wall that is higher than the hand: they are taken without touching it."""

from __future__ import annotations

import pytest
from forged_logs import run_and_log
from scenario_texts import cup_scenario

from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify
from sim.execution.faults.knock import Knock

TIN = 'kind = "cylinder", size = [0.04, 0.1]'


@pytest.mark.parametrize(
    ("kind", "wall", "tray", "seed", "events"),
    [
        pytest.param(
            TIN,
            "at = [0.45, -0.23, 0.1], size = [0.3, 0.02, 0.2]",
            "[0.42, 0.22]",
            167,
            ["grasped", "placed"],
            id="leans on it",
        ),
        pytest.param(
            TIN,
            "at = [0.45, -0.07, 0.1], size = [0.3, 0.02, 0.2]",
            "[0.42, -0.38]",
            109,
            ["drawn free", "grasped", "placed"],
            id="rolled away by a tilted hand",
        ),
        pytest.param(
            'kind = "cylinder", size = [0.055, 0.08]',
            "at = [0.45, -0.1925, 0.1], size = [0.3, 0.02, 0.2]",
            "[0.42, 0.22]",
            100,
            ["drawn free", "grasped", "placed"],
            id="the hand comes turned",
        ),
    ],
)
def test_what_was_knocked_over_beside_a_wall_is_taken(
    kind: str, wall: str, tray: str, seed: int, events: list[str]
) -> None:
    text = cup_scenario(places={"desk": "{ at = [0.45, -0.15] }", "tray": f"{{ at = {tray} }}"})
    text = text.replace('start = "desk"', f'start = "desk", {kind}')
    text = text.replace("[model.locations]", f'[model.fixtures]\nwall = {{ kind = "box", {wall} }}\n[model.locations]')
    run, log = run_and_log(loads(text), seed=seed, faults=[Knock(1, "cup")])
    told = [event.kind for event in run.events]
    assert [kind for kind in told if kind in {"drawn free", "grasped", "placed", "contact", "ended"}] == events
    assert certify(log).refuted == ()
