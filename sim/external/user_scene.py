"""A user's own MJCF as the world: its fixtures, lights and cameras, sites as locations and bodies as objects."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from prefplan.errors import ModelError, choices
from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import with_height
from sim.errors import SimulationError, collecting, in_metres
from sim.geometry.mjcf import as_utf8, box_corners, first_met, is_solid, opaque
from sim.geometry.mjcf_limits import check_file

SEARCH_DEPTH_M = 0.02
"""Greatest distance of a location from the surface below or above it that carries it, m."""

PLAIN = {int(mujoco.mjtGeom.mjGEOM_BOX): "box", int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder"}
"""Kinds of objects by types of geoms."""


@dataclass(frozen=True, eq=False)
class UserScene:
    """A user's MJCF file, the model compiled from it alone, and its initial state, with kinematics computed."""

    path: Path
    mujoco: mujoco.MjModel
    data: mujoco.MjData

    @property
    def prefix(self) -> str:
        """Prefix of its names in the whole scene."""
        return f"{self.path.stem}/"

    def holds(self, body: str) -> bool:
        """Return whether a body of the whole scene comes from this one, in which bodies may have no name."""
        return body in ("", "world") or body.startswith(self.prefix)

    def words(self, body: str) -> str:
        """Return how messages name such a body."""
        name = body.removeprefix(self.prefix)
        return f"{'what stands' if name in ('', 'world') else repr(name)} in {self.path}"

    def names(self, kind: str) -> list[str]:
        """Return the names of all its elements of a kind, such as `site`."""
        number = getattr(self.mujoco, f"n{kind}")
        return [name for i in range(number) if (name := getattr(self.mujoco, kind)(i).name) and name != "world"]

    def free_bodies(self) -> list[str]:
        """Return the names of the bodies with a free joint."""
        bodies = self.mujoco.jnt_bodyid[self.mujoco.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
        return [name for body in bodies if (name := self.mujoco.body(int(body)).name)]

    def surface_below(self, point: np.ndarray, objects: Collection[str]) -> float | None:
        """Return the height of the fixed surface just below or above a (3,) point, m, or None.

        All bodies are fixed but those that are objects.
        """
        model = self.mujoco
        movable = np.isin(model.body_rootid, [model.body(name).id for name in self.free_bodies() if name in objects])
        fixed = opaque(model, is_solid(model) & ~movable[model.geom_bodyid])
        start = point + [0.0, 0.0, SEARCH_DEPTH_M]
        _, depth = first_met(fixed, self.data, start, np.array([0.0, 0.0, -1.0]))
        return float(start[2] - depth) if 0 <= depth <= 2 * SEARCH_DEPTH_M else None


def read_scene(model: ManipulationModel) -> UserScene | None:
    """Return the user's scene that a model names, or None; raise `SimulationError` if MuJoCo cannot read it."""
    if model.scene is None:
        return None
    path = model.folder / model.scene
    check_file(path, "scene")
    try:
        compiled = mujoco.MjModel.from_xml_path(as_utf8(path))
    except (ValueError, mujoco.FatalError) as error:
        raise SimulationError(f"scene: {path}: {' '.join(str(error).split())}") from None
    data = mujoco.MjData(compiled)
    mujoco.mj_kinematics(compiled, data)
    return UserScene(path, compiled, data)


def resolved(model: ManipulationModel, scene: UserScene) -> ManipulationModel:
    """Return a model whose locations have their positions in the scene, and whose objects the sizes of its bodies.

    Raises:
        SimulationError: sites or bodies that the scene does not have, bodies without a free joint, and locations that
            nothing carries. Each fault starts with its key and names the file.
    """
    faults: list[str] = []
    locations, objects = [], []
    with collecting(faults):
        _check_each_once(model.objects)
    bodies = {obj.body for obj in model.objects if obj.body is not None}
    on_fixtures = {round(fixture.at[2] + fixture.size[2] / 2, 6) for fixture in model.fixtures}
    for place in model.locations:
        with collecting(faults):
            locations.append(_placed(place, scene, on_fixtures, bodies))
    for obj in model.objects:
        with collecting(faults):
            objects.append(obj if obj.body is None else _measured(obj, scene))
    if faults:
        raise SimulationError(*faults)
    try:
        return replace(model, locations=tuple(locations), objects=tuple(objects))
    except ModelError as error:
        raise SimulationError(f"{error} (of {scene.path.name})") from None


def _placed(place: Location, scene: UserScene, heights: Iterable[float], objects: Collection[str]) -> Location:
    """Return a location at the height of the surface that carries it."""
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
    height = scene.surface_below(point, objects)
    if height is None:
        at = in_metres(point)
        raise SimulationError(f"{where}: nothing in {scene.path} carries it: no fixed surface is near {at}")
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
    if not len(solids(scene, obj.body)):
        raise SimulationError(f"{where}: {obj.body!r} of {scene.path} has no shape that collides")
    low, high = bounds(scene, obj.body)
    x, y, z = (round(float(side), 6) for side in high - low)
    kind = _kind(scene, obj.body)
    mass = float(scene.mujoco.body_subtreemass[scene.mujoco.body(obj.body).id])
    found = replace(
        obj, kind=kind, size=(x, z) if kind == "cylinder" else (x, y, z), mass=mass, rgba=None, file=None, scale=1.0
    )
    for key in ("size", "mass", "rgba", "file", "scale"):
        if getattr(obj, key) not in (None, getattr(found, key)):
            raise SimulationError(f"objects.{obj.name}.{key}: as {scene.path} says for {obj.body!r}; leave it out")
    return found


def _kind(scene: UserScene, body: str) -> str:
    """Return the kind of the object that a body is: box or cylinder if it is a single upright geom, else mesh."""
    model, (first, *rest) = scene.mujoco, geoms_of(scene, body).tolist()
    kind = PLAIN.get(int(model.geom_type[first]), "mesh")
    turn = np.abs(scene.data.body(body).xmat.reshape(3, 3).T @ scene.data.geom_xmat[first].reshape(3, 3))
    upright = np.allclose(turn[2], [0, 0, 1]) and np.allclose(turn.max(axis=0), 1)
    return kind if upright and not rest else "mesh"


def _check_each_once(objects: Iterable[Object]) -> None:
    """Raise `SimulationError` if two objects name the same body."""
    first: dict[str, str] = {}
    for obj in objects:
        if obj.body is not None and first.setdefault(obj.body, obj.name) != obj.name:
            raise SimulationError(f"objects.{obj.name}.body: {obj.body!r} is already the object {first[obj.body]!r}")


def solids(scene: UserScene, body: str) -> np.ndarray:
    """Return the indices of the colliding geoms of a free body and of the bodies in it."""
    geoms = geoms_of(scene, body)
    return geoms[is_solid(scene.mujoco)[geoms]]


def geoms_of(scene: UserScene, body: str) -> np.ndarray:
    """Return the indices of all geoms of a free body and of the bodies in it."""
    model = scene.mujoco
    return np.flatnonzero(model.body_rootid[model.geom_bodyid] == model.body(body).id)


def bounds(scene: UserScene, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the (3,) lower and upper corner of the box round the colliding geoms of a body, in its frame, m."""
    frame, corners = scene.data.body(body), box_corners(scene.data, solids(scene, body))
    points = (corners - frame.xpos) @ frame.xmat.reshape(3, 3)
    return points.min(axis=(0, 1)), points.max(axis=(0, 1))
