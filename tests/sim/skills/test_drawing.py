"""An object between two walls higher than it is drawn free before it is taken, and the certificate agrees."""

from __future__ import annotations

from forged_logs import log_of_run
from scenario_texts import CORNER

from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify

LOW = (
    CORNER.replace('cup = { start = "desk" }', 'cup = { start = "desk", kind = "box", size = [0.05, 0.05, 0.03] }')
    .replace("at = [0.485,", "at = [0.4875,")
    .replace("-0.185,", "-0.1875,")
)
"""The walls are 2 cm higher than the cup, and 2.5 mm from it."""


def test_a_low_object_in_a_corner_is_drawn_free_and_taken() -> None:
    log = log_of_run(loads(LOW), seed=0)
    assert log.about.claims.completed
    drawn = [event.detail for event in log.about.events if event.kind == "drawn free"]
    assert [detail["object"] for detail in drawn] == ["cup"]
    assert 15 < drawn[0]["distance_mm"] < 60
    assert certify(log).refuted == ()
