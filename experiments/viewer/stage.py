"""The scene in the browser: MuJoCo's geoms as viser's meshes (by mjviser), what glows, and mouse events."""

from collections.abc import Callable, Sequence
from typing import Any, cast

import mujoco
import numpy as np
import trimesh
import viser
from mjviser import ViserMujocoScene
from mjviser.conversions import merge_geoms

from experiments.viewer.live_run import LiveRun
from prefplan.models.manipulation.description import Location
from sim.geometry.mjcf import HIDDEN
from sim.world.materials import glow_of
from sim.world.scene import Scene

LIGHT_CD = 0.6
"""Intensity of the light of a location that marks an object, cd: visible beside the scene's other lights."""

PULL_COLOUR = (230, 60, 30)
"""Colour (RGB) of the line from an object to the pointer that pulls it."""

PULL_THICKNESS_M = 0.004
"""Thickness of this line, m."""


class Subtree:
    """Wraps a server so that every node that is added to its scene goes below a root node, such as `/left`.

    Attributes:
        scene: this object, in place of the server's scene.
        nodes: the added nodes, by the name given.
    """

    def __init__(self, server: viser.ViserServer, root: str) -> None:
        """Begin without nodes."""
        self.scene = self
        self.nodes: dict[str, Any] = {}
        self._server, self._root = server, root

    def add_mesh_trimesh(self, name: str, mesh: trimesh.Trimesh, **options: Any) -> Any:
        """Add a mesh, its texture as JPEG: as PNG the wood of the table takes 0.8 s."""
        texture = getattr(getattr(mesh.visual, "material", None), "baseColorTexture", None)
        if texture is not None and texture.mode == "RGB":
            texture.format = "JPEG"
        return self._below(self._server.scene.add_mesh_trimesh)(name, mesh, **options)

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the scene or the server; methods `add_...` add below the root."""
        found = getattr(self._server.scene, name, None) or getattr(self._server, name)
        return self._below(found) if name.startswith("add_") else found

    def _below(self, add: Callable[..., Any]) -> Callable[..., Any]:
        def add_below(name: str, *arguments: Any, **options: Any) -> Any:
            self.nodes[name] = add(self._root + name, *arguments, **options)
            return self.nodes[name]

        return add_below


class Stage:
    """One scene on one server, for all browsers.

    Attributes:
        offset: (3,) of its origin, m.
        root: the node of the whole scene.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        scene: Scene,
        disturbed: Callable[[], LiveRun],
        *,
        root: str = "/left",
        offset: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Add the scene below the node `root`; `disturbed` returns the run whose objects a user clicks and drags."""
        self._disturbed = disturbed
        self.offset = np.array(offset)
        self.root = server.scene.add_frame(root, show_axes=False, position=self.offset)
        self._tree = Subtree(server, root)
        server = cast(viser.ViserServer, self._tree)
        self._server, self._objects = server, [*scene.shapes]
        self._shown: dict[str, Any] | None = None
        # mjviser changes the model that it is given.
        model = scene.with_names()
        model.site_group[:] = HIDDEN
        self._data = mujoco.MjData(model)
        self._places = [place.name for place in scene.model.locations]
        self._lamps = {place.name: _Lamp(server, model, place) for place in scene.model.locations if place.marks}
        self._scene = ViserMujocoScene(server, model, num_envs=1)
        self._scene.camera_tracking_enabled = False
        self._pulled: tuple[str, np.ndarray] | None = None
        self._grip = np.zeros(3)
        self._line = server.scene.add_line_segments(
            "/pull", np.zeros((1, 2, 3)), PULL_COLOUR, thickness=PULL_THICKNESS_M, visible=False
        )
        for name, node in self._tree.nodes.items():
            if name.startswith("/bodies/") and name.split("/")[2] in scene.shapes:
                node.on_drag("left")(self._drag)
                node.on_click(modifier="shift")(self._click)

    def show(self, frame: dict[str, Any]) -> None:
        """Show a frame, see `LiveRun.frames`."""
        if frame is self._shown:
            return
        self._shown = frame
        self._data.qpos[:] = frame["qpos"]
        mujoco.mj_kinematics(self._scene.mj_model, self._data)
        with self._server.atomic():
            self._scene.update_from_mjdata(self._data)
            working = self._places[frame["glow"]] if frame["glow"] >= 0 else None
            for name, lamp in self._lamps.items():
                lamp.shine(name == working)

    def show_pull(self) -> None:
        """Show a line from the object that a user drags to the pointer."""
        pulled = self._pulled
        if pulled is not None:
            self._line.points = np.array([[self._position(pulled[0]), pulled[1]]], dtype=np.float32)
        self._line.visible = pulled is not None

    # viser keeps the events of a drag in order for coroutines only.
    async def _drag(self, event: viser.SceneNodeDragEvent[Any]) -> None:
        pointed = np.array(event.end_position) - self.offset
        if event.phase == "start":
            obj = self._object_at(event.target.batched_positions[event.instance_index or 0])
            self._grip = np.array(event.start_position) - self.offset - self._position(obj)
        elif self._pulled is not None:
            obj = self._pulled[0]
        else:
            return
        self._pulled = None if event.phase == "end" else (obj, pointed - self._grip)
        self._disturbed().pull.target = self._pulled

    async def _click(self, event: viser.SceneNodePointerEvent[Any]) -> None:
        # A node may stand for several objects that look the same.
        places = event.target.batched_positions
        missed_by = np.linalg.norm(np.cross(places + self.offset - event.ray_origin, event.ray_direction), axis=1)
        self._disturbed().inject("knock", self._object_at(places[missed_by.argmin()]))

    def _object_at(self, place: np.ndarray) -> str:
        return min(self._objects, key=lambda obj: float(np.linalg.norm(self._position(obj) - place)))

    def _position(self, obj: str) -> np.ndarray:
        return self._data.body(obj).xpos


class _Lamp:
    """The glow of a location that marks objects: a mesh that changes its colour, and a light."""

    def __init__(self, server: viser.ViserServer, model: mujoco.MjModel, place: Location) -> None:
        """Hide the geoms that glow in the model and add them to the server instead, switched off."""
        name = f"{place.name}_glow"
        geoms = [int(geom) for geom in np.flatnonzero(model.geom_matid == model.material(name).id)]
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        self._glow = glow = glow_of(place.kind)
        self._light = server.scene.add_light_point(
            f"/glow/{place.name}/light",
            color=_pixel(glow.light),
            intensity=0.0,
            position=data.light_xpos[model.light(name).id],
        )
        mesh, body = merge_geoms(model, geoms), data.body(f"{place.name}_base")
        self._mesh = server.scene.add_mesh_simple(
            f"/glow/{place.name}/mesh",
            mesh.vertices,
            mesh.faces,
            color=_pixel(glow.off),
            cast_shadow=False,
            position=body.xpos,
            wxyz=body.xquat,
        )
        model.geom_rgba[geoms, 3] = 0

    def shine(self, lit: bool) -> None:
        self._light.intensity = LIGHT_CD if lit else 0.0
        self._mesh.color = _pixel(self._glow.on if lit else self._glow.off)


def _pixel(colour: tuple[float, ...]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour[:3])
    return red, green, blue
