"""A Franka Panda in MuJoCo that carries plans out, watches what it does and leaves a record to check and to film.

The names below can be imported from here; each is loaded when it is first asked for, its types are in `__init__.pyi`.

MuJoCo loads an OpenGL backend as it is imported, and cannot be imported where MUJOCO_GL names one that is missing.
Physics needs none, so it is then imported without; whoever wants a picture is told by `sim.rendering.renderer`.
"""

import os
from importlib import import_module

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

_HOMES = {
    "prefplan.claims": ("Check",),
    "sim.errors": ("LogError", "RenderingError", "RobotError", "SimulationError"),
    "sim.evidence.certificate": ("Certificate", "certify"),
    "sim.evidence.log": ("Log", "read_log"),
    "sim.execution.closed_loop": ("ClosedLoop", "Pursuit"),
    "sim.execution.executor": ("Execution", "execute"),
    "sim.execution.faults": ("Fault", "read_fault"),
    "sim.perception.sensors": ("ExactSensor", "NoisySensor", "ObjectPose", "Sensor"),
    "sim.rendering.overlay": ("Caption", "TaskStatus"),
    "sim.rendering.quality": ("DRAFT", "FINAL", "Quality"),
    "sim.rendering.video": ("render_frame", "render_video"),
    "sim.robots.robot": ("Gripper", "Robot"),
    "sim.simulation.rollout": ("Event", "Rollout", "Step"),
    "sim.simulation.workcell": ("Workcell",),
    "sim.skills.catalogue": ("SKILLS",),
    "sim.skills.skill": ("Skill", "SkillError"),
    "sim.world.randomization": ("Perturbation", "perturbed"),
    "sim.world.scene": ("Scene", "build_scene", "initial_state"),
}
"""Which file defines what this package offers."""

_HOME = {name: home for home, names in _HOMES.items() for name in names}

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
