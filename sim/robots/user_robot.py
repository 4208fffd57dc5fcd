"""A user's own robot: a table in a scenario, and an MJCF beside it."""

import math
from functools import cache, partial

import mujoco
import numpy as np

from prefplan.errors import check_known, prefixed
from prefplan.models.manipulation.surroundings import GripperSetup, RobotSetup, check_point, with_height
from sim.errors import RobotError, SimulationError
from sim.geometry.mjcf import as_utf8
from sim.geometry.mjcf_limits import mjcf_files
from sim.robots.import_mjcf import PREFIX, ImportedArm
from sim.robots.robot import Robot

MAX_OPENING_M = 0.5
"""Largest opening of a gripper, m; larger ones are probably in millimetres."""

MAX_FORCE_N = 500.0
"""Largest force of a gripper: with 2 kN, pads press so deep into objects that these do not lie still."""

OWN_KEYS = ("joints", "tool", "gripper", "home", "velocity", "torque")
"""Keys that a robot of the user's own needs."""

DOWN_COSINE = 0.98
"""Least cosine of the angle between the tool's z axis at home and straight down."""


def user_robot(setup: RobotSetup) -> Robot:
    """Return the robot that a scenario describes; `check_robot` has checked the setup.

    Raises `SimulationError`, which begins with the key, if the MJCF cannot be read, or does not fit the table.
    """
    path = setup.folder / str(setup.mjcf)
    with prefixed("robot.mjcf: ", SimulationError):
        files = mjcf_files(path)
    return _robot(setup, tuple(file.stat().st_mtime_ns for file in files))


@cache
def _robot(setup: RobotSetup, changed: tuple[int, ...]) -> Robot:
    """Return the robot; `changed`, the times at which its files were last written, makes the cache notice changes."""
    path = setup.folder / str(setup.mjcf)
    assert setup.gripper is not None and setup.tool is not None
    arm = ImportedArm(
        setup.name if setup.name != RobotSetup().name else path.stem,
        title=f"of {setup.mjcf}",
        mjcf=partial(mujoco.MjSpec.from_file, as_utf8(path)),
        joints=setup.joints,
        velocity_limits=np.array(setup.velocity),
        torque_limits=np.array(setup.torque),
        acceleration_limits=np.array(setup.acceleration) if setup.acceleration else np.inf,
        home=np.array(setup.home),
        tool=setup.tool,
        gripper=setup.gripper,
    )
    try:
        robot = arm.robot()
    except (RobotError, ValueError, OSError) as error:
        raise SimulationError(f"robot: {path}: {' '.join(_plain(str(error)).split())}") from None
    _check_home(robot)
    return robot


def _check_home(robot: Robot) -> None:
    """Raise SimulationError unless the home pose is in the joints' ranges, with the tool down and the links apart."""
    model = robot.spec().compile()
    data = mujoco.MjData(model)
    for name, value, (low, high) in zip(robot.joints, robot.home, robot.ranges(model), strict=True):
        if not low <= value <= high:
            raise SimulationError(
                f"robot.home: {value:g} is not from {low:g} to {high:g}, the range of {_plain(name)!r}"
            )
    robot.put(data, robot.home, width=robot.gripper.opening_m)
    mujoco.mj_kinematics(model, data)
    if -data.site(robot.tool).xmat[8] < DOWN_COSINE:
        raise SimulationError(f"robot.home: the z axis of the site {_plain(robot.tool)!r} does not point down there")
    if inside := _links_inside_each_other(robot, model):
        one, other = map(_plain, inside)
        raise SimulationError(
            f"robot.home: the links {one!r} and {other!r} are inside each other there; "
            "if they always are, add an `exclude` to `contact` in the MJCF"
        )


def _links_inside_each_other(robot: Robot, model: mujoco.MjModel) -> tuple[str, str] | None:
    """Return the names of two links that overlap at home, the hand open or closed; None if there are none.

    No log of such a robot would pass the checks. Neighbouring links may overlap, and so may the fingers.
    """
    robot.let_links_collide(model)
    is_robot, is_finger = robot.bodies(model)[model.geom_bodyid], robot.fingers(model)
    data = mujoco.MjData(model)
    for width in (robot.gripper.opening_m, 0.0):
        robot.put(data, robot.home, width=width)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        for pair, depth in zip(data.contact.geom, data.contact.dist, strict=True):
            if depth < 0 and is_robot[pair].all() and not is_finger[pair].all():
                one, other = model.geom_bodyid[pair].tolist()
                return str(model.body(one).name), str(model.body(other).name)
    return None


def check_robot(robot: RobotSetup) -> None:
    """Raise `SimulationError` for an invalid pose of the base, or invalid keys of a robot of the user's own."""
    if robot.at is not None:
        with prefixed("", new=SimulationError):
            check_point(robot.at, "robot.at")
        height = with_height(robot.at)[2]
        if height < 0:
            raise SimulationError(f"robot.at: the base is {-height:g} m below the table top; at least 0")
    if not math.isfinite(robot.yaw):
        raise SimulationError(f"robot.yaw: must be a finite number of degrees, not {robot.yaw}")
    _check_own(robot)


def _check_own(robot: RobotSetup) -> None:
    """Raise `SimulationError` if the table of a robot of the user's own lacks a key or has an invalid value."""
    if robot.mjcf is None:
        for key in (*OWN_KEYS, "acceleration"):
            if getattr(robot, key):
                raise SimulationError(f"robot.{key}: needs robot.mjcf, the file of a robot of one's own")
        return
    for key in OWN_KEYS:
        if not getattr(robot, key):
            raise SimulationError(f"robot.{key}: missing; a robot with `mjcf` needs {', '.join(OWN_KEYS)}")
    count = len(robot.joints)
    for key in ("home", "velocity", "torque", "acceleration"):
        values = getattr(robot, key)
        if values and len(values) != count:
            raise SimulationError(
                f"robot.{key}: must have {count} entries, one for each of robot.joints, not {len(values)}"
            )
        if not all(math.isfinite(value) and (value > 0 or key == "home") for value in values):
            wanted = "finite numbers" if key == "home" else "positive numbers"
            raise SimulationError(f"robot.{key}: must be {wanted}, not {list(values)}")
    for joint in robot.joints:
        if robot.joints.count(joint) > 1:
            raise SimulationError(f"robot.joints: {joint!r} is listed twice")
    if robot.gripper is not None:
        _check_gripper(robot.gripper)


def _check_gripper(gripper: GripperSetup) -> None:
    where = "robot.gripper"
    check_known(f"{where}.kind", "kind", gripper.kind, ("parallel", "suction"), SimulationError)
    if not 0 < gripper.force <= MAX_FORCE_N:
        raise SimulationError(f"{where}.force: must be above 0 and at most {MAX_FORCE_N:g} N, not {gripper.force:g}")
    if gripper.kind == "parallel":
        if gripper.open is None:
            raise SimulationError(f"{where}.open: missing; the greatest width between the fingers, m")
        if not 0 <= gripper.closed < gripper.open <= MAX_OPENING_M:
            raise SimulationError(
                f"{where}: 0 <= closed < open <= {MAX_OPENING_M:g} m, not {gripper.closed:g} and {gripper.open:g}"
            )


def _plain(text: str) -> str:
    return text.replace(PREFIX, "")
