"""Scenes with boxes that stand in the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import mujoco

from sim.world.scene import Scene

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Centre and half lengths, m."""


def with_boxes(scene: Scene, boxes: Mapping[str, Box]) -> Scene:
    """Return a scene with boxes that nothing moves, by the names of their bodies."""
    spec = scene.spec.copy()
    for name, (centre, half) in boxes.items():
        body = spec.worldbody.add_body(name=name, pos=centre)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half)
    return replace(scene, spec=spec, mujoco=spec.compile())
