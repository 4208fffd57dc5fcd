"""An object in a corner between two walls is drawn free before it is taken, and the certificate agrees."""

from __future__ import annotations

from forged_logs import log_of_run
from scenario_texts import CORNER

from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify


def test_an_object_in_a_corner_is_drawn_free_and_taken() -> None:
    log = log_of_run(loads(CORNER), seed=0)
    assert log.about.claims.completed
    drawn = [event.detail for event in log.about.events if event.kind == "drawn free"]
    assert [detail["object"] for detail in drawn] == ["cup"]
    assert 15 < drawn[0]["distance_mm"] < 60
    assert certify(log).refuted == ()
