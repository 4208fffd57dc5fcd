"""Check that the robot at home is clear of everything else."""

import copy
from collections.abc import Mapping

import mujoco

from sim.external.user_scene import UserScene
from sim.robots.import_mjcf import PREFIX
from sim.robots.robot import Robot
from sim.world.contacts import set_margins

HOME_CLEARANCE_M = 0.004
"""Least clearance of the robot from everything else at home, with its hand open, m."""


def faults_at_home(
    model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, keys: Mapping[str, str], own: UserScene | None
) -> list[str]:
    """Return a fault for each body that the robot at home would be inside of, or too near to, in the initial state.

    Parts of the robot that never move, such as its base, may touch whatever else never moves. `keys` are the
    scenario's keys by body; `own` is the user's own scene, or None.
    """
    model, data = copy.copy(model), copy.copy(data)
    is_robot = robot.bodies(model)
    set_margins(model, HOME_CLEARANCE_M * is_robot[model.geom_bodyid])
    mujoco.mj_collision(model, data)
    nearest: dict[int, tuple[float, int]] = {}
    for (one, other), distance in zip(model.geom_bodyid[data.contact.geom], data.contact.dist, strict=True):
        if is_robot[one] != is_robot[other]:
            link, body = (one, other) if is_robot[one] else (other, one)
            nearest[int(body)] = min(nearest.get(int(body), (float("inf"), -1)), (float(distance), int(link)))
    return [
        _fault(str(model.body(body).name), str(model.body(link).name).removeprefix(PREFIX), distance, keys, own)
        for body, (distance, link) in nearest.items()
    ]


def _fault(body: str, link: str, distance: float, keys: Mapping[str, str], own: UserScene | None) -> str:
    mm = 1000 * abs(distance)
    how = f"{mm:.1f} mm inside" if distance < 0 else f"only {mm:.1f} mm from"
    enough = "" if distance < 0 else f"; at least {1000 * HOME_CLEARANCE_M:g} mm"
    if body in keys:
        return f"{keys[body]}: the robot's {link} at home would be {how} it{enough}; move it away"
    other = own.words(body) if own is not None and own.holds(body) else f"the {body}"
    return f"robot: its {link} at home would be {how} {other}{enough}"
