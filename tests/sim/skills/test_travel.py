"""Motions of the arm over and behind towers, far out and all round, without contact, within its limits."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from skill_runs import assert_clean, assert_good, assert_placed, contacts, perform_all

from prefplan.models.manipulation.model import Fixture, Location, ManipulationModel, Object
from sim.capability.feasibility import Feasibility
from sim.capability.place_check import PlaceCheck
from sim.errors import BlockedError
from sim.execution.executor import execute
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import perform
from sim.skills.hand import BLEND_M, PATH_CLEARANCE_M, move_tool, straight_move
from sim.skills.transfer import travel
from sim.world.scene import Scene, build_scene, initial_state

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

THERE_AND_BACK = (
    "transit a, grasp cup, transport cup b, release cup b, transit a, transit b, grasp cup, transport cup a, "
    "release cup a"
).split(", ")


def table(*locations: Location, objects: tuple[Object, ...] = (Object("cup", "a"),)) -> Scene:
    return build_scene(ManipulationModel("home", COSTS, locations, objects))


def touched(cell: Workcell, q: np.ndarray, **settings: float) -> list[str]:
    """Return what the robot would touch."""
    return sorted({other for _, other in cell.touches(q, **settings)})


def tower(height: int, at: tuple[float, float]) -> tuple[tuple[Location, ...], tuple[Object, ...]]:
    """Return the locations of a tower and the blocks it is made of."""
    places = [Location("t0", at=at)]
    places += [Location(f"t{i}", on=(f"t{i - 1}",)) for i in range(1, height)]
    return tuple(places), tuple(Object(f"block{i}", place.name) for i, place in enumerate(places))


def polar(radius: float, bearing: float) -> tuple[float, float]:
    return float(radius * np.cos(bearing)), float(radius * np.sin(bearing))


@pytest.mark.parametrize("distance", [0.22, 0.235, 0.25, 0.26, 0.29])
def test_near_the_base_an_object_is_taken_and_put_back_without_long_movements(distance: float) -> None:
    scene = table(Location("a", at=(distance, 0.0)), Location("b", at=(0.5, 0.2)))
    cell = Workcell(scene, initial_state(scene, seed=1))
    for ahead, actions in ("release cup b", THERE_AND_BACK[:4]), ("release cup a", THERE_AND_BACK[6:]):
        for action in actions:
            began = cell.data.time
            perform(cell, action, ahead=[ahead])
            assert cell.data.time - began < 8.0, action
    assert contacts(cell.events) == []
    assert_placed(cell, "cup", "a")


def test_the_hand_is_lowered_straight_where_joints_turn_fast() -> None:
    scene = table(Location("a", at=(0.5, 0.3)))
    start = initial_state(scene, seed=1)
    start.qpos[scene.robot.qpos(scene.mujoco)] = [0.832, 0.250, -1.763, -2.627, -2.669, 3.723, 2.596]
    cell = Workcell(scene, start)
    low = cell.arm.tool(cell.reference).shifted([0.0, 0.0, -0.12])
    move_tool(cell, low)
    cell.settle()
    assert cell.arm.tool(cell.angles).position == pytest.approx(low.position, abs=0.001)


def test_the_arm_comes_to_rest_first_where_its_movement_ends_too_near_to_a_wall_for_a_path() -> None:
    wall = Fixture("wall", "box", at=(0.5, 0.3, 0.2), size=(0.4, 0.02, 0.4))
    scene = build_scene(
        ManipulationModel("home", COSTS, (Location("a", at=(0.4, -0.3)),), (Object("cup", "a"),), fixtures=(wall,))
    )
    cell = Workcell(scene, initial_state(scene))
    beside = ToolPose.down(np.array([0.5, 0.2, 0.25]), 0.0)
    travel(cell, [beside], height=0.25)
    cell.settle()
    for _ in range(5):
        q = straight_move(cell, beside, seconds=0.0).positions[-1]
        near = cell.collision_checker().distances(q, within=0.1)
        beside = beside.shifted([0.0, min(near[pair] for pair in near if "wall" in pair[1]) - 0.004, 0.0])
    move_tool(cell, beside, within=BLEND_M)
    assert len(cell.ending)
    aside = beside.shifted([-0.2, -0.01, 0.0])
    travel(cell, [aside], height=0.25)
    cell.settle()
    assert cell.arm.tool(cell.angles).position == pytest.approx(aside.position, abs=0.001)
    assert_clean(cell)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "b"),
    [
        pytest.param(polar(0.34, 2.5), polar(0.34, -2.5), id="round the base, near"),
        pytest.param(polar(0.79, 2.5), polar(0.79, -2.5), id="round the base, far"),
        pytest.param((0.33, 0.0), (0.79, 0.0), id="from the nearest place to the farthest"),
    ],
)
def test_the_arm_reaches_all_round_near_and_far(a: tuple[float, float], b: tuple[float, float]) -> None:
    assert_clean(perform_all(table(Location("a", at=a), Location("b", at=b)), *THERE_AND_BACK))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "at", "b"),
    [
        pytest.param(6, (0.50, 0.0), (0.48, -0.2), id="between"),
        pytest.param(4, (0.45, 0.0), (0.62, 0.0), id="before the goal"),
        pytest.param(6, (0.60, 0.0), (0.45, 0.0), id="behind the goal"),
    ],
)
def test_a_tower_is_passed_over(height: int, at: tuple[float, float], b: tuple[float, float]) -> None:
    places, blocks = tower(height, at)
    scene = table(Location("a", at=(0.48, 0.2)), Location("b", at=b), *places, objects=(Object("cup", "a"), *blocks))
    cell = perform_all(scene, *THERE_AND_BACK[:6])
    assert_clean(cell)
    for block in blocks:
        slot = scene.slots[block.start][0]
        assert cell.data.body(block.name).xpos[:2] == pytest.approx(slot.position[:2], abs=0.008)


def test_a_place_right_behind_a_tower_is_reached_with_a_tilted_hand() -> None:
    places, blocks = tower(5, (0.45, 0.0))
    scene = table(
        Location("a", at=(0.4, 0.3)), Location("b", at=(0.6, 0.0)), *places, objects=(Object("cup", "a"), *blocks)
    )
    assert Feasibility(scene).check("cup", "b") == PlaceCheck("cup", "b")
    assert_good(execute(scene, THERE_AND_BACK, seed=1))


@pytest.mark.parametrize("at", [(0.86, 0.0), (0.3, 0.81)])
def test_places_that_the_hand_reaches_only_tilted_are_used(at: tuple[float, float]) -> None:
    scene = table(Location("a", at=at), Location("b", at=(0.5, 0.2)))
    assert [Feasibility(scene).check("cup", place).reason for place in "ab"] == [None, None]
    assert_good(execute(scene, [*THERE_AND_BACK[:4], "grasp cup", "transport cup a", "release cup a"], seed=1))


def test_a_hand_that_starts_below_an_obstacle_goes_up_first() -> None:
    places, blocks = tower(4, (0.50, 0.0))
    scene = table(Location("a", at=(0.48, 0.17)), *places, objects=(Object("cup", "t3"), *blocks[:3]))
    cell = perform_all(scene, "transit a")
    low = scene.slots["a"][0].position + [0.0, 0.0, 0.03]
    cell.follow(cell.arm.move(cell.reference, *cell.arm.reach(ToolPose.down(low, np.pi / 2).symmetric_poses())))
    perform(cell, "transit t0")
    assert cell.data.site("tcp").xpos[:2] == pytest.approx([0.50, 0.0], abs=0.003)
    assert_clean(cell)


def test_a_tall_load_is_carried_over_towers() -> None:
    places, blocks = tower(4, (0.50, 0.0))
    others = (Location("a", at=(0.48, 0.2)), Location("b", at=(0.48, -0.2)), Location("b1", on=("b",)))
    objects = (*blocks, Object("cup", "a"), Object("under", "b"))
    cell = perform_all(table(*places, *others, objects=objects), "transit t3", "grasp block3", "transport block3 b1")
    assert_clean(cell)
    perform(cell, "release block3 b1")
    assert_clean(cell)


def test_what_stands_everywhere_blocks_the_way() -> None:
    scene = table(Location("a", at=(0.48, 0.2)), Location("b", at=(0.48, -0.2)))
    cell = perform_all(scene, "transit a")
    cell.data.joint("cup").qpos[:3] = cell.data.site("tcp").xpos + [0.0, -0.40, 0.10]
    mujoco.mj_forward(scene.mujoco, cell.data)
    with pytest.raises(BlockedError, match="the way is blocked by cup") as raised:
        travel(cell, [ToolPose.down(cell.data.site("tcp").xpos + [0.0, -0.40, 0.0], np.pi / 2)], height=0.1)
    assert raised.value.by == ("cup",)


def test_what_lies_against_a_finger_does_not_hold_the_hand_back() -> None:
    scene = table(Location("a", at=(0.48, 0.2)), Location("b", at=(0.48, -0.2)))
    cell = perform_all(scene, "transit a")
    low = np.array([0.48, 0.0, 0.0225])
    cell.follow(cell.arm.move(cell.reference, *cell.arm.reach(ToolPose.down(low, np.pi / 2).symmetric_poses())))
    finger = cell.data.body("left_finger").xpos
    beside = low + [0.0, np.sign(finger[1]) * (abs(finger[1]) + 0.025 + scene.shapes["cup"].half[1] + 0.002), 0.0]
    cell.data.joint("cup").qpos[:] = [*beside, 1, 0, 0, 0]
    mujoco.mj_forward(scene.mujoco, cell.data)
    assert touched(cell, cell.reference, clearance=PATH_CLEARANCE_M) == ["cup"]
    travel(cell, [ToolPose.down(np.array([0.48, -0.2, 0.15]), np.pi / 2)], height=0.12)
    assert cell.data.body("cup").xpos == pytest.approx(beside, abs=0.001)


def test_foresight_keeps_a_clearance_and_leaves_the_scene_alone() -> None:
    scene = table(Location("a", at=(0.50, 0.0)))
    cell = perform_all(scene)
    before = cell.data.qpos.copy()
    top = float(cell.data.body("cup").xpos[2] + scene.shapes["cup"].half[2])
    tips = 0.0102
    q, _ = cell.arm.reach(ToolPose.down(np.array([0.50, 0.0, top + tips + 0.004]), 0.0).symmetric_poses())
    assert touched(cell, q, width=0.0) == []
    assert touched(cell, q, width=0.0, clearance=0.006) == ["cup"]
    assert touched(cell, q, width=0.0) == []
    assert (cell.data.qpos == before).all() and (scene.mujoco.geom_margin == 0).all()


def test_the_arms_own_links_are_in_each_others_way() -> None:
    scene = build_scene(ManipulationModel("home", COSTS, (Location("a", at=(0.5, 0.0)),), ()))
    cell = perform_all(scene)
    assert touched(cell, scene.robot.home) == touched(cell, scene.robot.home, width=0.0, clearance=0.006) == []
    folded = np.array([0.0, 0.0, 0.0, -3.05, 0.0, 0.3, 0.78])
    assert {"the robot's hand", "the robot's link7"} <= set(touched(cell, folded))


def test_a_pyramid_is_built_and_a_neighbour_on_the_same_level_carries_nothing() -> None:
    base = [Location(f"b{i}", at=(0.5, 0.062 * (1 - i))) for i in range(3)]
    upper = Location("m1", on=("b0", "b1")), Location("m2", on=("b1", "b2")), Location("t", on=("m1", "m2"))
    starts = Location("pool1", at=(0.42, 0.33)), Location("pool2", at=(0.42, -0.33))
    objects = (
        *(Object(f"k{place.name}", place.name) for place in (*base, upper[0])),
        Object("k2", "pool1"),
        Object("top", "pool2"),
    )
    moves = "transit pool1, grasp k2, transport k2 m2, release k2 m2, transit pool2, grasp top, transport top t"
    cell = perform_all(table(*base, *upper, *starts, objects=objects), *moves.split(", "), "release top t")
    assert_clean(cell)
    for obj, place in (("k2", "m2"), ("top", "t")):
        assert_placed(cell, obj, place)


def test_another_placement_is_chosen_where_the_object_is_not_in_the_hand_as_foreseen() -> None:
    walls = (
        Fixture("near", "box", at=(0.266, 0.247, 0.175), size=(0.08, 0.08, 0.35), yaw=62),
        Fixture("far", "box", at=(0.329, 0.062, 0.15), size=(0.05, 0.05, 0.3), yaw=21),
    )
    can = Object("can", "here", kind="cylinder", size=(0.058, 0.068), mass=0.0225)
    places = Location("here", at=(0.15, -0.34)), Location("there", at=(0.489, 0.108))
    scene = build_scene(ManipulationModel("home", COSTS, places, (can,), fixtures=walls))
    assert_good(execute(scene, ["transit here", "grasp can", "transport can there", "release can there"], seed=1))
