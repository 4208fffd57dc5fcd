"""Faulty devices: each wraps a sensor, the gripper or a skill, which know nothing of faults."""

from __future__ import annotations

import mujoco
import numpy as np

from prefplan.models.manipulation.action import Action
from sim.perception.sensors import ObjectPose, Sensor
from sim.simulation.gripper import Gripper
from sim.simulation.workcell import Workcell
from sim.skills.grasp import GraspSkill
from sim.skills.skill import Skill
from sim.world.scene import Scene
from sim.world.shapes import Grip

MISS_GAP_M = 0.005
"""Height over an object at which the fingers close when they miss it."""


class DropoutSensor:
    """A sensor that observes nothing for a while.

    Attributes:
        samples: as of the sensor it wraps.
    """

    def __init__(self, sensor: Sensor, *, until: float) -> None:
        """Wrap a sensor; it observes again from a simulated time on, s."""
        self.samples = sensor.samples
        self._sensor, self._until = sensor, until

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """Return the observed pose of an object, or None if it is not observed."""
        return None if data.time < self._until else self._sensor.observe(scene, data, obj)


class SlippingGripper(Gripper):
    """A gripper that opens a little for a while; meanwhile only wider commands take effect."""

    def __init__(self, gripper: Gripper, data: mujoco.MjData, *, least_width: float, until: float) -> None:
        """Wrap a gripper.

        Args:
            gripper: the one that is commanded.
            data: the running state.
            least_width: between the pads meanwhile, m.
            until: the simulated time at which it ends, s.
        """
        self._gripper, self._data = gripper, data
        self._least_width, self._until = least_width, until
        self.width = gripper.width

    @property
    def width(self) -> float:
        """As of the gripper it wraps, as it is commanded."""
        return self._commanded

    @width.setter
    def width(self, width: float) -> None:
        self._commanded = width
        self.update()

    def update(self) -> None:
        """Command the gripper for the present time; to be called in every control period."""
        slipping = self._data.time < self._until
        self._gripper.width = max(self._commanded, self._least_width) if slipping else self._commanded


class MissingGrasp(GraspSkill):
    """A grasp whose fingers close above the object the first few times."""

    def __init__(self, skill: Skill, *, misses: int) -> None:
        """Wrap a skill, which is performed after so many misses."""
        self._skill, self._misses = skill, misses

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        if self._misses:
            super().perform(cell, action)
        else:
            self._skill.perform(cell, action)

    def closing_position(self, cell: Workcell, obj: str, pose: ObjectPose, grip: Grip) -> np.ndarray:
        """Return the (3,) position of the tool, m, at which the fingers close on nothing."""
        self._misses -= 1
        above = cell.scene.shapes[obj].height + MISS_GAP_M
        return super().closing_position(cell, obj, pose, grip) + [0.0, 0.0, above]
