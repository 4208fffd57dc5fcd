"""What a picture of a scene must show: objects, locations, their names, and the hand at work."""

from dataclasses import replace

import mujoco
import numpy as np

from sim.geometry.mjcf import CORNERS, box_corners
from sim.skills.hand import HOVER_HEIGHT_M, TRANSFER_CLEARANCE_M
from sim.world.fixtures import body_name
from sim.world.places import AT_RADIUS_M, Slot, extent
from sim.world.scene import Scene
from sim.world.shapes import about_z

REST_S = 0.5
"""Time over which it is decided whether an object is at rest, s."""

REST_DISTANCE_M = 0.001
"""An object at rest moves by less than this in `REST_S`, m."""


def work_points(scene: Scene) -> np.ndarray:
    """Return (N, 3) points that bound the objects, locations, fixtures, names and the hand at work, m.

    The hand is at home for a second only: with that in view, a cube of Case Study 3 would be 40 pixels wide, not 66.
    """
    parts = [object_corners(scene), hand_corners(scene), np.array([*label_anchors(scene).values()])]
    model, data = scene.mujoco, mujoco.MjData(scene.mujoco)
    mujoco.mj_kinematics(model, data)
    bases = [model.body(f"{place.name}_base").id for place in scene.model.locations if place.at is not None]
    stations = np.isin(model.geom_bodyid, bases)
    parts.append(box_corners(data, np.flatnonzero(stations | of_fixtures(scene))))
    return np.concatenate([part.reshape(-1, 3) for part in parts])


def of_fixtures(scene: Scene) -> np.ndarray:
    """Return (ngeom,) bool: which geoms belong to fixtures."""
    bodies = [scene.mujoco.body(body_name(fixture.name)).id for fixture in scene.model.fixtures]
    return np.isin(scene.mujoco.geom_bodyid, bodies)


def home_points(scene: Scene) -> np.ndarray:
    """Return (N, 3) points that bound the hand at home, m."""
    return box_corners(*_hand_at_home(scene)).reshape(-1, 3)


def object_corners(scene: Scene) -> np.ndarray:
    """Return (S, 8, 3) corners of a box round the largest object in each of the S slots, m."""
    half, slots = _object_half(scene), _slots(scene)
    middles = np.array([slot.position for slot in slots]) + [0.0, 0.0, half[2]]
    return _turned(CORNERS * half, [slot.yaw for slot in slots]) + middles[:, None]


def label_targets(scene: Scene) -> dict[str, np.ndarray]:
    """Return the (3,) middle of each location that is not temporary, m, by its displayed name.

    At a location on others, it is the middle of an object there.
    """
    show = scene.model.display.location
    named = [name for name in scene.slots if name not in scene.temporary]
    lift = {name: _object_half(scene)[2] if scene.model.location(name).on else 0.0 for name in named}
    return {
        show(name): np.mean([slot.position for slot in scene.slots[name]], axis=0) + [0.0, 0.0, height]
        for name, height in lift.items()
    }


def label_anchors(scene: Scene) -> dict[str, np.ndarray]:
    """Return the preferred (3,) point for the name of each location of `label_targets`, m: beside it on the table."""
    show = scene.model.display.location
    beside = {show(name): np.array([*place, 0.0]) for name, place in scene.name_places.items()}
    return label_targets(scene) | beside


def hand_corners(scene: Scene) -> np.ndarray:
    """Return (S, 8, 3) corners of a box round the hand over each of the S slots, at its transfer height, m."""
    half, slots = _object_half(scene), _slots(scene)
    data, geoms = _hand_at_home(scene)
    tool = data.site(scene.robot.tool)
    points = (box_corners(data, geoms).reshape(-1, 3) - tool.xpos) @ tool.xmat.reshape(3, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    # The tool's z axis points down.
    box = (low + high) / 2 * [1.0, 1.0, -1.0] + CORNERS * (high - low) / 2
    tools = np.array([slot.position for slot in slots]) + [0.0, 0.0, half[2] + HOVER_HEIGHT_M]
    top = max(slot.position[2] for slot in slots) + 2 * half[2]
    tools[:, 2] = np.maximum(tools[:, 2], top + half[2] + TRANSFER_CLEARANCE_M)
    return _turned(box, [slot.yaw - np.pi / 2 for slot in slots]) + tools[:, None]


def with_strays(scene: Scene, qpos: np.ndarray) -> Scene:
    """Return a scene with temporary locations where objects come to rest off every slot, for instance after faults.

    The (T, nq) recorded states are `REST_S` apart.
    """
    slots = np.array([slot.position[:2] for slot in _slots(scene)])
    found = {}
    for name, shape in scene.shapes.items():
        joint = scene.mujoco.joint(name).qposadr[0]
        positions = qpos[:, joint : joint + 3] - [0.0, 0.0, shape.half[2]]
        at_rest = np.linalg.norm(np.diff(positions, axis=0), axis=1) < REST_DISTANCE_M
        off = np.linalg.norm(positions[1:, None, :2] - slots, axis=2).min(axis=1) > AT_RADIUS_M
        inside = (abs(positions[1:, :2] - scene.table.centre) < scene.table.half).all(axis=1)
        above = positions[1:, 2] > -shape.half[2]
        for position in np.unique(positions[1:][at_rest & off & inside & above].round(2), axis=0):
            place = f"{name} at {position}"
            found[place] = (Slot(place, 0, position, 0.0),)
    return replace(scene, slots=scene.slots | found, temporary=scene.temporary | found.keys())


def _hand_at_home(scene: Scene) -> tuple[mujoco.MjData, np.ndarray]:
    """Return the state with the arm at home and its fingers open, and the (G,) geoms of the hand."""
    model, robot = scene.mujoco, scene.robot
    data = mujoco.MjData(model)
    robot.put(data, robot.home, width=robot.gripper.opening_m)
    mujoco.mj_kinematics(model, data)
    hand = int(model.site(robot.tool).bodyid[0])
    return data, np.flatnonzero((model.geom_bodyid == hand) | (model.body_parentid[model.geom_bodyid] == hand))


def _slots(scene: Scene) -> list[Slot]:
    return [slot for row in scene.slots.values() for slot in row]


def _object_half(scene: Scene) -> np.ndarray:
    size = extent(scene.shapes.values())
    return np.array([*size.half, size.high / 2])


def _turned(points: np.ndarray, yaws: list[float]) -> np.ndarray:
    """Return (N, 3) points rotated about z by each of S yaws, rad: (S, N, 3)."""
    return np.stack([points @ about_z(yaw).T for yaw in yaws])
