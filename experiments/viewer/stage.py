"""The scene in the browser: MuJoCo's geoms as viser's meshes, by mjviser, and the glowing lamps."""

from __future__ import annotations

import copy

import mujoco
import numpy as np
import viser
from mjviser import ViserMujocoScene
from mjviser.conversions import merge_geoms

from experiments.viewer.live_run import Frame
from sim.geometry.mjcf import HIDDEN
from sim.rendering.cameras import Camera
from sim.world.materials import Glow, glow_of
from sim.world.scene import Scene

LIGHT_CD = 0.6
"""Strength of the light of a location at work: visible beside the scene's own lights."""


class Stage:
    """One scene on one server, for every browser that looks at it."""

    def __init__(self, server: viser.ViserServer, scene: Scene) -> None:
        """Set it up, with the camera where videos have it."""
        self._server = server
        self._shown: Frame | None = None
        # mjviser writes into the model that it is given.
        model = copy.copy(scene.mujoco)
        model.site_group[:] = HIDDEN
        self._data = mujoco.MjData(model)
        self._places = [place.name for place in scene.model.locations]
        self._lamps = {}
        for place in scene.model.locations:
            material = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_MATERIAL, f"{place.name}_glow")
            if material >= 0:
                self._lamps[place.name] = _Lamp(server, model, place.name, material, glow_of(place.kind))
        self._scene = ViserMujocoScene(server, model, num_envs=1)
        self._scene.camera_tracking_enabled = False
        view = Camera(scene, "fixed", (1280, 720)).view()
        turn, rise = np.radians([view.azimuth, view.elevation])
        ahead = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        server.scene.set_up_direction("+z")
        server.initial_camera.look_at = view.lookat
        server.initial_camera.position = view.lookat - view.distance * ahead
        server.initial_camera.fov = float(np.radians(model.vis.global_.fovy))

    def show(self, frame: Frame) -> None:
        """Show a frame, unless it is shown already."""
        if frame is self._shown:
            return
        self._shown = frame
        self._data.qpos[:] = frame.qpos
        mujoco.mj_kinematics(self._scene.mj_model, self._data)
        with self._server.atomic():
            self._scene.update_from_mjdata(self._data)
            working = self._places[frame.glow] if frame.glow >= 0 else None
            for name, lamp in self._lamps.items():
                lamp.shine(name == working)


class _Lamp:
    """What glows at one location: meshes that change their colour, and a light."""

    def __init__(self, server: viser.ViserServer, model: mujoco.MjModel, name: str, material: int, glow: Glow) -> None:
        """Hide what glows in the model, and add it to the server instead, switched off."""
        geoms = [int(geom) for geom in np.flatnonzero(model.geom_matid == material)]
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        self._glow = glow
        self._light = server.scene.add_light_point(
            f"/glow/{name}/light",
            color=_pixel(glow.light),
            intensity=0.0,
            position=data.light_xpos[model.light(f"{name}_glow").id],
        )
        self._meshes: list[viser.MeshHandle] = []
        for body in sorted({int(model.geom_bodyid[geom]) for geom in geoms}):
            mesh = merge_geoms(model, [geom for geom in geoms if model.geom_bodyid[geom] == body])
            self._meshes.append(
                server.scene.add_mesh_simple(
                    f"/glow/{name}/{body}",
                    mesh.vertices,
                    mesh.faces,
                    color=_pixel(glow.off),
                    cast_shadow=False,
                    position=data.xpos[body],
                    wxyz=data.xquat[body],
                )
            )
        model.geom_rgba[geoms, 3] = 0
        self._lit = False

    def shine(self, lit: bool) -> None:
        if lit == self._lit:
            return
        self._lit = lit
        self._light.intensity = LIGHT_CD if lit else 0.0
        for mesh in self._meshes:
            mesh.color = _pixel(self._glow.on if lit else self._glow.off)


def _pixel(colour: tuple[float, ...]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour[:3])
    return red, green, blue
