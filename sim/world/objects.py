"""Objects of a scene: where they start, their bodies and shapes, and spare ones in store."""

import math
from dataclasses import replace

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationModel, Object
from prefplan.models.manipulation.slots import slots_at_start
from sim.errors import SimulationError
from sim.external.attachment import add_user_scene
from sim.external.meshes import MeshParts, mesh_of
from sim.external.user_scene import UserScene
from sim.geometry.mjcf import HIDDEN, draw_solid, yaw_quat
from sim.geometry.solids import rounded
from sim.robots.robot import Robot
from sim.world.furniture import BOX, CYLINDER, EDGE_M
from sim.world.materials import OBJECT_COLOURS, SPARE_COLOUR, Rgba
from sim.world.places import Slot, unused_names
from sim.world.shapes import ObjectShape, shape_of

OBJECT_SURFACE = (1.0, 0.01, 0.0005)
"""Sliding, torsional and rolling friction of objects on the table, and on what stands there."""

STORE_M = np.array([0.0, 0.0, -1.4])
"""Where the first spare object is stored, m: on a shelf below the table."""


def check_matter(model: ManipulationModel) -> None:
    """Raise `SimulationError` for an impossible colour, mass or mesh of an object; the message begins with the key."""
    for obj in model.objects:
        where = f"objects.{obj.name}"
        if obj.rgba is not None and not all(0 <= part <= 1 for part in obj.rgba):
            raise SimulationError(f"{where}.rgba: each part must lie between 0 and 1, not {list(obj.rgba)}")
        if not (math.isfinite(obj.scale) and obj.scale > 0):
            raise SimulationError(f"{where}.scale: must be positive, not {obj.scale:g}")
        if obj.mass is not None and not (math.isfinite(obj.mass) and obj.mass > 0):
            raise SimulationError(f"{where}.mass: must be positive, not {obj.mass:g}")
        if obj.kind != "mesh" and (obj.file is not None or obj.scale != 1):
            key = "scale" if obj.file is None else "file"
            raise SimulationError(f'{where}.{key}: only an object of kind = "mesh" has one')
        if obj.kind == "mesh" and obj.size is not None and obj.body is None:
            raise SimulationError(f"{where}.size: a mesh is as large as its file says; `scale` changes it")


def add_objects(
    spec: mujoco.MjSpec,
    model: ManipulationModel,
    slots: dict[str, tuple[Slot, ...]],
    shapes: dict[str, ObjectShape],
    own: UserScene | None,
) -> tuple[str, ...]:
    """Add the objects where they start, and the user's own scene if there is one; return warnings for the user.

    Raises `SimulationError` if an object has the name of another part of the scene.
    """
    _check_names(spec, model)
    warnings: list[str] = []
    bodies = {obj.name: (obj.body, shapes[obj.name].turned) for obj in model.objects if obj.body is not None}
    if own is not None:
        warnings += add_user_scene(spec, own, bodies)
    for i, (name, slot) in enumerate(start_slots(model, slots, shapes).items()):
        obj, at = model.objects[i], slot.position + [0.0, 0.0, shapes[name].half[2]]
        if name in bodies:
            spec.body(name).pos, spec.body(name).quat = at, yaw_quat(slot.yaw)
            continue
        mesh = mesh_of(obj, model.folder) if obj.kind == "mesh" else None
        if mesh is not None and mesh.warning is not None:
            warnings.append(f"objects.{name}: {mesh.warning}")
        rgba = obj.rgba or OBJECT_COLOURS[i % len(OBJECT_COLOURS)]
        _add_object(spec, name, shapes[name], at, slot.yaw, rgba, mesh)
    return tuple(warnings)


def _check_names(spec: mujoco.MjSpec, model: ManipulationModel) -> None:
    """Raise `SimulationError` if an object or its visual geom has a name that is taken; faults start with the key."""
    kinds = (spec.bodies, spec.joints, spec.geoms, spec.materials, spec.meshes)
    taken = {part.name for parts in kinds for part in parts}
    drawn = {_drawn(obj.name) for obj in model.objects}
    faults = [
        f"objects.{obj.name}: another part of the simulated scene has this name; give the object another one"
        for obj in model.objects
        if obj.name in taken | drawn or _drawn(obj.name) in taken
    ]
    if faults:
        raise SimulationError(*faults)


def _drawn(name: str) -> str:
    """Return the name of an object's visual geom."""
    return f"{name}_body"


