"""A Franka Panda in MuJoCo that carries plans out.

MuJoCo loads an OpenGL backend as it is imported, and cannot be imported where MUJOCO_GL names one that is missing.
Physics needs none, so it is then imported without; whoever wants a picture is told by `sim.rendering.renderer`.
"""

import os

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
