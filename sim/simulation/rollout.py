"""What one execution of a plan leaves behind: states to replay, steps, events and measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from prefplan.exact_costs import Number
from prefplan.models.manipulation.model import ManipulationState
from sim.robots.robot import Robot
from sim.simulation.effort import Effort

FRAME_RATE = 30
"""Recorded (and rendered) states a simulated second."""


@dataclass(frozen=True)
class Step:
    """One symbolic action as it was carried out.

    Attributes:
        action: as in the plan, e.g. `transport blue san`.
        start: simulated time at which it began, s.
        end: simulated time at which it ended, s.
        predicted: the state the model expects afterwards.
        observed: the state read back from the simulation afterwards.
        cost: what the model charges for the action where it was begun, whether or not it works out.
        effort: what it took of the arm.
    """

    action: str
    start: float
    end: float
    predicted: ManipulationState
    observed: ManipulationState
    cost: Number
    effort: Effort = Effort()


@dataclass(frozen=True)
class Event:
    """An event of a run: a grasp with its force, a correction, a mismatch.

    Attributes:
        time: simulated time, s.
        kind: one word, e.g. `grasped`, `placed`, `mismatch`, or `contact`: an unwanted contact.
        detail: measured values by name, JSON-ready.
    """

    time: float
    kind: str
    detail: dict[str, Any]


@dataclass(frozen=True)
class Rollout:
    """One execution of a plan.

    Attributes:
        completed: whether every action was carried out and observed as predicted.
        reason: why not, in one sentence; None when completed.
        steps: the actions that were carried out, in order.
        events: in order of time.
        times: (T,) s, when each recorded state was taken; `FRAME_RATE` a second.
        qpos: (T, nq) recorded positions of the scene's MuJoCo model.
        glow: (T,) index into the model's locations of the marking location at work, -1 for none.
        speeds: (T, n) greatest speed of each arm joint since the frame before, rad/s.
        torques: (T, n) greatest torque of each arm joint since the frame before, N m.
        margins: (T, n) least distance of each arm joint from an end of its range since the frame before, rad; negative
            beyond it.
        pad_forces: (T, 2) with which the left and the right pad were pressed, N.
        sim_seconds: simulated time in all.
        wall_seconds: real time in all.
        placement_error: largest horizontal distance of a placed object from its slot's centre at the end, m.
        robot: whose arm has the n joints.
    """

    completed: bool
    reason: str | None
    steps: tuple[Step, ...]
    events: tuple[Event, ...]
    times: np.ndarray
    qpos: np.ndarray
    glow: np.ndarray
    speeds: np.ndarray
    torques: np.ndarray
    margins: np.ndarray
    pad_forces: np.ndarray
    sim_seconds: float
    wall_seconds: float
    placement_error: float
    robot: Robot

    @property
    def speed_share(self) -> np.ndarray:
        """(n,) greatest speed of each arm joint, as a share of its limit."""
        return self.speeds.max(axis=0) / self.robot.velocity_limits

    @property
    def torque_share(self) -> np.ndarray:
        """(n,) greatest torque of each arm joint, as a share of its limit."""
        return self.torques.max(axis=0) / self.robot.torque_limits

    @property
    def joint_margin(self) -> np.ndarray:
        """(n,) least distance of each arm joint from an end of its range, rad."""
        return self.margins.min(axis=0)
