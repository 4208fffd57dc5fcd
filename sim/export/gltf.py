"""Runs as animations of one scene, in a binary glTF 2.0 file (Khronos Group, ISO/IEC 12113:2022).

Every body of the MuJoCo model is a node in its parent's frame; bodies with joints are animated. The root node rotates
MuJoCo's z axis to glTF's upward y axis. Lengths are in metres; times are simulated seconds.
"""

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import mujoco
import numpy as np
import trimesh
from trimesh.visual.texture import TextureVisuals

from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.export.animation import Items, add_animation, local_poses
from sim.export.geoms import Appearance, appearance_of, solid_of
from sim.export.names import OFF, ON, ROOT, body_node, geom_node, lamps
from sim.export.studio import add_studio
from sim.geometry.mjcf import VISIBLE
from sim.world.materials import glow_of
from sim.world.scene import Scene

BASE = "world"
"""Name of trimesh's base frame, the parent of the root."""


def encode_glb(logs: Mapping[str, Log]) -> bytes:
    """Return a binary glTF file with the scene that the logs of some runs share, and each as an animation of its name.

    Raises `LogError` if the scene of a log cannot be built.
    """
    worlds = {name: RecordedWorld(log) for name, log in logs.items()}
    first = next(iter(worlds.values()))
    stage, looks = _stage(first.scene, next(iter(logs.values())).qpos[:1])

    def animate(items: Items, tree: dict[str, Any]) -> None:
        for name, world in worlds.items():
            add_animation(tree, items, name, world, logs[name])

    def finish(tree: dict[str, Any]) -> None:
        tree["asset"] = {"version": "2.0", "generator": f"prefplan {version('prefplan')}, with trimesh"}
        for material in tree["materials"]:
            # trimesh rounds colours to 8 bits, too coarse for dark colours in linear RGB.
            look = looks[material["name"]]
            material["pbrMetallicRoughness"]["baseColorFactor"] = look.colour
            if any(look.emission):
                material["emissiveFactor"] = look.emission
        add_studio(tree, first.scene)

    return bytes(
        trimesh.exchange.gltf.export_glb(
            stage, include_normals=True, buffer_postprocessor=animate, tree_postprocessor=finish
        )
    )


def _stage(scene: Scene, qpos: np.ndarray) -> tuple[trimesh.Scene, dict[str, Appearance]]:
    """Return the visible geoms of a scene, its bodies posed by (1, nq) positions, and their appearances by name."""
    model, looks = scene.with_names(), {}
    stage = trimesh.Scene(base_frame=BASE)
    stage.graph.update(ROOT, BASE, matrix=trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    positions, rotations = local_poses(model, qpos)
    for body in range(1, model.nbody):
        matrix = _matrix(positions[0, body], rotations[0, body])
        stage.graph.update(body_node(model, body), body_node(model, int(model.body_parentid[body])), matrix=matrix)
    lit = lamps(scene)
    for geom in map(int, np.flatnonzero(model.geom_group <= VISIBLE)):
        if (solid := solid_of(model, geom)) is None:
            continue
        look = appearance_of(model, geom)
        place = lit.get(geom)
        variants = {"": look}
        if place is not None:
            variants = {OFF: look, ON: look.glowing(glow_of(scene.model.location(place).kind).on)}
        for ending, variant in variants.items():
            looks[variant.name] = variant
            name = _add_mesh(stage, model, geom, solid, variant)
            stage.graph.update(
                geom_node(model, geom) + ending,
                body_node(model, int(model.geom_bodyid[geom])),
                matrix=_matrix(model.geom_pos[geom], model.geom_quat[geom]),
                geometry=name,
            )
    return stage, looks


def _add_mesh(stage: trimesh.Scene, model: mujoco.MjModel, geom: int, solid: trimesh.Trimesh, look: Appearance) -> str:
    """Add the mesh of a geom unless another geom has added it, and return its name."""
    mesh = int(model.geom_dataid[geom])
    name = f"{model.mesh(mesh).name if mesh >= 0 else geom_node(model, geom)}, {look.name}"
    if name not in stage.geometry:
        solid = solid.copy()
        solid.visual = TextureVisuals(uv=getattr(solid.visual, "uv", None), material=look.material())
        stage.geometry[name] = solid
    return name


def _matrix(position: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    matrix = trimesh.transformations.quaternion_matrix(quaternion)
    matrix[:3, 3] = position
    return matrix
