"""A user's own MJCF as the world: its fixtures, lights and cameras, sites as locations and bodies as objects.

What belongs to no object is held still: of its joints only the free ones of objects are kept, and no actuators.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from prefplan.errors import ModelError, choices
from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import with_height
from sim.errors import SimulationError, collecting
from sim.geometry.mjcf import solid_geoms

SEARCH_DEPTH_M = 0.02
"""A location lies on the surface that is at most so far below or above it, m."""

FREE = mujoco.mjtJoint.mjJNT_FREE

CORNERS = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(8, 3)
"""Corners of a box about the origin, in halves of its sides."""


@dataclass(frozen=True, eq=False)
class UserScene:
    """A user's MJCF file.

    Attributes:
        path: of the file.
        mujoco: the file compiled as it is.
        data: where everything is at its start.
    """

    path: Path
    mujoco: mujoco.MjModel
    data: mujoco.MjData

    @property
    def prefix(self) -> str:
        """What its names begin with in the whole scene."""
        return f"{self.path.stem}/"

    def names(self, kind: str) -> list[str]:
        """Return the names of all its elements of a kind, such as `site`."""
        number = getattr(self.mujoco, f"n{kind}")
        return [name for i in range(number) if (name := getattr(self.mujoco, kind)(i).name) and name != "world"]

    def free_bodies(self) -> list[str]:
        """Return the names of the bodies that a free joint lets move."""
        bodies = self.mujoco.jnt_bodyid[self.mujoco.jnt_type == FREE]
        return [name for body in bodies if (name := self.mujoco.body(int(body)).name)]

    def surface_below(self, point: np.ndarray) -> float | None:
        """Return the height of the fixed surface just below or above a (3,) point, m, or None."""
        model, hit = self.mujoco, np.array([-1], dtype=np.int32)
        movable = np.isin(model.body_rootid, [model.body(name).id for name in self.free_bodies()])
        solid = ((model.geom_contype != 0) | (model.geom_conaffinity != 0)) & ~movable[model.geom_bodyid]
        groups = model.geom_group.copy()
        model.geom_group[:] = np.where(solid, 0, 1)
        start = point + [0.0, 0.0, SEARCH_DEPTH_M]
        only = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8)
        depth = mujoco.mj_ray(model, self.data, start, np.array([0.0, 0.0, -1.0]), only, 1, -1, hit)
        model.geom_group[:] = groups
        return float(start[2] - depth) if 0 <= depth <= 2 * SEARCH_DEPTH_M else None


def read_scene(model: ManipulationModel) -> UserScene | None:
    """Return the user's scene that a model names, if it names one.

    Raises:
        SimulationError: the file is missing, or MuJoCo refuses it.
    """
    if model.scene is None:
        return None
    path = model.folder / model.scene
    if not path.is_file():
        raise SimulationError(f"scene: {path}: no such file")
    try:
        compiled = mujoco.MjModel.from_xml_path(str(path))
    except (ValueError, mujoco.FatalError) as error:
        raise SimulationError(f"scene: {path}: {str(error).strip()}") from None
    data = mujoco.MjData(compiled)
    mujoco.mj_kinematics(compiled, data)
    return UserScene(path, compiled, data)


def scene_files(path: Path) -> list[Path]:
    """Return the files that a user's scene consists of."""
    return sorted(Path(name) for name in mujoco.mju_getXMLDependencies(str(path)))


def resolved(model: ManipulationModel, scene: UserScene) -> ManipulationModel:
    """Return a model whose locations are where the scene has them, and whose objects are as large as its bodies.

    Raises:
        SimulationError: sites or bodies that the scene does not have, bodies without a free joint, and locations that
            nothing carries. Each fault starts with its key and names the file.
    """
    faults: list[str] = []
    locations, objects = [], []
    on_fixtures = {round(fixture.at[2] + fixture.size[2] / 2, 6) for fixture in model.fixtures}
    for place in model.locations:
        with collecting(faults):
            locations.append(_placed(place, scene, on_fixtures))
    for obj in model.objects:
        with collecting(faults):
            objects.append(obj if obj.body is None else _measured(obj, scene))
    if faults:
        raise SimulationError(*faults)
    try:
        return replace(model, locations=tuple(locations), objects=tuple(objects))
    except ModelError as error:
        raise SimulationError(f"{error} (of {scene.path.name})") from None


def _placed(place: Location, scene: UserScene, heights: Iterable[float]) -> Location:
    """Return a location at the height of what carries it."""
    where = f"locations.{place.name}"
    if place.site is not None:
        sites = scene.names("site")
        if place.site not in sites:
            raise SimulationError(f"{where}.site: {scene.path} has no site {place.site!r} {choices(place.site, sites)}")
        point = scene.data.site(place.site).xpos.copy()
    elif place.at is not None:
        point = np.array(with_height(place.at))
    else:
        return place
    if round(float(point[2]), 6) in heights:
        return place
    height = scene.surface_below(point)
    if height is None:
        at = ", ".join(f"{x:.3f}" for x in point)
        raise SimulationError(f"{where}: nothing in {scene.path} carries it: no fixed surface is near ({at}) m")
    return replace(place, at=(float(point[0]), float(point[1]), round(height, 6)), site=None)


