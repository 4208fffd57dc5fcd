"""Faulty devices: each wraps a sensor, the gripper or a skill, which does not know of faults."""

from __future__ import annotations

from collections.abc import Callable

import mujoco

from prefplan.models.manipulation.action import Action
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import ObjectPose, Sensor
from sim.simulation.workcell import Workcell
from sim.skills.grasp import GraspSkill
from sim.skills.skill import Skill
from sim.world.scene import Scene

MISS_GAP_M = 0.005
"""Height above an object at which the fingers close when they miss it."""


class DropoutSensor:
    """A sensor that observes nothing for a while.

    Attributes:
        samples, error: those of the wrapped sensor.
    """

    def __init__(self, sensor: Sensor, *, until: float) -> None:
        """Wrap a sensor; it observes again from the simulated time `until` on, s."""
        self.samples, self.error = sensor.samples, sensor.error
        self._sensor, self._until = sensor, until

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """Return the observed pose of an object, or None if it is not observed."""
        return None if data.time < self._until else self._sensor.observe(scene, data, obj)


def slipping(
    gripper: Callable[[float], float], data: mujoco.MjData, *, least_width: float, until: float
) -> Callable[[float], float]:
    """Return a gripper that stays open by at least `least_width`, m, until a simulated time, s."""
    return lambda width: gripper(max(width, least_width) if data.time < until else width)


class MissingGrasp(GraspSkill):
    """A grasp skill whose fingers close above the object the first few times."""

    def __init__(self, skill: Skill, *, misses: int) -> None:
        """Wrap a skill, which is performed after this number of misses."""
        self._skill, self._misses = skill, misses

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        if self._misses:
            super().perform(cell, action)
        else:
            self._skill.perform(cell, action)

    def closing_pose(self, cell: Workcell, obj: str, target: ToolPose) -> ToolPose:
        """Return the pose of the tool at which the fingers close: above the object, or after all misses on it."""
        if not self._misses:
            return super().closing_pose(cell, obj, target)
        self._misses -= 1
        pose = cell.observe(obj)
        return super().closing_pose(cell, obj, target).shifted([0.0, 0.0, pose.above + pose.below + MISS_GAP_M])
