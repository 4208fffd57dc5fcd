"""The scene of a manipulation model: table, locations, objects and robot as one MuJoCo model."""

import copy
import functools
import hashlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from warnings import catch_warnings

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.external.user_scene import UserScene, read_scene, resolved
from sim.geometry.mjcf import yaw_quat
from sim.geometry.rectangle import Rectangle
from sim.motion.trajectory import CONTROL_PERIOD_S, STEPS
from sim.robots.catalogue import robot_for
from sim.robots.robot import Robot
from sim.world.contacts import declare_contacts
from sim.world.fixtures import add_fixture, blocks_of, body_name, check_fixtures
from sim.world.furniture import add_pedestal, add_station, add_table, name_places_of, table_for
from sim.world.layout import arrange
from sim.world.materials import add_studio, add_wrist_camera
from sim.world.objects import add_objects, add_spares, check_matter, start_slots, stored_at
from sim.world.places import START_OFFSET_M, START_TURN_RAD, Slot, Station
from sim.world.robot_clearance import faults_at_home
from sim.world.shapes import ObjectShape
from sim.world.tabletop import TABLE_TOP, picture

TIMESTEP_S = CONTROL_PERIOD_S / STEPS
"""Simulation step, s."""

COLLISION_TOLERANCE = 1e-8
"""Tolerance of MuJoCo's convex collision detection. At the default of 1e-6, a cylinder between the pads is sometimes
reported for one step as 11 mm deep in a pad, which would push the cylinder out on the far side. At 1e-8, this still
happens near some poses, but ten times as rarely near the pose of a can that the hand presses on a plate."""

FOCUS_HEIGHT_M = 0.21
"""Height above the table of the point that the lights aim at, m: half the height of the arm at work."""

MAX_OVERLAP_M = 0.001
"""Greatest overlap at the start of objects with one another or with a wall, m."""

SETTLE_DURATION_S = 1.0
"""Time for which a start is simulated, s; if an object moves, tips over or falls, a random start is drawn again."""

MAX_SETTLING_M = 0.003
"""Greatest movement within `SETTLE_DURATION_S` of an object that stands, m."""

MAX_SETTLING_RAD = np.radians(3)
"""Greatest tilt within `SETTLE_DURATION_S` of an object that stands, rad."""


@dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Names in `mujoco`: an object's body, its free joint and its first colliding geom bear the object's name; the robot's
    names are in `robot`; `table` is the table's geom.

    Attributes:
        model: manipulation model that it was built from.
        spec: what `mujoco` was compiled from; not pickled.
        mujoco: the compiled model.
        slots: for each location, in the order of the file, `capacity` slots.
        shapes: of each object, in the order of the file, then of the spare ones.
        spares: objects that are not in the model, stored below the table until a fault adds them to the scene.
        temporary: locations that are not in the scenario, each made for one object that is off all others.
        table: outline of the table.
        name_places: (2,) position of the name of each location on the table, m.
        robot: at its pose in the scene.
        latency: time from a command until the actuators receive it, s.
        warnings: for the user.
        nominal: `mujoco` before its perturbation, used to check that objects are at rest at the start; or None.
    """

    model: ManipulationModel
    spec: mujoco.MjSpec
    mujoco: mujoco.MjModel
    slots: dict[str, tuple[Slot, ...]]
    shapes: dict[str, ObjectShape]
    table: Rectangle
    name_places: dict[str, np.ndarray]
    robot: Robot
    spares: tuple[str, ...] = ()
    temporary: frozenset[str] = frozenset()
    latency: float = 0.0
    warnings: tuple[str, ...] = ()
    nominal: mujoco.MjModel | None = None

    def __getstate__(self) -> dict[str, object]:
        """Return what is pickled: all but `spec`, which MuJoCo cannot pickle."""
        return {**vars(self), "spec": None}

    @functools.cached_property
    def sha256(self) -> str:
        """Hash of the compiled model, cached since nothing changes the model."""
        contents = np.empty(mujoco.mj_sizeModel(self.mujoco), dtype=np.uint8)
        mujoco.mj_saveModel(self.mujoco, None, contents)
        return hashlib.sha256(contents.data).hexdigest()

    def with_names(self) -> mujoco.MjModel:
        """Return a copy of the model with names printed on the table, for output without labels over the picture."""
        shown, show = copy.copy(self.mujoco), self.model.display.location
        if self.name_places:
            pixels = picture(self.table, {show(name): at for name, at in self.name_places.items()}).ravel()
            start = int(shown.texture(TABLE_TOP).adr[0])
            shown.tex_data[start : start + len(pixels)] = pixels
        return shown


def build_scene(
    model: ManipulationModel,
    *,
    robot: Robot | str | None = None,
    spares: int = 0,
) -> Scene:
    """Build the scene of a manipulation model.

    Args:
        model: of the locations and objects.
        robot: a robot, or the name of one of `sim.robots.catalogue.ROBOTS`, that replaces the model's robot.
        spares: number of grey cubes in store below the table, for faults that add objects.

    Raises:
        RobotError: the robot is unknown or cannot be loaded.
        SimulationError: locations obstructing others, or objects that the hand cannot grasp; each fault starts with
            its key.
    """
    check_fixtures(model)
    check_matter(model)
    robot = robot_for(model.robot_setup, robot)
    own = read_scene(model)
    if own is not None:
        model = resolved(model, own)
    layout = arrange(model, robot, own)
    shapes = layout.shapes
    spec = robot.spec()
    spec.modelname = "prefplan"
    _set_physics(spec)
    add_wrist_camera(spec, robot)
    blocks = blocks_of(model.fixtures)
    table = table_for(layout.stations, blocks, robot)
    focus = np.array([*table.centre, FOCUS_HEIGHT_M + min((s.height for s in layout.stations), default=0.0)])
    add_studio(spec, target=focus, span=float(table.half.max()))
    name_places: dict[str, np.ndarray] = {}
    if own is None:
        name_places = name_places_of(layout.stations, blocks)
        add_table(spec, table, robot)
        add_pedestal(spec, robot)
    for fixture in model.fixtures:
        add_fixture(spec, fixture)
    for station in layout.stations:
        add_station(spec, station)
    warnings = add_objects(spec, model, layout.slots, shapes, own)
    names = add_spares(spec, model, spares, shapes, robot)
    declare_contacts(spec, shapes, pads=robot.gripper.pads, supports=_supports(spec, model, layout.stations))
    compiled = _compiled(spec, own)
    scene = Scene(model, spec, compiled, layout.slots, shapes, table, name_places, robot, names, warnings=warnings)
    start = initial_state(scene)
    faults = [*faults_at_home(scene.mujoco, start, robot, _keys(model), own), *(_faults_at_start(scene, start, own))]
    if faults:
        raise SimulationError(*faults)
    return scene


def _supports(spec: mujoco.MjSpec, model: ManipulationModel, stations: Sequence[Station]) -> list[mujoco.MjsBody]:
    """Return the bodies that objects may lie on, those of a user's scene left out."""
    names = [body_name(fixture.name) for fixture in model.fixtures] + [f"{station.name}_base" for station in stations]
    return [spec.body(name) for name in (*(() if model.scene else ("table",)), *names)]


def _compiled(spec: mujoco.MjSpec, own: UserScene | None) -> mujoco.MjModel:
    """Return the compiled scene; raise `SimulationError` if MuJoCo refuses it because of the user's scene."""
    try:
        with catch_warnings(action="ignore"):  # about cloth that is fixed in place: `add_objects` reports it
            return spec.compile()
    except ValueError as error:
        if own is None:
            raise
        raise SimulationError(
            f"scene: {own.path}: as a part of the whole scene, {' '.join(str(error).split())}"
        ) from None


def _keys(model: ManipulationModel) -> dict[str, str]:
    """Return the key in the scenario of each body that has one."""
    keys = {body_name(fixture.name): f"fixtures.{fixture.name}" for fixture in model.fixtures}
    keys |= {f"{place.name}_base": f"locations.{place.name}" for place in model.locations}
    return keys | {obj.name: f"objects.{obj.name}" for obj in model.objects}


