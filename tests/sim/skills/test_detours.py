"""Motions past walls, where every tool path over the wall collides."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from skill_runs import assert_clean, assert_placed, contacts, perform_all
from walls import Box, with_boxes

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.errors import BlockedError
from sim.motion.joint_trajectory import JointTrajectory, sampled
from sim.motion.kinematics import Arm
from sim.motion.planning import EDGE_STEPS_M
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills import transfer
from sim.skills.catalogue import perform
from sim.skills.hand import check_path
from sim.skills.transfer import planned_path
from sim.world.scene import Scene, build_scene, initial_state

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

WALL: dict[str, Box] = {"wall": ((0.6, 0.12, 0.4), (0.2, 0.01, 0.4))}
"""A wall taller than the arm reaches with its hand pointing down; the path leads round its near end."""


@pytest.fixture(scope="module")
def table() -> Scene:
    places = (Location("a", at=(0.5, 0.32)), Location("b", at=(0.5, -0.25)))
    return build_scene(ManipulationModel("home", COSTS, places, (Object("cup", "a"),)))


def test_the_arm_takes_its_load_round_a_wall(table: Scene) -> None:
    cell = Workcell(scene := with_boxes(table, WALL), initial_state(scene, seed=1))
    for action in ("transit a", "grasp cup", "transport cup b", "release cup b"):
        perform(cell, action)
    assert_clean(cell)
    assert_placed(cell, "cup", "b")


def test_a_slow_movement_is_followed_only_if_there_is_no_quicker_one(
    table: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    over = transfer._over

    def slowly(cell: Workcell, ends: Iterable[tuple[np.ndarray, ToolPose]], height: float) -> Iterator[JointTrajectory]:
        for movement, share in zip(over(cell, ends, height), (1.8, 1.2, 1.8), strict=False):
            path = np.vstack([cell.reference, movement.positions])
            curve = CubicSpline(np.linspace(0, movement.seconds, len(path)), path, bc_type="clamped")
            yield sampled(curve, movement.seconds, slower=share * transfer.SLOW_S / movement.seconds)

    monkeypatch.setattr(transfer, "_over", slowly)
    quick = Workcell(table, initial_state(table))
    perform(quick, "transit a")
    assert quick.data.time < transfer.SLOW_S
    monkeypatch.setattr(transfer, "_planned", lambda *_: iter(()))
    slow = Workcell(table, initial_state(table))
    perform(slow, "transit a")
    assert transfer.SLOW_S < slow.data.time < 1.5 * transfer.SLOW_S, "the quickest of them"
    assert_clean(slow)


def test_the_seed_decides_the_way_round(table: Scene) -> None:
    scene = with_boxes(table, WALL)
    goal, _ = Arm(scene.robot).reach([ToolPose.down(scene.slots["a"][0].position + [0.0, 0.0, 0.2], np.pi / 2)])
    cells = [Workcell(scene, initial_state(scene), seed=seed) for seed in (2, 2, 3)]
    first, again, other = (planned_path(cell, goal, clearance=0.006) for cell in cells)
    assert np.array_equal(first, again) and not np.array_equal(first[1], other[1])


@pytest.mark.parametrize("gap", [0.003, 0.007])
def test_a_path_that_begins_near_a_board_keeps_the_distance_that_motions_keep(table: Scene, gap: float) -> None:
    """Motions may come as near as 6 mm, or 1 mm nearer than at the start; planned paths keep 8 mm from what is afar."""
    home = Workcell(table, initial_state(table)).arm.tool(table.robot.home).position

    def beside(hand_to_board: float) -> Workcell:
        board: dict[str, Box] = {"board": ((home[0], home[1] + hand_to_board, home[2]), (0.1, 0.01, 0.1))}
        return Workcell(scene := with_boxes(table, board), initial_state(scene))

    def distance(cell: Workcell, q: np.ndarray) -> float:
        near = cell.collision_checker().distances(q, within=0.05)
        return min((near[pair] for pair in near if pair[1] == "board"), default=np.inf)

    apart = distance(beside(0.15), table.robot.home)
    cell = beside(0.15 - apart + gap)
    assert distance(cell, cell.reference) == pytest.approx(gap, abs=1e-4)
    goal, _ = cell.arm.reach([ToolPose.down(home + [0.0, 0.3, 0.0], 0.0)])
    path = planned_path(cell, goal, clearance=0.008)
    corners = path[1:-1]
    assert len(corners) and min(distance(cell, q) for q in corners) >= min(0.006, gap - 0.001) - 1e-6


def test_a_path_whose_motion_collides_is_planned_again_with_denser_checks(
    table: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[float] = []

    def plan(cell: Workcell, goal: np.ndarray, *, clearance: float, step: float) -> np.ndarray:
        steps.append(step)
        return planned_path(cell, goal, clearance=clearance, step=step)

    def check(cell: Workcell, movement: JointTrajectory, *, clearance: float, touching: bool) -> None:
        if EDGE_STEPS_M[1] not in steps:
            raise BlockedError.on_the_way({"wall"})
        check_path(cell, movement, clearance=clearance, touching=touching)

    monkeypatch.setattr(transfer, "planned_path", plan)
    monkeypatch.setattr(transfer, "check_path", check)
    cell = Workcell(scene := with_boxes(table, WALL), initial_state(scene))
    perform(cell, "transit a")
    assert_clean(cell)
    assert steps == sorted(steps, reverse=True) and steps[-1] == EDGE_STEPS_M[1]


def test_the_fingers_pass_over_an_object_that_they_are_about_to_take(table: Scene) -> None:
    cell, slot = Workcell(table, initial_state(table)), table.slots["a"][0].position
    sides = [ToolPose.down(slot + [x, 0.0, 0.03], 0.0) for x in (-0.12, 0.12)]
    transfer.travel(cell, sides[:1], height=0.3)
    cell.settle()
    cell.touch("cup")
    before = cell.observe("cup").position
    transfer.travel(cell, sides[1:], height=0.0)
    cell.settle()
    assert np.linalg.norm(cell.observe("cup").position - before) < 1e-4
    assert np.linalg.norm(cell.arm.tool(cell.angles).position - sides[1].position) < 0.002


def test_a_place_that_is_boxed_in_names_the_box(table: Scene) -> None:
    lid: dict[str, Box] = {"lid": ((0.5, 0.32, 0.13), (0.1, 0.1, 0.005))}
    cell = Workcell(scene := with_boxes(table, lid), initial_state(scene))
    with pytest.raises(BlockedError, match="the way is blocked by lid") as raised:
        perform(cell, "transit a")
    assert raised.value.by == ("lid",) and len(cell.ending) == 0


def test_a_board_under_the_end_of_a_long_load_is_seen_on_the_way_down() -> None:
    places = (Location("a", at=(0.5, 0.32)), Location("b", at=(0.5, -0.25)))
    rod = Object("rod", "a", kind="box", size=(0.12, 0.03, 0.04))
    scene = build_scene(ManipulationModel("home", COSTS, places, (rod,)))
    slot = scene.slots["b"][0]
    end = slot.position + 0.055 * np.array([-np.sin(slot.yaw), np.cos(slot.yaw), 0.0])
    scene = with_boxes(scene, {"board": ((end[0], end[1], 0.08), (0.01, 0.01, 0.0025))})
    cell = Workcell(scene, initial_state(scene))
    for action in ("transit a", "grasp rod", "transport rod b"):
        perform(cell, action)
    with pytest.raises(BlockedError, match="the way is blocked by board"):
        perform(cell, "release rod b")
    assert_clean(cell)


def test_the_opened_hand_goes_round_what_it_would_push(table: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    move, aside = Arm.move, []

    def straying(arm: Arm, q: np.ndarray, goal: np.ndarray, pose: ToolPose, **options: Any) -> JointTrajectory:
        """Leave the straight line by 3 cm when the hand rises, along the direction in which it closes."""
        here = arm.tool(q)
        if options.get("height") is not None or pose.position[2] < here.position[2] + 0.05:
            return move(arm, q, goal, pose, **options)
        midway = here.shifted(0.03 * here.rotation[:, 1])
        between, _ = arm.reach([midway], near=q)
        aside.append(midway)
        one, other = move(arm, q, between, midway, seconds=1.0), move(arm, between, goal, pose)
        positions, velocities = [one.positions, other.positions], [one.velocities, other.velocities]
        return JointTrajectory(np.vstack(positions), np.vstack(velocities))

    cell = perform_all(table, "transit a", "grasp cup", "transport cup b")
    begun = len(cell.recorder.arrays["times"])
    monkeypatch.setattr(Arm, "move", straying)
    perform(cell, "release cup b")
    assert aside
    pressed = cell.recorder.arrays["pad_forces"][begun:] > 0
    let_go = int(np.flatnonzero(pressed.all(axis=1))[-1]) + 2  # the pads may leave it one after the other
    assert not pressed[let_go:].any()
    assert_placed(cell, "cup", "b")
    assert_clean(cell)


def test_near_the_base_the_fingers_come_down_beside_an_object_and_not_on_it() -> None:
    places = Location("a", at=(0.321, -0.032)), Location("near", at=(0.159, 0.195))
    brick = Object("brick", "a", kind="box", size=(0.042, 0.063, 0.083), mass=1.3)
    scene = build_scene(ManipulationModel("home", COSTS, places, (brick,)))
    there = "transit a", "grasp brick", "transport brick near", "release brick near"
    cell = perform_all(scene, *there, "grasp brick", seed=None)
    assert cell.held() == "brick" and contacts(cell.events) == []
