"""The record of one execution of a plan: frames, steps, events and measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from prefplan.exact_costs import Number
from prefplan.ledger import Ledger
from prefplan.models.manipulation.model import ManipulationState
from prefplan.plan import Plan
from prefplan.problem import Problem
from sim.robots.robot import Robot

EXCUSED_S = 2.0
"""Time for which contacts of an object are excused after a fault has moved it, s."""

FRAME_RATE_HZ = 30
"""Recorded (and rendered) states per simulated second."""


@dataclass(frozen=True)
class Effort:
    """Time, joint travel and energy of the arm in a part of a simulation.

    Attributes:
        time: s.
        travel: integral of |speed| summed over the arm's joints, rad.
        energy: integral of |torque * speed| summed over the arm's joints, J. The torque is that of the real arm's
            motors: it includes the arm's weight, and braking costs as much as driving.
    """

    time: float = 0.0
    travel: float = 0.0
    energy: float = 0.0

    def __add__(self, other: Effort) -> Effort:
        """Return the sum of both."""
        return Effort(self.time + other.time, self.travel + other.travel, self.energy + other.energy)

    def __sub__(self, other: Effort) -> Effort:
        """Return the difference from an earlier effort."""
        return Effort(self.time - other.time, self.travel - other.travel, self.energy - other.energy)


@dataclass(frozen=True)
class Step:
    """One symbolic action as it was carried out.

    Attributes:
        action: as in the plan, e.g. `transport blue san`.
        start: simulated time at which it began, s.
        end: simulated time at which it ended, s.
        predicted: the state that the model predicts after it.
        observed: the state grounded in an observation after it.
        cost: of the action in the model, in the state in which it began, whether or not it succeeded.
        effort: of the arm.
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


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of a simulation, `FRAME_RATE_HZ` a second, and what is needed to simulate it again.

    Attributes:
        times: (T,) simulated time of each frame, s.
        qpos: (T, nq) positions of the scene's MuJoCo model.
        qvel: (T, nv) velocities.
        glow: (T,) index of the location that marks an object at that time, -1 for none.
        controls: (S, nu) int64, the actuators' commands at each step, in `COMMANDS_PER_UNIT` of their units.
        interventions: (K, 1 + m) number of a step and the state in which it began (`STATE` of the recorder), for every
            step that did not begin in the state in which the previous one ended; the first row is the start.
    """

    times: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    glow: np.ndarray
    controls: np.ndarray
    interventions: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Run(Frames):
    """One execution of a plan.

    Attributes:
        loads: (T, n) greatest absolute values for each arm joint since the frame before, in rad, N m and s: `speeds`,
            `accelerations`, `jerks` of the commanded trajectory, `torques`, and `torque_rates`, low-pass filtered as by
            the arm's controller.
        pad_forces: (T, pads) contact force on each of the gripper's pads, N.
        reason: why the run failed, in one sentence: an action that was not carried out or not observed as predicted, an
            exceeded limit of the arm, or an unwanted contact; None if it did not fail.
        steps: the actions that were carried out, in order.
        events: in order of time.
        sim_seconds: total simulated time.
        wall_seconds: total real time.
        placement_error: largest horizontal distance of a placed object from its slot's centre at the end, m.
        robot: the robot, whose arm has n joints.
        replans: number of new plans after mismatches.
        retries: number of times that an action was tried again and the rest of the plan kept.
        violated: tasks that can no longer be satisfied.
    """

    loads: Mapping[str, np.ndarray]
    pad_forces: np.ndarray
    reason: str | None
    steps: tuple[Step, ...]
    events: tuple[Event, ...]
    sim_seconds: float
    wall_seconds: float
    placement_error: float
    robot: Robot
    replans: int = 0
    retries: int = 0
    violated: tuple[str, ...] = ()

    @property
    def completed(self) -> bool:
        """Whether the run did not fail (`reason`)."""
        return self.reason is None

    @property
    def load_shares(self) -> dict[str, np.ndarray]:
        """(n,) greatest load of each arm joint as a share of its limit, by the loads' names."""
        return {name: self.loads[name].max(axis=0) / limit for name, limit in self.robot.load_limits.items()}

    @property
    def objection(self) -> str | None:
        """Which joint limit the arm exceeded, or what it or its load touched that it should not, or None."""
        for load, shares in self.load_shares.items():
            if shares.max() > 1:
                joint = self.robot.joints[int(shares.argmax())]
                return f"{joint} exceeded a limit: {shares.max():.1%} of its {load.replace('_', ' ')}"
        faults = [event for event in self.events if event.kind == "fault"]
        for touch in (event for event in self.events if event.kind == "contact"):
            moved = {fault.detail.get("object") for fault in faults if 0 <= touch.time - fault.time <= EXCUSED_S}
            if moved.isdisjoint(touch.detail.values()):
                return f"{touch.detail['moving']} touched {touch.detail['other']} at {touch.time:.2f} s"
        return None


def ledger_of(problem: Problem, plan: Plan, steps: Sequence[Step]) -> Ledger:
    """Return the ledger of the actions that were carried out, from the observation after each of them.

    The plan's first state is the first observed one; the plan's relaxations are applied to the observations.
    """
    start = cast(ManipulationState, plan.states[0])
    return Ledger.of(
        problem,
        [step.action for step in steps],
        [step.cost for step in steps],
        [start.label, *(step.observed.label for step in steps)],
        plan.relaxations,
    )
