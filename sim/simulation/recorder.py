"""What is recorded of a running simulation: positions frame by frame, and the greatest loads between two frames."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from sim.simulation.rollout import FRAME_RATE
from sim.world.scene import Scene


class Recorder:
    """Frames of a simulation, `FRAME_RATE` a second; loads are sampled at every step between them."""

    def __init__(self, scene: Scene) -> None:
        """Begin without a frame."""
        model = scene.mujoco
        self._dofs = scene.robot.dofs(model)
        self._pads = {model.geom(name).id: i for i, name in enumerate(scene.robot.gripper.pads)}
        self._frames: list[dict[str, Any]] = []
        self._speed, self._torque = np.zeros((2, len(self._dofs)))

    def is_due(self, data: mujoco.MjData) -> bool:
        """Return whether the time has come for another frame."""
        return bool(data.time * FRAME_RATE >= len(self._frames) - 1e-6)

    def feel(self, data: mujoco.MjData) -> None:
        """Update the greatest speeds and torques with a state just simulated."""
        np.maximum(self._speed, np.abs(data.qvel[self._dofs]), out=self._speed)
        np.maximum(self._torque, np.abs(data.qfrc_actuator[self._dofs]), out=self._torque)

    def record(self, data: mujoco.MjData, *, glow: int) -> None:
        """Add a frame; `glow` is the index of the marking location at work, -1 for none."""
        frame = {
            "times": float(data.time),
            "qpos": data.qpos.copy(),
            "glow": glow,
            "speeds": self._speed,
            "torques": self._torque,
            "pad_forces": self._press(data),
        }
        self._frames.append(frame)
        self._speed, self._torque = np.zeros((2, len(self._dofs)))

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """What was recorded, by the names it has in a `Frames`; loads since the last frame are added to it."""
        arrays = {name: np.array([frame[name] for frame in self._frames]) for name in self._frames[0]}
        for name, load in (("speeds", self._speed), ("torques", self._torque)):
            arrays[name][-1] = np.maximum(arrays[name][-1], load)
        return arrays

    def _press(self, data: mujoco.MjData) -> np.ndarray:
        """Return the (2,) contact forces on the left and the right pad, N."""
        forces = np.zeros(2)
        for i, pair in enumerate(data.contact.geom.tolist()):
            for geom in pair:
                if geom in self._pads:
                    # The first row of an elliptic cone is the normal force.
                    forces[self._pads[geom]] += data.efc_force[data.contact.efc_address[i]]
        return forces
