"""The scene of a manipulation model: table, locations, objects and robot as one MuJoCo model."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from prefplan.models.manipulation import ManipulationModel
from sim.layout import BLOCK_HALF, FLOOR, Slot, kind_of, layout
from sim.panda import ARM_JOINTS, FINGER_JOINTS, GRIPPER, HOME, MAX_WIDTH, mesh_folder, panda_spec

TIMESTEP = 0.002
"""Simulation step, s."""

BLOCK_MASS = 0.055
"""Mass of an object, kg: beech of the same size."""

BIN_HALF = 0.0675
"""Half the inner edge of a bin for one or two objects, m: the open fingers reach 62 mm from the middle."""

BIN_WALL = 0.003
"""Thickness of a bin's walls, m."""

BIN_HEIGHT = 0.036
"""Height of a bin's walls, m: lower than the palm over a grasped block."""


@dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Names in `mujoco`: an object's body and geom bear its name, its free joint too. The robot's names are in `sim.panda`.

    Attributes:
        model: what it was built from.
        mujoco: the compiled model.
        slots: for each location, in the order of the file, room for `capacity` objects.
        half: half the edge of an object, m.
        meshes: whether the robot wears meshes rather than capsules.
    """

    model: ManipulationModel
    mujoco: mujoco.MjModel
    slots: dict[str, tuple[Slot, ...]]
    half: float
    meshes: bool


def build_scene(model: ManipulationModel, *, meshes: bool | None = None) -> Scene:
    """Build the scene of a manipulation model.

    Args:
        meshes: dress the robot with meshes; None for where they are installed.

    Raises:
        SimulationError: a location out of reach or in the way of another; the message starts with its key.
    """
    slots = layout(model)
    dressed = mesh_folder() is not None if meshes is None else meshes
    spec = panda_spec(meshes=dressed)
    _options(spec)
    world = spec.worldbody
    world.add_light(pos=[0.5, 0, 2], dir=[0, 0, -1])
    world.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[0.6, 0.65, 0.02],
        pos=[0.35, 0, -0.02],
        rgba=[0.5, 0.38, 0.28, 1],
    )
    for place in model.locations:
        if kind_of(place) == "bin":
            _bin(world, slots[place.name])
        elif kind_of(place) == "pad":
            _pad(world, slots[place.name])
    for thing, slot in start_slots(model, slots).items():
        body = world.add_body(name=thing, pos=slot.position, quat=_quat(slot.yaw))
        body.add_freejoint(name=thing)
        colour = next(o.rgba for o in model.objects if o.name == thing) or (0.5, 0.5, 0.5, 1)
        body.add_geom(
            name=thing,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[BLOCK_HALF] * 3,
            mass=BLOCK_MASS,
            friction=[0.8, 0.01, 0.0005],
            condim=4,
            rgba=colour,
        )
    return Scene(model, spec.compile(), slots, BLOCK_HALF, dressed)


def start_slots(model: ManipulationModel, slots: dict[str, tuple[Slot, ...]]) -> dict[str, Slot]:
    """Return the slot in which each object starts; objects at one location fill its slots in file order."""
    taken = {name: iter(row) for name, row in slots.items()}
    return {thing.name: next(taken[thing.start]) for thing in model.objects}


def initial_state(
    scene: Scene, *, seed: int | None = None, position: float = 0.005, angle: float = np.radians(5)
) -> mujoco.MjData:
    """Return the state before the first action: arm at home, hand open, objects at rest in their slots.

    Args:
        seed: None for nominal poses; otherwise each object is moved at random.
        position: greatest offset along x and along y, m.
        angle: greatest turn about z, rad.
    """
    data = mujoco.MjData(scene.mujoco)
    for name, value in zip(ARM_JOINTS, HOME, strict=True):
        data.joint(name).qpos[0] = value
        data.actuator(name).ctrl[0] = value
    for name in FINGER_JOINTS:
        data.joint(name).qpos[0] = MAX_WIDTH / 2
    data.actuator(GRIPPER).ctrl[0] = MAX_WIDTH
    rng = np.random.default_rng(seed)
    for thing, slot in start_slots(scene.model, scene.slots).items():
        offset, turn = rng.uniform(-1, 1, 2) * position, rng.uniform(-1, 1) * angle
        if seed is None:
            offset, turn = np.zeros(2), 0.0
        data.joint(thing).qpos[:2] = slot.position[:2] + offset
        data.joint(thing).qpos[3:] = _quat(slot.yaw + turn)
    mujoco.mj_forward(scene.mujoco, data)
    return data


def _options(spec: mujoco.MjSpec) -> None:
    """Set the solver: stiff contacts that hold a block by friction alone."""
    option = spec.option
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE


def _quat(yaw: float) -> np.ndarray:
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])


def _bin(world: mujoco.MjsBody, slots: tuple[Slot, ...]) -> None:
    centre = np.mean([slot.position for slot in slots], axis=0)
    body = world.add_body(name=slots[0].location, pos=[*centre[:2], 0.0], quat=_quat(slots[0].yaw))
    box = mujoco.mjtGeom.mjGEOM_BOX
    outer = BIN_HALF + 2 * BIN_WALL
    body.add_geom(
        type=box,
        size=[outer, outer, FLOOR["bin"] / 2],
        pos=[0, 0, FLOOR["bin"] / 2],
        rgba=[0.3, 0.3, 0.33, 1],
    )
    for axis in (0, 1):
        for side in (-1, 1):
            size, pos = [outer, outer, BIN_HEIGHT / 2], [0.0, 0.0, BIN_HEIGHT / 2]
            size[axis], pos[axis] = BIN_WALL, side * (BIN_HALF + BIN_WALL)
            body.add_geom(type=box, size=size, pos=pos, rgba=[0.3, 0.3, 0.33, 1])


def _pad(world: mujoco.MjsBody, slots: tuple[Slot, ...]) -> None:
    centre = np.mean([slot.position for slot in slots], axis=0)
    body = world.add_body(name=slots[0].location, pos=[*centre[:2], 0.0], quat=_quat(slots[0].yaw))
    box = mujoco.mjtGeom.mjGEOM_BOX
    body.add_geom(
        type=box, size=[0.06, 0.06, FLOOR["pad"] / 2], pos=[0, 0, FLOOR["pad"] / 2], rgba=[0.8, 0.85, 0.9, 1]
    )
