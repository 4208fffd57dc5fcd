"""Checks of where objects start in a log, and that they are at rest at its end."""

from __future__ import annotations

import numpy as np

from prefplan.claims import Check
from prefplan.logic.good_prefix import Label
from prefplan.models.manipulation.symbolic import at
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.geometry.mjcf import joint_at
from sim.simulation.run import FRAME_RATE_HZ

START_TOLERANCE = 1e-5
"""Greatest difference of a first position from the one that the seed gives, m or rad."""

REST_SPEED_M_S = 0.01
"""Greatest mean speed of an object at the end of a run that is claimed to be completed."""

REST_PERIOD_FRAMES = round(0.2 * FRAME_RATE_HZ)
"""Number of frames over which that mean is taken."""


def check_start(log: Log, world: RecordedWorld, label: Label) -> Check:
    """Check that the first positions are those of the seed and that, by the `label`, every object is at its start."""
    off = np.abs(log.qpos[0] - world.start)
    if off.max() > START_TOLERANCE:
        joint, seed = joint_at(world.mujoco, int(off.argmax())), log.about.setting.get("seed")
        return Check("start", False, f"{joint} is {off.max():.4f} m or rad from where seed {seed} puts it")
    wrong = [obj for obj in world.model.objects if at(obj.name, obj.start) not in label]
    if wrong:
        return Check("start", False, f"{wrong[0].name} does not start at {wrong[0].start}")
    return Check("start", True, "every object is where the scenario says")


def check_rest(log: Log, world: RecordedWorld) -> Check:
    """Check that nothing on the table moves at the end, if the run is claimed to be completed."""
    name = "rest"
    if not log.about.claims.completed:
        return Check(name, True, "not claimed: the run was not completed")
    first = max(0, len(log.times) - 1 - REST_PERIOD_FRAMES)
    seconds = max(float(log.times[-1] - log.times[first]), 1 / FRAME_RATE_HZ)
    for obj in world.objects:
        path = world.path(obj)[first:]
        speed = float(np.linalg.norm(path[-1] - path[0])) / seconds
        if path[-1, 2] > 0 and speed > REST_SPEED_M_S:
            return Check(name, False, f"{obj} still moves, at {speed:.3f} m/s, when the log ends")
    return Check(name, True, f"nothing moved faster than {REST_SPEED_M_S} m/s in the last {seconds:.1f} s")