def _measured(obj: Object, scene: UserScene) -> Object:
    """Return an object with the bounding box and the mass of its body."""
    assert obj.body is not None
    where, bodies = f"objects.{obj.name}.body", scene.names("body")
    if obj.body not in bodies:
        raise SimulationError(f"{where}: {scene.path} has no body {obj.body!r} {choices(obj.body, bodies)}")
    free = scene.free_bodies()
    if obj.body not in free:
        those = f"those with one: {', '.join(free)}" if free else "no body has one"
        raise SimulationError(f"{where}: {obj.body!r} of {scene.path} has no free joint; {those}")
    if not len(solid_geoms(scene.mujoco, obj.body)):
        raise SimulationError(f"{where}: {obj.body!r} of {scene.path} has no shape that collides")
    low, high = _bounds(scene, obj.body)
    mass = float(scene.mujoco.body_subtreemass[scene.mujoco.body(obj.body).id])
    return replace(obj, kind="mesh", size=tuple(round(float(side), 6) for side in high - low), mass=mass)


def _bounds(scene: UserScene, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the (3,) ends of the box round the colliding shapes of a body, in its frame, m."""
    model, points = scene.mujoco, []
    for geom in solid_geoms(model, body):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        corners = model.geom_aabb[geom, :3] + CORNERS * model.geom_aabb[geom, 3:]
        points.append(corners @ turn.reshape(3, 3).T + model.geom_pos[geom])
    return np.min(np.concatenate(points), axis=0), np.max(np.concatenate(points), axis=0)


def add_user_scene(
    spec: mujoco.MjSpec, scene: UserScene, objects: Mapping[str, tuple[Object, np.ndarray]]
) -> list[str]:
    """Add a user's scene to a spec, its bodies that are objects with the objects' names.

    Args:
        spec: what to add it to.
        scene: from `read_scene`.
        objects: those that are bodies of it, with the (3,) half sides of their shapes, by name.

    Returns:
        What should be said of it.
    """
    world = mujoco.MjSpec.from_file(str(scene.path))
    _find_files(world, scene.path.parent)
    moving = {obj.body for obj, _ in objects.values()}
    for parts in (world.keys, world.actuators, world.sensors, world.equalities, world.tendons):
        for part in list(parts):
            world.delete(part)
    still = [joint for joint in world.joints if joint.parent.name not in moving]
    told = sorted({joint.parent.name or joint.name for joint in still})
    for joint in still:
        world.delete(joint)
    for name, (obj, half) in objects.items():
        _centre(world, scene, name, obj, half)
    spec.attach(world, prefix=scene.prefix, frame=spec.worldbody.add_frame())
    for name, (obj, _) in objects.items():
        _rename(spec.body(f"{scene.prefix}{obj.body}"), name)
    taken = {camera.name for camera in spec.cameras}
    for camera in spec.cameras:
        plain = camera.name.removeprefix(scene.prefix)
        if camera.name != plain and plain not in taken:
            camera.name = plain
    if any(light.name.startswith(scene.prefix) or not light.name for light in spec.lights):
        for light in spec.lights:
            light.active = light.active and not light.name.startswith("studio_")
    return [f"scene: only what is an object moves; held still: {', '.join(told)}"] if told else []


def _find_files(world: mujoco.MjSpec, folder: Path) -> None:
    """Name the files of meshes and textures by where they are, whatever they are added to."""
    for parts, beside in (
        (world.meshes, world.meshdir),
        (world.textures, world.texturedir),
        (world.hfields, world.meshdir),
    ):
        for part in parts:
            if part.file:
                part.file = os.path.abspath(folder / beside / part.file)
    world.meshdir = world.texturedir = ""


def _centre(world: mujoco.MjSpec, scene: UserScene, name: str, obj: Object, half: np.ndarray) -> None:
    """Give a body the frame of an object: in the middle of its box, x along the line on which the fingers close."""
    body = world.body(obj.body)
    low, high = _bounds(scene, body.name)
    turned = not np.isclose(2 * half[0], high[0] - low[0])
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) if turned else np.eye(3)
    quat, offset = np.zeros(4), -turn @ (low + high) / 2
    mujoco.mju_mat2Quat(quat, turn.ravel())
    frame = body.add_frame(pos=offset, quat=quat)
    for parts in (body.geoms, body.sites, body.cameras, body.lights):
        for part in parts:
            part.set_frame(frame)
    for child in body.bodies:
        child.set_frame(frame)
    if body.explicitinertial:
        total = np.zeros(4)
        mujoco.mju_mulQuat(total, quat, body.iquat)
        body.ipos, body.iquat = turn @ body.ipos + offset, total


def _rename(body: mujoco.MjsBody, name: str) -> None:
    """Give a body, its free joint and its colliding shapes the name of an object."""
    body.name = name
    for joint in body.joints:
        joint.name = name
    solid = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
    for i, geom in enumerate(solid):
        geom.name = f"{name} {i}" if i else name
