"""Which OpenGL backends render on this machine, and which one films would be made with."""

from __future__ import annotations

import os
import sys

from experiments.doctor.diagnosis import OK, PROBLEM, WARNING, Diagnosis, in_a_child
from experiments.doctor.mending import installs


def backends() -> list[str]:
    """Return the backends that MuJoCo has on this system."""
    if sys.platform == "darwin":
        return ["cgl"]
    displays = ("DISPLAY", "WAYLAND_DISPLAY")
    return ["egl", "osmesa", *(["glfw"] if any(os.environ.get(name) for name in displays) else [])]


def in_use() -> str:
    """Return the backend that films would be made with, here and now."""
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if chosen:
        return chosen
    return backends()[-1] if "egl" not in backends() or "glfw" in backends() else "egl"


def rendering() -> list[Diagnosis]:
    """Try every backend in a process of its own; the one in use is needed, the others are not."""
    used = in_use()
    tried = {name: try_backend(name) for name in dict.fromkeys([*backends(), used])}
    working = [name for name, (_, works) in tried.items() if works]
    return [_finding(name, text, works, used, working) for name, (text, works) in tried.items()]


def try_backend(name: str) -> tuple[str, bool]:
    """Return who rendered a picture with a backend, or what went wrong, and whether it worked."""
    return in_a_child([sys.executable, "-P", "-m", "experiments.doctor.gl_trial"], {"MUJOCO_GL": name})


def _finding(name: str, text: str, works: bool, used: str, working: list[str]) -> Diagnosis:
    if works:
        return Diagnosis(name, OK, f"renders ({text})" + (", used for films" if name == used else ""))
    if name != used:
        return Diagnosis(name, WARNING, f"optional: does not render ({text})", _install(name))
    what = f"does not render, so that no film can be made ({text})"
    if os.environ.get("MUJOCO_GL") and working:
        return Diagnosis(name, PROBLEM, what, f"export MUJOCO_GL={working[0]}")
    return Diagnosis(name, PROBLEM, what, _install(name))


def _install(name: str) -> str | None:
    return installs(name) if name in ("egl", "osmesa", "glfw") else None
