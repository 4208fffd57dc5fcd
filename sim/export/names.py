"""Unique names of the nodes of a glTF file."""

import mujoco

from sim.world.scene import Scene

ROOT = "scene"
"""Name of the root node."""

ON, OFF = " on", " off"
"""Suffixes of the names of a lamp's two nodes; the one that is hidden has the scale 0."""


def body_node(model: mujoco.MjModel, body: int) -> str:
    """Return the name of a body's node: the body's own, if it has one."""
    if body == 0:
        return ROOT
    return str(model.body(body).name) or f"body {body}"


def geom_node(model: mujoco.MjModel, geom: int) -> str:
    """Return the name of a geom's node, which differs from those of bodies: these have no comma."""
    return f"{body_node(model, int(model.geom_bodyid[geom]))}, geom {geom}"


def lamps(scene: Scene) -> dict[int, str]:
    """Return the geoms that glow while a marking location is at work, each with the location's name."""
    model = scene.mujoco
    glows = {model.mat(f"{place.name}_glow").id: place.name for place in scene.model.locations if place.marks}
    return {geom: glows[material] for geom, material in enumerate(model.geom_matid) if material in glows}
