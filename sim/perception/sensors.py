"""Sensors: they observe the poses of objects; skills and grounding know these poses from sensors alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from sim.errors import SimulationError
from sim.geometry.rectangle import Rectangle
from sim.world.scene import Scene
from sim.world.shapes import ObjectShape, about_z

OBSERVATION_TIMEOUT_S = 5.0
"""How long to wait for an observation of an object."""

NOISY_SAMPLES = 10
"""Number of observations averaged in a measurement, one per control period: their mean has a third of the noise."""

NOISE_LEVER_M = 0.0225
"""Yaw noise, rad, is position noise, m, divided by this distance, m: half a cube's edge."""

UPRIGHT_TILT_RAD = np.radians(20)
"""Greatest tilt of an object that stands, rad."""

LEANING_TILT_RAD = np.radians(45)
"""Greatest tilt of an object that leans on something, rad; an object tilted by more lies on its side."""

DIAGONAL = np.sqrt(0.5)
"""Vertical component of an axis at 45 degrees."""


class ObservationTimeoutError(SimulationError):
    """An object has not been observed for too long."""


@dataclass(frozen=True)
class ObjectPose:
    """The pose of an object.

    Attributes:
        shape: of the object.
        position: (3,) of its centre in the world frame, m.
        rotation: (3, 3) of its axes in the world frame.
    """

    shape: ObjectShape
    position: np.ndarray
    rotation: np.ndarray

    @cached_property
    def _upright(self) -> np.ndarray:
        return self.shape.most_upright(self.rotation)

    @cached_property
    def yaw(self) -> float:
        """Heading about z of the preferred closing direction, rad, up to its shape's symmetry."""
        level = int(abs(self._upright[2, 0]) > DIAGONAL)
        return float(np.arctan2(self._upright[1, level], self._upright[0, level]))

    @cached_property
    def tilt(self) -> float:
        """Angle of its z axis to the vertical, rad, up to its shape's symmetry: a cube stands on any face."""
        return float(np.arccos(min(1.0, float(self._upright[2, 2]))))

    @property
    def is_upright(self) -> bool:
        """Whether it stands, rather than leans or lies."""
        return self.tilt <= UPRIGHT_TILT_RAD

    @property
    def leans(self) -> bool:
        """Whether it is tilted, but does not lie on its side."""
        return UPRIGHT_TILT_RAD < self.tilt <= LEANING_TILT_RAD

    @property
    def below(self) -> float:
        """How far it reaches below its middle, m."""
        return float(self.shape.half[2]) if self.is_upright else self.shape.depth(self.rotation)

    @property
    def above(self) -> float:
        """How far it reaches above its middle, m; that of a mesh may differ from `below`."""
        return float(self.shape.half[2]) if self.is_upright else self.shape.support(self.rotation[2])

    @property
    def top(self) -> float:
        """Height of its highest point, m."""
        return float(self.position[2] + self.above)

    @property
    def underside(self) -> np.ndarray:
        """(3,) point below its middle, at the height of its lowest point, m."""
        return self.position - [0.0, 0.0, self.below]

    @property
    def footprint(self) -> Rectangle:
        """Its outline seen from above: the rectangle along its yaw that bounds its box."""
        sides = np.abs(about_z(self.yaw).T @ self.rotation)[:2]
        return Rectangle(self.position[:2], sides @ self.shape.half, self.yaw)


Poses = Mapping[str, ObjectPose]
"""Poses by the objects' names."""


class Sensor(Protocol):
    """Interface of a sensor that observes poses of objects, such as a camera."""

    @property
    def samples(self) -> int:
        """Number of observations in a measurement."""

    @property
    def error(self) -> float:
        """Standard deviation of a measured position along each axis, m."""

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """Return the observed pose of an object, or None if it is not observed."""


@dataclass(frozen=True)
class ExactSensor:
    """Observes the true poses."""

    samples: int = 1
    error: float = 0.0

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """Return the true pose; None for a spare object in store."""
        return None if stored(scene, data, obj) else object_pose(scene, data, obj)


class NoisySensor:
    """Observes poses with normally distributed errors of position and heading, independent at every observation."""

    def __init__(self, noise: float, *, seed: int, bias: np.ndarray | None = None) -> None:
        """Set the standard deviation of an observed position along each axis, m, and the seed of the errors.

        The bias is a (3,) constant error of all positions, as of a badly calibrated camera, m.
        """
        self.samples = NOISY_SAMPLES if noise else 1
        self.error = noise / np.sqrt(self.samples)
        self._noise, self._rng = noise, np.random.default_rng(seed)
        self._bias = np.zeros(3) if bias is None else bias

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose | None:
        """Return the true pose with errors; None for a spare object in store."""
        if stored(scene, data, obj):
            return None
        true = object_pose(scene, data, obj)
        rotation = about_z(self._rng.normal(0, self._noise / NOISE_LEVER_M)) @ true.rotation
        return ObjectPose(true.shape, true.position + self._rng.normal(0, self._noise, 3) + self._bias, rotation)


def on_table(pose: ObjectPose | None) -> bool:
    """Return whether an object is observed, and above the table top."""
    return pose is not None and bool(pose.position[2] > 0)


def stored(scene: Scene, data: mujoco.MjData, obj: str) -> bool:
    """Return whether an object is a spare one still in store."""
    return obj in scene.spares and bool(data.body(obj).xpos[2] < 0)


def object_pose(scene: Scene, data: mujoco.MjData, name: str) -> ObjectPose:
    """Return the true pose of an object."""
    body = data.body(name)
    return ObjectPose(scene.shapes[name], body.xpos.copy(), body.xmat.reshape(3, 3).copy())


def true_poses(scene: Scene, data: mujoco.MjData) -> dict[str, ObjectPose]:
    """Return the true pose of every object of a scene's model."""
    return {obj.name: object_pose(scene, data, obj.name) for obj in scene.model.objects}


def mean_pose(poses: Sequence[ObjectPose]) -> ObjectPose:
    """Return the average of several observations of one object at rest."""
    if len(poses) == 1:
        return poses[0]
    rotation = Rotation.from_matrix([pose.rotation for pose in poses]).mean().as_matrix()
    return ObjectPose(poses[0].shape, np.mean([pose.position for pose in poses], axis=0), rotation)