def _faults_at_start(scene: Scene, data: mujoco.MjData, own: UserScene | None) -> list[str]:
    """Return the faults of objects that stand inside the user's own scene, or that nothing holds up."""
    if own is None:
        return []
    names, faults = [obj.name for obj in scene.model.objects], []
    for pair, depth in zip(data.contact.geom, data.contact.dist, strict=True):
        bodies = [str(scene.mujoco.body(body).name) for body in scene.mujoco.geom_bodyid[pair]]
        for obj, other in itertools.permutations(bodies):
            if depth <= -MAX_OVERLAP_M and obj in names and own.holds(other):
                faults.append(f"objects.{obj}: where it starts, it would be inside {own.words(other)}")
    return list(dict.fromkeys(faults)) or [
        f"objects.{obj}: where it starts, {own.path} does not hold it: it falls, sinks in or tips over"
        for obj in _unsettled(scene, data)
    ]


def initial_state(
    scene: Scene,
    *,
    seed: int | None = None,
    position: float = START_OFFSET_M,
    angle: float = START_TURN_RAD,
    draws: int = 1000,
) -> mujoco.MjData:
    """Return the state before the first action: arm at home, hand open, objects at rest in their slots.

    Args:
        scene: what `build_scene` returned.
        seed: None for nominal poses; otherwise each object is moved at random.
        position: greatest offset along x and along y, m.
        angle: greatest turn about z, rad.
        draws: greatest number of random starts that are drawn.

    Raises:
        SimulationError: in each of the random starts, objects overlap or fall.
    """
    data = mujoco.MjData(scene.mujoco)
    scene.robot.put(data, scene.robot.home, width=scene.robot.gripper.opening_m)
    rng = None if seed is None else np.random.default_rng(seed)
    for _ in range(draws):
        for obj, slot in start_slots(scene.model, scene.slots, scene.shapes).items():
            off = np.zeros(3) if rng is None else rng.uniform(-1, 1, 3) * [position, position, angle]
            pose = data.joint(obj).qpos
            pose[:2] = slot.position[:2] + off[:2]
            pose[2] = slot.position[2] + scene.shapes[obj].half[2]
            pose[3:] = yaw_quat(slot.yaw + off[2])
        for i, name in enumerate(scene.spares):
            data.joint(name).qpos[:3] = stored_at(scene.shapes[name], i)
        mujoco.mj_forward(scene.mujoco, data)
        if rng is None or not _overlaps(scene, data) and not _unsettled(scene, data):
            return data
    raise SimulationError(
        f"objects moved by up to {position * 1000:g} mm stand inside one another or fall; move them by less"
    )


def _overlaps(scene: Scene, data: mujoco.MjData) -> bool:
    """Return whether objects overlap with one another or with a wall, or touch the robot."""
    robot = scene.robot.bodies(scene.mujoco)[scene.mujoco.geom_bodyid[data.contact.geom]].any(axis=-1)
    return bool((data.contact.dist <= np.where(robot, 0.0, -MAX_OVERLAP_M)).any())


def _unsettled(scene: Scene, data: mujoco.MjData) -> list[str]:
    """Return the objects that move or tip over within `SETTLE_DURATION_S` in the nominal world."""
    model = scene.nominal or scene.mujoco
    names = [obj.name for obj in scene.model.objects]
    bodies, later = [model.body(name).id for name in names], copy.copy(data)
    mujoco.mj_step(model, later, round(SETTLE_DURATION_S / TIMESTEP_S))
    moved = np.linalg.norm(later.xpos[bodies] - data.xpos[bodies], axis=1)
    tilted = np.linalg.norm(later.xmat[bodies, 6:] - data.xmat[bodies, 6:], axis=1)
    stands = (moved < MAX_SETTLING_M) & (tilted < MAX_SETTLING_RAD)
    return [name for name, still in zip(names, stands, strict=True) if not still]


def _set_physics(spec: mujoco.MjSpec) -> None:
    """Set the solver so that friction alone holds an object in the hand."""
    option = spec.option
    option.timestep = TIMESTEP_S
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.ccd_tolerance = COLLISION_TOLERANCE
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