def why_no_spares(model: ManipulationModel) -> str | None:
    """Return why a scene can have no spare objects, or None: the floor of a user's scene may run through the store."""
    return None if model.scene is None else f"unknown objects appear on the usual table only, not in {model.scene}"


def add_spares(
    spec: mujoco.MjSpec, model: ManipulationModel, number: int, shapes: dict[str, ObjectShape], robot: Robot
) -> tuple[str, ...]:
    """Add grey cubes in store, and their shapes to the others; return their names."""
    names = unused_names(model, "foreign", number)
    if names and (reason := why_no_spares(model)):
        raise SimulationError(f"scene: {reason}")
    if names:
        shelf = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[1.0, 0.1, 0.01], group=HIDDEN)
        shelf.pos = STORE_M - [0.0, 0.0, 0.01]
    for i, name in enumerate(names):
        shapes[name] = shape_of(Object(name, ""), robot.gripper)
        _add_object(spec, name, shapes[name], stored_at(shapes[name], i), 0.0, SPARE_COLOUR)
    return names


def start_slots(
    model: ManipulationModel, slots: dict[str, tuple[Slot, ...]], shapes: dict[str, ObjectShape]
) -> dict[str, Slot]:
    """Return the slot in which each object starts, on top of the objects that start below it.

    Objects at one location fill its slots in file order, unless the model's initial state names their slots. If a
    location below is empty, the object starts at the greatest height of its slot.
    """
    places = [(obj.name, obj.start) for obj in model.objects]
    capacities = {name: len(row) for name, row in slots.items()}
    indices = slots_at_start(places, dict(model.initial_state.slots), capacities)
    found = {obj: slots[place][indices[obj]] for obj, place in places}
    first = {obj.start: obj.name for obj in reversed(model.objects)}

    def floor(location: str) -> float:
        below = model.location(location).on
        if not below or not first.keys() >= set(below):
            return float(slots[location][0].position[2])
        return max(floor(support) + shapes[first[support]].height for support in below)

    return {
        name: replace(slot, position=np.array([*slot.position[:2], floor(slot.location)]))
        for name, slot in found.items()
    }


def stored_at(shape: ObjectShape, index: int) -> np.ndarray:
    """Return the (3,) position of a spare object in store, m."""
    return STORE_M + [0.06 * index, 0.0, shape.half[2]]


def _add_object(
    spec: mujoco.MjSpec,
    name: str,
    shape: ObjectShape,
    position: np.ndarray,
    yaw: float,
    rgba: Rgba,
    mesh: MeshParts | None = None,
) -> None:
    """Add an object: a free body, its joint and its (first) colliding geom all bear its name."""
    body = spec.worldbody.add_body(name=name, pos=position, quat=yaw_quat(yaw))
    body.add_freejoint(name=name)
    spec.add_material(name=name, rgba=rgba, specular=0.35, shininess=0.45)
    if mesh is not None:
        _add_mesh(spec, body, shape, mesh)
        return
    geom = body.add_geom(name=name, mass=shape.mass, group=HIDDEN)
    geom.friction, geom.condim = OBJECT_SURFACE, 4
    corner = EDGE_M
    geom.type, geom.size = BOX, shape.half
    if shape.kind == "cylinder":
        # Rolling friction stops a cylinder that has fallen over.
        geom.type, geom.size, geom.condim = CYLINDER, [shape.half[0], shape.half[2], 0.0], 6
        corner = float(shape.half[0])
    draw_solid(spec, body, _drawn(name), rounded(shape.half, corner=corner, edge=EDGE_M), name)


def _add_mesh(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: ObjectShape, mesh: MeshParts) -> None:
    """Give an object its convex collision parts, each with its share of the mass, and its visual mesh."""
    turn = yaw_quat(-np.pi / 2 if shape.turned else 0.0)
    volume = sum(part.volume for part in mesh.parts)
    for i, part in enumerate(mesh.parts):
        name = f"{body.name} {i}" if i else body.name
        spec.add_mesh(name=name, uservert=part.vertices.ravel(), userface=part.faces.ravel())
        geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, group=HIDDEN, quat=turn)
        geom.mass = shape.mass * part.volume / volume
        # A mesh may be round: rolling friction stops it.
        geom.friction, geom.condim = OBJECT_SURFACE, 6
    draw_solid(spec, body, _drawn(body.name), mesh.drawn, body.name, quat=turn)
