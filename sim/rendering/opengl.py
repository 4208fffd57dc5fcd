"""OpenGL: which backend is used, whether it works here, and how to repair it. Imports nothing beyond MuJoCo."""

import importlib
import os
import subprocess
import sys
from typing import Any

import mujoco

from sim.errors import RenderingError

CURE = "install a software renderer: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"
"""How to repair a machine without OpenGL (names of Debian's packages)."""


def check_rendering() -> None:
    """Raise `RenderingError`, which says why and how to repair it, unless rendering works.

    Rendering is tried in a separate process, which a faulty driver may crash without harm.
    """
    call = f"import sys; sys.path = {sys.path}; from sim.rendering.opengl import probe; probe()"
    done = subprocess.run([sys.executable, "-c", call], capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        why = lines[-1] if lines else f"the renderer ended with status {done.returncode}"
        raise RenderingError(no_gl(why))


def probe() -> None:
    """Create and free a small OpenGL context, or raise whatever the libraries raise."""
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    gl = gl_context(16, 16)
    gl.make_current()
    context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    context.free()
    gl.free()


def no_gl(why: str) -> str:
    """Return the sentence that says why there is no OpenGL, and how to repair that."""
    chosen = os.environ.get("MUJOCO_GL")
    other = f", or unset MUJOCO_GL, which is {chosen!r}" if chosen else ""
    return f"no OpenGL here ({why}); {CURE}{other}"


def gl_backend() -> str:
    """Return the OpenGL backend that MUJOCO_GL names, else `egl` on Linux without a display, else ""."""
    displays = ("DISPLAY", "WAYLAND_DISPLAY")
    headless = sys.platform == "linux" and not any(os.environ.get(name) for name in displays)
    return os.environ.get("MUJOCO_GL", "").lower().strip() or ("egl" if headless else "")


def gl_context(width: int, height: int) -> Any:
    """Return an OpenGL context. MuJoCo reads MUJOCO_GL only when it is imported; this reads it at each call."""
    if gl_backend() in ("egl", "osmesa"):
        return importlib.import_module(f"mujoco.{gl_backend()}").GLContext(width, height)
    if not hasattr(mujoco, "GLContext"):
        raise RuntimeError("MuJoCo has no renderer")
    return mujoco.GLContext(width, height)
