"""A logged run simulated again: its commands from its first state, state by state beside the recorded ones."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from prefplan.claims import Check
from sim.errors import LogError
from sim.evidence.log import DECIMALS, Log, versions
from sim.evidence.replay import RecordedWorld
from sim.simulation.recorder import COMMANDS_PER_UNIT, STATE, Recorder, model_hash

COMPARED = ("qpos", "qvel", "speeds", "torques", "pad_forces")
"""Arrays that are simulated again."""

FRAME_TOLERANCE_M = 0.001
"""Greatest distance of a recorded position from the one simulated from the frame before it, with other versions, m or
rad."""

PHYSICS = ("mujoco", "machine")
"""What decides whether two simulations agree in every digit."""


def resimulate(log: Log, world: RecordedWorld) -> Check:
    """Check a log against a simulation of its commands.

    With the log's version of MuJoCo on its kind of machine, the run is simulated from its first state, and every
    recorded digit must come out again. Otherwise two simulations drift apart: each frame is then simulated from the one
    before it, and its positions must agree within `FRAME_TOLERANCE_M`.

    Raises:
        LogError: the log's arrays do not fit the scene of its scenario.
    """
    name, model = "simulated again", world.simulated
    _check_shapes(log, world)
    here = versions()
    same = all(log.about.versions.get(part) == here[part] for part in PHYSICS)
    same = same and log.about.model_sha256 == model_hash(model)
    if not same:
        return _by_frames(log, world)
    told = len(log.times)
    found = _run(log, world)
    for frame, recorded in enumerate(found):
        for array in COMPARED:
            off = np.abs(recorded[array].round(DECIMALS) - getattr(log, array)[frame])
            if off.max(initial=0) > 0.5 * 10**-DECIMALS:
                return Check(name, False, _difference(log, world, frame, array, off))
    return Check(name, True, f"{told} frames, equal in every digit")
