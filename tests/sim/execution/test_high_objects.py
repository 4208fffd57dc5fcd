"""High objects under faults: what reaches between the fingers, slips unseen, or brushes them as it falls."""

from __future__ import annotations

import pytest
from forged_logs import log_of_run
from scenario_texts import task_tables

from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify
from sim.execution.faults import Fault

CAN = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
[model.locations]
desk = { at = [0.45, 0.15] }
side = { at = [0.55, -0.20] }
tray = { at = [0.50, 0.0] }
[model.objects]
can = { start = "desk", kind = "cylinder", size = [0.055, 0.10] }
box = { start = "side", kind = "box", size = [0.05, 0.04, 0.09] }
""" + task_tables(can="F can_tray")


@pytest.mark.parametrize(
    ("seed", "faults"),
    [
        # The hand is still round the can's top when it has risen by 5 cm from its middle.
        pytest.param(4245214700, [Fault("knock", 3, "can")], id="knocked over as the hand leaves it"),
        # Its top brushes a finger between two frames; nothing is seen until it lies.
        pytest.param(1596810411, [Fault("slip", 4), Fault("blind", 4, amount=1.8)], id="slips unseen"),
    ],
)
def test_a_high_can_is_put_down_in_the_end_and_the_log_is_honest(seed: int, faults: list[Fault]) -> None:
    log = log_of_run(loads(CAN), seed=seed, faults=faults)
    certificate = certify(log)
    assert sum(event.kind == "fault" for event in log.about.events) == len(faults)
    assert certificate.completed and certificate.refuted == ()
