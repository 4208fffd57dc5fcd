"""Execution of plans by a robot arm in MuJoCo: in closed loop, with logs that can be checked and shown.

The names in `__init__.pyi` can be imported from here; each is loaded when it is first asked for.

MuJoCo loads an OpenGL backend when it is imported, which fails if MUJOCO_GL names a missing one. Physics needs no
OpenGL, so MuJoCo is then imported without it, and `sim.rendering.opengl` reports the problem when a picture is needed.
"""

import os

import lazy_loader

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

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
