"""What tests of the moving arm share: skills one after another, rollouts, and what a good one keeps to."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import mujoco
import numpy as np

from sim.perception.grounding import slot_of
from sim.perception.sensors import object_pose, true_poses
from sim.robots.arms.panda import PANDA
from sim.simulation.run import Event, Run
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import perform
from sim.world.randomization import drawn
from sim.world.scene import Scene, initial_state


def perform_all(scene: Scene, *actions: str, seed: int | None = 0) -> Workcell:
    cell = Workcell(scene, initial_state(scene, seed=seed))
    for action in actions:
        perform(cell, action)
    return cell


def displaced(**points: tuple[float, float]) -> Callable[..., tuple[Scene, mujoco.MjData, np.ndarray]]:
    """Return a `drawn` that puts some objects elsewhere on the table."""

    def start(scene: Scene, *given: Any, **options: Any) -> tuple[Scene, mujoco.MjData, np.ndarray]:
        scene, data, bias = drawn(scene, *given, **options)
        for obj, point in points.items():
            data.joint(obj).qpos[:2] = point
        mujoco.mj_forward(scene.mujoco, data)
        return scene, data, bias

    return start


def contacts(events: Iterable[Event]) -> list[Event]:
    """Return the events that tell of a touch that should not be."""
    return [event for event in events if event.kind == "contact"]


def assert_clean(cell: Workcell) -> None:
    """Fail if anything was touched that should not be, or a limit of a joint was passed."""
    assert contacts(cell.events) == []
    recorded = cell.recorder.arrays
    shares = {load: float((recorded[load] / limits).max()) for load, limits in PANDA.load_limits.items()}
    assert max(shares.values()) < 1, shares
    low, high = PANDA.ranges(cell.scene.mujoco).T
    angles = recorded["qpos"][:, PANDA.qpos(cell.scene.mujoco)]
    assert np.minimum(angles - low, high - angles).min() > 0.05


def assert_placed(cell: Workcell, obj: str, location: str) -> None:
    slot = slot_of(cell.scene, true_poses(cell.scene, cell.data), obj)
    assert slot is not None and slot.location == location
    pose = object_pose(cell.scene, cell.data, obj)
    assert np.hypot(*(pose.position - slot.position)[:2]) < 0.002
    assert pose.shape.is_round or abs(np.sin(2 * (pose.yaw - slot.yaw))) < 0.05
    assert cell.held() is None


def assert_good(rollout: Run) -> None:
    """Fail unless a rollout was completed as predicted, without a touch or a limit passed."""
    assert rollout.completed, rollout.reason
    assert all(step.observed == step.predicted for step in rollout.steps)
    assert contacts(rollout.events) == []
    shares = {load: float(share.max()) for load, share in rollout.load_shares.items()}
    assert max(shares.values()) < 1, shares
    arm = rollout.robot.kinematics  # its joints come first in every scene
    low, high = rollout.robot.ranges(arm).T
    angles = rollout.qpos[:, rollout.robot.qpos(arm)]
    assert np.minimum(angles - low, high - angles).min() > 0.05
    assert rollout.placement_error < 0.005
