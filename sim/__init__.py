"""Execution of plans by a robot arm in MuJoCo: in closed loop, with logs that can be checked and shown.

The names in `__init__.pyi` can be imported from here; each is loaded when it is first asked for.

MuJoCo loads an OpenGL backend when it is imported, which fails if MUJOCO_GL names a missing one. Physics needs no
OpenGL, so MuJoCo is then imported without it, and `sim.rendering.opengl` reports the problem when a picture is needed.
"""

import os
import re
from importlib import import_module
from pathlib import Path

try:
    import mujoco  # noqa: F401
except (AttributeError, ImportError, OSError, RuntimeError):
    _wanted = os.environ.pop("MUJOCO_GL", None)
    if _wanted is None:
        raise
    try:
        import mujoco  # noqa: F401
    finally:
        os.environ["MUJOCO_GL"] = _wanted

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")

_HOME = {name: home for home, name in re.findall(r"^from (\S+) import (\w+) as", _STUB, re.MULTILINE)}
"""The module that defines each name."""

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    """Load a name on first access."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(_HOME[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Return the names that are loaded, and those that can be."""
    return sorted({*globals(), *__all__})
