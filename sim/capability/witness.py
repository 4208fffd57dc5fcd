"""Transfers that succeeded: among other objects that are clear of their motions, they are not rehearsed again."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import mujoco
import numpy as np

from sim.capability.arrangement import Places
from sim.geometry.mjcf import is_solid
from sim.motion.trajectory import spaced
from sim.simulation.kinematic_cell import Followed
from sim.world.scene import Scene

STEP_M = 0.04
"""Bound on how far a point of the arm moves between two configurations that are checked, m."""

CELL_M = 0.05
"""Greatest side of the cells into which parts of the arm are divided, m."""

CLEAR_M = 0.05
"""An object farther than this from the spheres around the parts of the arm and the load hinders nothing, m: half of
`STEP_M`, and more than any clearance that skills keep."""


class Witness:
    """A transfer that succeeded among some other objects."""

    def __init__(self, scene: Scene, others: Places, followed: Sequence[Followed], levers: np.ndarray) -> None:
        """Take the scene, the other objects, the movements, and (n,) bounds as of `CollisionChecker.levers`."""
        self._scene, self._others, self._followed, self._levers = scene, others, followed, levers
        self._clear: dict[tuple[str, str], bool] = {}

    def allows(self, others: Places) -> bool:
        """Return whether the transfer succeeds among these objects, too: any that stand elsewhere are clear of it."""
        return all(self._is_clear(*one) for one in others.items() if one not in self._others.items())

    def _is_clear(self, obj: str, place: str) -> bool:
        """Return whether an object at a location is clear of all motions; False on other objects (pose unknown)."""
        if (obj, place) not in self._clear:
            stands = not self._scene.model.location(place).on
            self._clear[obj, place] = stands and all(
                self._gap(obj, slot.position) > CLEAR_M for slot in self._scene.slots[place]
            )
        return self._clear[obj, place]

    def _gap(self, obj: str, base: np.ndarray) -> float:
        """Return the least distance of the spheres from a cylinder around an object that stands at a point, m."""
        half, (centres, radii) = self._scene.shapes[obj].half, self._spheres
        aside = np.maximum(np.hypot(*(centres[:, :2] - base[:2]).T) - np.hypot(*half[:2]), 0.0)
        above = np.abs(centres[:, 2] - base[2] - half[2]) - half[2]
        return float(np.min(np.hypot(aside, np.maximum(above, 0.0)) - radii, initial=np.inf))

    @cached_property
    def _spheres(self) -> tuple[np.ndarray, np.ndarray]:
        """(S, 3) centres and (S,) radii, m, of spheres around the parts of the arm and its load on all movements."""
        model, robot = self._scene.mujoco, self._scene.robot
        data, tool = mujoco.MjData(model), robot.tool
        geoms, inside, sizes = _cells(model, np.flatnonzero(robot.bodies(model)[model.geom_bodyid] & is_solid(model)))
        centres, radii = list[np.ndarray](), list[np.ndarray]()
        for rows, width, load in self._followed:
            for q in spaced(rows, self._levers, step=STEP_M):
                robot.put(data, q, width=width)
                mujoco.mj_kinematics(model, data)
                turns = data.geom_xmat[geoms].reshape(-1, 3, 3)
                centres.append(data.geom_xpos[geoms] + np.einsum("gij,gj->gi", turns, inside))
                radii.append(sizes)
                if load is not None:
                    obj, offset = load
                    centres.append((data.site(tool).xpos + data.site(tool).xmat.reshape(3, 3) @ offset)[None])
                    radii.append(np.array([np.linalg.norm(self._scene.shapes[obj].half)]))
        return np.concatenate(centres), np.concatenate(radii)


def _cells(model: mujoco.MjModel, geoms: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return spheres that cover some geoms: (P,) geom, (P, 3) centre in the geom's frame, m, and (P,) radius, m."""
    owners, centres, radii = list[int](), list[np.ndarray](), list[float]()
    for geom in geoms.tolist():
        middle, half = model.geom_aabb[geom].reshape(2, 3)
        counts = np.ceil(2 * half / CELL_M).astype(int)
        for cell in np.ndindex(*counts):
            owners.append(geom)
            centres.append(middle + half * ((2 * np.array(cell) + 1) / counts - 1))
            radii.append(float(np.linalg.norm(half / counts)))
    return np.array(owners), np.array(centres), np.array(radii)
