"""A user's own MJCF as a part of the whole scene.

Everything but objects is fixed in place: of the file's joints only the free joints of objects are kept, and no
actuators. The time step and the solver are those of every scene, whatever options the file has.
"""

from collections.abc import Collection, Mapping

import mujoco
import numpy as np

from sim.external.user_scene import UserScene, bounds
from sim.geometry.mjcf import as_utf8


def add_user_scene(spec: mujoco.MjSpec, scene: UserScene, objects: Mapping[str, tuple[str, bool]]) -> list[str]:
    """Add a user's scene to the whole one; its bodies that are objects get the objects' names.

    `objects` has, by name, the body of each, and whether the body's y axis is the object's x axis. Returns warnings.
    """
    world = mujoco.MjSpec.from_file(as_utf8(scene.path.absolute()))
    without_effect = [*_remove_mechanisms(world), *_set_as_in(spec, world)]
    notes = _hold_still(world, {part for part, _ in objects.values()})
    if without_effect:
        notes.append(f"scene: without effect here: {', '.join(without_effect)}")
    bodies: dict[str, str] = {}
    for name, (moved, turned) in objects.items():
        body = world.body(moved)
        explicit = any(part.explicitinertial for part in (body, *body.find_all("body")))
        bodies |= {f"{scene.prefix}{part}": name for part in (moved, *_join(body))}
        _centre(body, scene, turned=turned, explicit=explicit)
    spec.attach(world, prefix=scene.prefix, frame=spec.worldbody.add_frame())
    geoms: dict[str, str] = {}
    for name, (moved, _) in objects.items():
        geoms |= _rename(spec.body(f"{scene.prefix}{moved}"), name)
    for exclude in spec.excludes:
        exclude.bodyname1, exclude.bodyname2 = (bodies.get(n, n) for n in (exclude.bodyname1, exclude.bodyname2))
    for pair in spec.pairs:
        pair.geomname1, pair.geomname2 = (geoms.get(n, n) for n in (pair.geomname1, pair.geomname2))
    taken = {camera.name for camera in spec.cameras}
    for camera in spec.cameras:
        plain = camera.name.removeprefix(scene.prefix)
        if camera.name != plain and plain not in taken:
            camera.name = plain
    if any(light.name.startswith(scene.prefix) or not light.name for light in spec.lights):
        for light in spec.lights:
            light.active = light.active and not light.name.startswith("studio_")
    return notes


def _hold_still(world: mujoco.MjSpec, moving: Collection[str]) -> list[str]:
    """Remove the joints of all but the bodies that move; return a warning if there were any."""
    still = [joint for joint in world.joints if joint.parent.name not in moving]
    told = sorted({joint.parent.name or joint.name or "a body without a name" for joint in still})
    for joint in still:
        world.delete(joint)
    return [f"scene: only objects can move; fixed in place: {', '.join(told)}"] if told else []


def _remove_mechanisms(world: mujoco.MjSpec) -> list[str]:
    """Remove actuators, constraints, sensors, keyframes and margins; return the kinds that affected the motion."""
    missed = {"actuators": world.actuators, "tendons": world.tendons, "equality constraints": world.equalities}
    found = [name for name, parts in missed.items() if len(parts)]
    for parts in (world.keys, world.tuples, world.sensors, *missed.values()):
        for part in list(parts):
            world.delete(part)
    if any(geom.margin or geom.gap for geom in world.geoms):
        found.append("margins of geoms")
    for geom in world.geoms:
        geom.margin = geom.gap = 0.0
    return found


def _set_as_in(spec: mujoco.MjSpec, world: mujoco.MjSpec) -> list[str]:
    """Give a user's scene the options of a spec; return the names of those that the user had set otherwise."""
    usual, changed = mujoco.MjSpec().option, []
    for name in vars(type(usual)):
        own = getattr(world.option, name)
        if name.startswith("_") or not name.islower():
            continue
        if not any(np.array_equal(own, getattr(option, name), equal_nan=True) for option in (spec.option, usual)):
            changed.append("option flag" if name in ("disableflags", "enableflags") else f"option {name}")
    world.option, world.visual, world.stat = spec.option, spec.visual, spec.stat
    for name in ("memory", "nconmax", "njmax", "nstack", "nuserdata"):
        setattr(world, name, getattr(spec, name))
    return changed


def _join(body: mujoco.MjsBody) -> list[str]:
    """Merge all child bodies of a body into it; return their names."""
    names = []
    while len(body.bodies):
        child = body.bodies[0]
        names.append(child.name)
        child.to_frame()
    return names


def _centre(body: mujoco.MjsBody, scene: UserScene, *, turned: bool, explicit: bool) -> None:
    """Give a body the frame of an object: in the middle of its box, x along the line on which the fingers close.

    `explicit` is whether the file gives the inertia of any of its parts.
    """
    low, high = bounds(scene, body.name)
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) if turned else np.eye(3)
    quat, offset = np.zeros(4), -turn @ (low + high) / 2
    mujoco.mju_mat2Quat(quat, turn.ravel())
    parts = [part for parts in (body.geoms, body.sites, body.cameras, body.lights, body.frames) for part in parts]
    frame = body.add_frame(pos=offset, quat=quat)
    for part in parts:
        if part.frame is None:
            part.set_frame(frame)
    body.explicitinertial = explicit
    if explicit:
        body.mass, centre, inertia = _inertia(scene, body.name)
        body.ipos, body.fullinertia = turn @ centre + offset, np.full(6, np.nan)
        body.inertia, axes = np.linalg.eigh(turn @ inertia @ turn.T)
        axes[:, 2] *= np.linalg.det(axes)
        mujoco.mju_mat2Quat(body.iquat, axes.ravel())
        body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _inertia(scene: UserScene, body: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, kg, (3,) centre, m, and (3, 3) inertia about it of a free body and its children, in its frame."""
    data, number = scene.data, scene.mujoco.body(body).id
    mujoco.mj_comPos(scene.mujoco, data)
    mujoco.mj_crb(scene.mujoco, data)
    # The composite inertia about the centre: three moments, three products, three zeros and the mass.
    xx, yy, zz, xy, xz, yz, *_, mass = data.crb[number]
    total, turn = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), data.xmat[number].reshape(3, 3)
    return float(mass), turn.T @ (data.subtree_com[number] - data.xpos[number]), turn.T @ total @ turn


def _rename(body: mujoco.MjsBody, name: str) -> dict[str, str]:
    """Give a body, its free joint and its colliding geoms the name of an object; return new names of geoms by old."""
    body.name = name
    for joint in body.joints:
        joint.name = name
    solid = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
    old = [geom.name for geom in solid]
    for i, geom in enumerate(solid):
        geom.name = f"{name} {i}" if i else name
    return {before: geom.name for before, geom in zip(old, solid, strict=True) if before}
