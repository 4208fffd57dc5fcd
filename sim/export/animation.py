"""A run as a glTF animation: channels for the bodies that have joints, and for what glows."""

from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.export.names import OFF, ON, body_node, geom_node, lamps

FLOAT = 5126
"""glTF's component type of 32-bit floating point numbers."""

Items = dict[Any, bytes]
"""Buffers of the file's binary part, in order, by unique names."""


def local_poses(model: mujoco.MjModel, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pose of each body in its parent's frame at (T, nq) positions.

    Returns:
        (T, nbody, 3) positions, m, and (T, nbody, 4) unit quaternions, w first, with continuous signs over time.
    """
    data = mujoco.MjData(model)
    positions, quaternions = np.empty((len(qpos), model.nbody, 3)), np.empty((len(qpos), model.nbody, 4))
    for row, values in enumerate(qpos):
        data.qpos[:] = values
        mujoco.mj_kinematics(model, data)
        positions[row], quaternions[row] = data.xpos, data.xquat
    local_positions, local_quaternions = positions.copy(), quaternions.copy()
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        into, own = (Rotation.from_quat(quaternions[:, i], scalar_first=True) for i in (parent, body))
        local_positions[:, body] = into.inv().apply(positions[:, body] - positions[:, parent])
        turned = (into.inv() * own).as_quat(scalar_first=True)
        flips = np.sign(np.sum(turned[1:] * turned[:-1], axis=1))
        turned[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
        local_quaternions[:, body] = turned
    return local_positions, local_quaternions


def add_animation(tree: dict[str, Any], items: Items, name: str, world: RecordedWorld, log: Log) -> None:
    """Add a run, given by its log and the world rebuilt from it, to the nodes and the binary part of a glTF document.

    `tree["accessors"]` is still a dict, by name.
    """
    model, times = world.mujoco, log.times
    channels, samplers = list[dict[str, Any]](), list[dict[str, Any]]()
    nodes = {node["name"]: index for index, node in enumerate(tree["nodes"])}

    def add(name: str, path: str, keys: np.ndarray, values: np.ndarray, *, interpolation: str = "LINEAR") -> None:
        """Add a channel with the (T, n) values of a node at keyframes; the first becomes the node's static value."""
        node = tree["nodes"][nodes[name]]
        _unpack(node)
        node.setdefault(path, values[0].tolist())
        channels.append({"sampler": len(samplers), "target": {"node": nodes[name], "path": path}})
        ends = {"input": _accessor(tree, items, times[keys]), "output": _accessor(tree, items, values[keys])}
        samplers.append(ends | {"interpolation": interpolation})

    (positions, quaternions), every = local_poses(model, log.qpos), np.arange(len(times))
    for body in np.flatnonzero(model.body_jntnum):
        node, turned = body_node(model, int(body)), quaternions[:, body]
        add(node, "translation", every, positions[:, body])
        add(node, "rotation", every, np.roll(turned, -1, axis=1))
    places = [place.name for place in world.model.locations]
    for geom, place in lamps(world.scene).items():
        shines = log.glow == places.index(place)
        changes = np.concatenate([[0], 1 + np.flatnonzero(np.diff(shines))])
        for ending, visible in ((ON, shines), (OFF, ~shines)):
            scales = np.repeat(visible.astype(float)[:, None], 3, axis=1)
            add(geom_node(model, geom) + ending, "scale", changes, scales, interpolation="STEP")
    tree.setdefault("animations", []).append({"name": name, "channels": channels, "samplers": samplers})


def _unpack(node: dict[str, Any]) -> None:
    """Replace the matrix of a node by its position and rotation: an animated node must not have a matrix."""
    if "matrix" in node:
        matrix = np.reshape(node.pop("matrix"), (4, 4)).T
        node["translation"] = matrix[:3, 3].tolist()
        node["rotation"] = Rotation.from_matrix(matrix[:3, :3]).as_quat().tolist()


def _accessor(tree: dict[str, Any], items: Items, values: np.ndarray) -> int:
    """Add an array of (N,) or (N, n) numbers and return the index of its accessor."""
    rows = values.reshape(len(values), -1).astype("<f4")
    items[f"animation {len(items)}"] = rows.tobytes()
    tree["accessors"][f"animation {len(items)}"] = {
        "bufferView": len(items) - 1,
        "componentType": FLOAT,
        "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[rows.shape[1]],
        "count": len(rows),
        "min": rows.min(axis=0).tolist(),
        "max": rows.max(axis=0).tolist(),
    }
    return len(tree["accessors"]) - 1
