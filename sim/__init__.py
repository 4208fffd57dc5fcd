"""A Franka Panda in MuJoCo that carries plans out, watches what it does and leaves a record to check and to show.

The names in `__init__.pyi` can be imported from here; each is loaded when it is first asked for.

MuJoCo loads an OpenGL backend as it is imported, and cannot be imported where MUJOCO_GL names one that is missing.
Physics needs none, so it is then imported without; whoever wants a picture is told by `sim.rendering.opengl`.
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
"""Which file defines what this package offers."""

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    """Load what is asked for."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(_HOME[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Return what there is and what can be loaded."""
    return sorted({*globals(), *__all__})
