"""Pictures of a scene, rendered off screen."""

from __future__ import annotations

import copy
import importlib
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import mujoco
import numpy as np

from sim.antialias import smooth_edges
from sim.errors import RenderingError
from sim.materials import Glow, glow_of
from sim.panda import VISIBLE
from sim.scene import AZIMUTH, ELEVATION, Scene

CURE = "install a software renderer: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"
"""What mends a machine without OpenGL (names of Debian's packages)."""

DISTANCE = 3.5
"""From the camera to what it looks at, in halves of the table's longer side."""

NEAREST = 1.9
"""The same at least, so that the arm fits into the picture over a small table, m."""


class Painter:
    """Renders states of one scene; one for a process, closed after use.

    Raises:
        RenderingError: (on construction) there is no OpenGL; the message says what mends it.
    """

    def __init__(self, scene: Scene, *, size: tuple[int, int] = (1280, 720)) -> None:
        """Make the OpenGL context; `size` is (width, height) in pixels."""
        self._scene = scene
        self._model = copy.copy(scene.mujoco)
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = size
        self._data = mujoco.MjData(self._model)
        self._pixels = np.empty((size[1], size[0], 3), dtype=np.uint8)
        self._view = mujoco.MjrRect(0, 0, *size)
        self._camera = camera(scene)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group <= VISIBLE for group in range(mujoco.mjNGROUP)]
        self._option.sitegroup[:] = 0
        try:
            self._gl = _gl_context(*size)
            self._gl.make_current()
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except Exception as failure:
            raise RenderingError(_no_gl(f"{type(failure).__name__}: {failure}")) from failure
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._drawn = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 100)

    def __enter__(self) -> Painter:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Free the OpenGL context, without which Mesa complains when the process ends."""
        self._context.free()
        self._gl.free()

    def frame(self, qpos: np.ndarray, *, glow: Mapping[str, float] | None = None) -> np.ndarray:
        """Return a picture.

        Args:
            qpos: (nq,) positions of the scene's MuJoCo model.
            glow: for marking locations at work, how brightly their lamp glows, 0 .. 1.

        Returns:
            (height, width, 3) uint8.
        """
        for place in self._scene.model.locations:
            if place.marks:
                self._set_glow(place.name, glow_of(place.kind), (glow or {}).get(place.name, 0.0))
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            None,
            self._camera,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._drawn,
        )
        mujoco.mjr_render(self._view, self._drawn, self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._view, self._context)
        return smooth_edges(np.ascontiguousarray(self._pixels[::-1]))

    def _set_glow(self, location: str, glow: Glow, level: float) -> None:
        name = f"{location}_glow"
        material, light = self._model.mat(name).id, self._model.light(name).id
        self._model.mat_rgba[material] = (1 - level) * np.array(glow.off) + level * np.array(glow.on)
        self._model.mat_emission[material] = level
        self._model.light_active[light] = level > 0
        self._model.light_diffuse[light] = level * np.array(glow.light)


def camera(scene: Scene) -> mujoco.MjvCamera:
    """Return the camera: the whole table and the arm above it."""
    view = mujoco.MjvCamera()
    view.lookat = scene.focus
    view.azimuth, view.elevation = AZIMUTH, ELEVATION
    view.distance = max(NEAREST, DISTANCE * scene.span)
    return view


def gl_environment() -> dict[str, str]:
    """Return the environment for a process that renders: EGL unless the user chose otherwise or has a display."""
    environment = dict(os.environ)
    if not environment.get("MUJOCO_GL") and _headless():
        environment["MUJOCO_GL"] = "egl"
    root = str(Path(__file__).parent.parent)
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, [root, environment.get("PYTHONPATH")]))
    return environment


def check_rendering() -> None:
    """Set up rendering in a process of its own, which a faulty driver may end without harm.

    Raises:
        RenderingError: it cannot be done; the message says why and what mends it, in one sentence.
    """
    probe = "from sim.painter import probe; probe()"
    done = subprocess.run([sys.executable, "-c", probe], env=gl_environment(), capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        why = lines[-1] if lines else f"the renderer ended with status {done.returncode}"
        raise RenderingError(_no_gl(why))


def probe() -> None:
    """Set up rendering in the smallest size, or fail as the libraries do."""
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    gl = _gl_context(16, 16)
    gl.make_current()
    context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    context.free()
    gl.free()


def _no_gl(why: str) -> str:
    chosen = os.environ.get("MUJOCO_GL")
    other = f", or unset MUJOCO_GL, which is {chosen!r}" if chosen else ""
    return f"no OpenGL here ({why}); {CURE}{other}"


def _headless() -> bool:
    displays = ("DISPLAY", "WAYLAND_DISPLAY")
    return sys.platform == "linux" and not any(os.environ.get(name) for name in displays)


def _gl_context(width: int, height: int) -> Any:
    """Return a context of the backend that MUJOCO_GL names, else of EGL where there is no display.

    MuJoCo reads that variable once, as it is imported; here it may still be chosen.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    if wanted in ("egl", "osmesa") or (not wanted and _headless()):
        return importlib.import_module(f"mujoco.{wanted or 'egl'}").GLContext(width, height)
    if not hasattr(mujoco, "GLContext"):
        raise RuntimeError("MuJoCo has no renderer")
    return mujoco.GLContext(width, height)
