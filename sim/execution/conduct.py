"""What keeps a run from being completed although every action succeeded, by the run's own record."""

from __future__ import annotations

from sim.simulation.run import Run

EXCUSED_S = 2.0
"""For this long after a fault has moved an object, it may touch anything."""


def objection(run: Run) -> str | None:
    """Return which joint limit the arm exceeded, or what it or its load touched that it should not, or None."""
    for load, shares in run.load_shares.items():
        if shares.max() > 1:
            joint = run.robot.joints[int(shares.argmax())]
            return f"{joint} exceeded a limit: {shares.max():.1%} of its {load.replace('_', ' ')}"
    faults = [event for event in run.events if event.kind == "fault"]
    for touch in (event for event in run.events if event.kind == "contact"):
        moved = {fault.detail.get("object") for fault in faults if 0 <= touch.time - fault.time <= EXCUSED_S}
        if moved.isdisjoint(touch.detail.values()):
            return f"{touch.detail['moving']} touched {touch.detail['other']} at {touch.time:.2f} s"
    return None
