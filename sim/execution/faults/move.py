"""Move: an object is moved to a free place."""

import mujoco
import numpy as np

from sim.execution.faults.fault import Injection
from sim.execution.faults.relocation import ObjectFault, is_free, put, put_into
from sim.geometry.mjcf import solid_geoms, yaw_quat
from sim.perception.sensors import ObjectPose
from sim.simulation.workcell import Workcell
from sim.skills.placing import is_carried
from sim.world.shapes import about_z

SLOT_PROBABILITY = 0.3
"""Probability that an object is moved to a free location rather than to anywhere on the table."""

MAX_DISTANCE_M = 0.64
"""Greatest distance from a robot's base at which a moved object is put down, m: all that ship reach 0.78 m."""

MAX_BEARING_RAD = np.radians(65)
"""Greatest angle from straight ahead at which a moved object is put down, rad."""

MAX_DRAWS = 500
"""Greatest number of poses drawn for a moved object until one is free."""


class Move(ObjectFault):
    """An object is put upright into a free slot, or anywhere within reach."""

    kind = "move"

    def disturb(self, injection: Injection) -> bool:
        """See `ObjectFault.disturb`."""
        cell, rng, obj = injection.cell, injection.rng, self.argument
        if rng.random() < SLOT_PROBABILITY:
            slots = [slot for row in cell.scene.slots.values() for slot in row if is_free(cell, slot)]
            if slots:
                put_into(cell, rng, obj, slots[rng.integers(len(slots))])
                return True
        height, robot = float(cell.scene.shapes[obj].half[2]), cell.scene.robot
        lowest, highest = [robot.nearest_m, -MAX_BEARING_RAD, -np.pi], [MAX_DISTANCE_M, MAX_BEARING_RAD, np.pi]
        for _ in range(MAX_DRAWS):
            far, bearing, yaw = rng.uniform(lowest, highest)
            heading, (x, y) = robot.yaw + bearing, robot.position[:2]
            position = np.array([x + far * np.cos(heading), y + far * np.sin(heading), height + 0.001])
            if _fits(cell, obj, position, yaw):
                put(cell, obj, position, yaw)
                return True
        return False


def _fits(cell: Workcell, obj: str, position: np.ndarray, yaw: float) -> bool:
    """Return whether an object at a pose just above a support is carried by it and touches nothing."""
    if not is_carried(cell, obj, ObjectPose(cell.scene.shapes[obj], position, about_z(yaw))):
        return False
    scratch = mujoco.MjData(cell.scene.mujoco)
    scratch.qpos[:] = cell.data.qpos
    pose = scratch.joint(obj).qpos
    pose[:3], pose[3:] = position, yaw_quat(yaw)
    mujoco.mj_kinematics(cell.scene.mujoco, scratch)
    mujoco.mj_collision(cell.scene.mujoco, scratch)
    own = solid_geoms(cell.scene.mujoco, obj)
    return not np.isin(scratch.contact.geom[: scratch.ncon], own).any()
