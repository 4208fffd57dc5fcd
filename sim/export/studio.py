"""Lights and camera of a scene in a glTF document (with the extension KHR_lights_punctual)."""

from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from sim.export.geoms import linear
from sim.export.names import ROOT
from sim.rendering.cameras import Camera, axes_of
from sim.world.scene import Scene

LIGHTS = "KHR_lights_punctual"

ASPECT = (16, 9)
"""Aspect ratio of the exported camera: that of the videos."""


def add_studio(tree: dict[str, Any], scene: Scene) -> None:
    """Add the scene's lights and the camera of its videos to a glTF document with its nodes."""
    model = scene.mujoco
    directional = model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    lights = list[dict[str, Any]]()
    for light in map(int, np.flatnonzero(directional & (model.light_active != 0))):
        name, diffuse = model.light(light).name, np.array(linear(model.light_diffuse[light]))
        strength = float(diffuse.max())
        node = _looking(model.light_pos[light], model.light_dir[light])
        _add_node(tree, node | {"name": f"{name}, light", "extensions": {LIGHTS: {"light": len(lights)}}})
        # Under pi lux, a white surface appears white in viewers without an exposure setting.
        shines = {"color": (diffuse / strength).tolist(), "intensity": strength * np.pi}
        lights.append({"type": "directional", "name": name} | shines)
    tree.setdefault("extensions", {})[LIGHTS] = {"lights": lights}
    tree.setdefault("extensionsUsed", []).append(LIGHTS)
    view = Camera(scene, "fixed", ASPECT).view()
    _, _, ahead = axes_of(view)
    lens = {"yfov": float(np.radians(model.vis.global_.fovy)), "aspectRatio": ASPECT[0] / ASPECT[1]}
    tree["cameras"] = [{"type": "perspective", "perspective": lens | {"znear": 0.02, "zfar": 30.0}}]
    # Distance to the point about which an interactive viewer should orbit.
    extras = {"distance": float(view.distance)}
    node = _looking(view.lookat - view.distance * ahead, ahead)
    _add_node(tree, node | {"name": "camera", "camera": 0, "extras": extras})


def _looking(position: np.ndarray, ahead: np.ndarray) -> dict[str, Any]:
    """Return the pose of a node whose -z axis points ahead and whose y axis points up as far as possible."""
    back = -np.asarray(ahead) / np.linalg.norm(ahead)
    right = np.cross([0.0, 0.0, 1.0], back)
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-6 else np.array([1.0, 0.0, 0.0])
    rotation = Rotation.from_matrix(np.stack([right, np.cross(back, right), back], axis=1))
    return {"translation": np.asarray(position).tolist(), "rotation": rotation.as_quat().tolist()}


def _add_node(tree: dict[str, Any], node: dict[str, Any]) -> None:
    (root,) = (one for one in tree["nodes"] if one["name"] == ROOT)
    root["children"].append(len(tree["nodes"]))
    tree["nodes"].append(node)
