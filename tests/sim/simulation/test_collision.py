"""Collision checks along paths: no body is missed between two checks, and intended contacts are no collisions."""

from __future__ import annotations

import copy
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from walls import with_boxes

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.geometry.mjcf import solid_geoms
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import true_poses
from sim.simulation.collision import CollisionChecker
from sim.world.contacts import set_margins
from sim.world.scene import Scene, build_scene, initial_state

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

SWEEP = np.array([[-1.0, 0.2, 0.0, -2.2, 0.0, 2.4, 0.8], [1.0, 0.2, 0.0, -2.2, 0.0, 2.4, 0.8]])
"""The hand passes from right to left, 60 cm in front of the base and 15 cm above the table."""


@pytest.fixture(scope="module")
def bare() -> Scene:
    return build_scene(ManipulationModel("home", COSTS, (Location("a", at=(0.4, 0.45)),), ()))


@pytest.fixture(scope="module")
def blocks() -> Scene:
    places = (Location("a", at=(0.5, 0.0)), Location("a1", on=("a",)), Location("b", at=(0.5, 0.2)))
    return build_scene(ManipulationModel("home", COSTS, places, (Object("low", "a"), Object("high", "a1"))))


def checker(scene: Scene) -> CollisionChecker:
    made, data = CollisionChecker(scene), initial_state(scene)
    made.see(data, true_poses(scene, data))
    return made


def board(y: float, thickness: float) -> dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Return a board on edge across the path of the fingertips, 1 cm higher than their path."""
    return {"board": ((0.6, y, 0.05), (0.15, thickness / 2, 0.14))}


@pytest.mark.parametrize("thickness", [0.005, 0.001])
def test_no_thin_board_is_tunnelled(bare: Scene, thickness: float) -> None:
    coarse = []
    for y in np.random.default_rng(5).uniform(-0.3, 0.3, 12):
        check = checker(with_boxes(bare, board(y, thickness)))
        assert check.blockers(SWEEP, clearance=0.0) == {"board"}
        coarse.append(set().union(*(check.touches(q) for q in np.linspace(*SWEEP, 5))))
    assert set() in coarse  # with long steps the board is missed


@pytest.mark.parametrize(("clearance", "longest"), [(0.006, 0.012), (0.0015, 0.008)])
def test_steps_are_as_short_as_said(
    bare: Scene, clearance: float, longest: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plate = {"plate": ((0.56, 0.0, 0.086), (0.44, 0.9, 0.086))}
    check, seen = checker(with_boxes(bare, plate)), []
    met = CollisionChecker._met
    monkeypatch.setattr(CollisionChecker, "_met", lambda *args: seen.append(check._data.geom_xpos.copy()) or met(*args))
    assert check.blockers(SWEEP, clearance=clearance) == set()
    on_path = np.array(seen[1:])  # the first is the end of the path
    moved = np.linalg.norm(np.diff(on_path, axis=0), axis=2).max(axis=1)
    assert longest / 3 < np.median(moved[moved > 0]) and moved.max() <= longest


def test_all_links_but_adjacent_ones_collide(blocks: Scene) -> None:
    check, data, robot = checker(blocks), initial_state(blocks), blocks.robot
    model = copy.copy(blocks.mujoco)
    robot.let_links_collide(model)
    moves = robot.bodies(model) & (model.body_weldid > 0)
    set_margins(model, np.where(moves[model.geom_bodyid], 0.006, 0.0))
    links = [model.body(int(body)).name for body in np.flatnonzero(robot.bodies(model))]
    adjacent, seen = {tuple(model.body(body).name for body in pair) for pair in check._adjacent}, set()
    for q in np.random.default_rng(1).uniform(*robot.ranges(model).T, (100, 7)):
        data.qpos[robot.qpos(model)] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        pairs = np.sort(model.geom_bodyid[data.contact.geom], axis=1).tolist()
        met = {tuple(model.body(body).name for body in pair) for pair in pairs}
        met = {pair for pair in met if set(pair) <= set(links)}
        touches = {
            tuple(name.removeprefix("the robot's ") for name in pair) for pair in check.touches(q, clearance=0.006)
        }
        own = {tuple(sorted(pair, key=links.index)) for pair in touches if pair[1] in links}
        assert own == met - adjacent
        seen |= met
    assert seen & adjacent and len(seen - adjacent) > 5


def test_what_stands_against_the_base_blocks_no_motion(blocks: Scene) -> None:
    check, data = CollisionChecker(blocks), initial_state(blocks)
    poses = true_poses(blocks, data)
    beside = poses["low"].position * [0.0, 0.0, 1.0] + [0.08, 0.03, 0.0]
    check.see(data, {**poses, "low": replace(poses["low"], position=beside)})
    assert not check.touches(blocks.robot.home, clearance=0.006)
    assert not check.blockers(SWEEP, clearance=0.006)
    at_base = np.array([0.0, 1.0, 0.0, -2.9, 0.0, 3.5, 0.8])
    assert ("the robot's link6", "the robot's link0") in check.touches(at_base)


@pytest.mark.parametrize(
    ("part", "distance", "there", "on_path"),
    [("link7", 0.0022, True, True), ("link7", 0.0032, True, False), ("left_finger", 0.0022, False, False)],
)
def test_links_keep_farther_away_than_fingers_most_of_all_where_a_movement_ends(
    part: str, distance: float, there: bool, on_path: bool
) -> None:
    cube = Object("cube", "a", size=(0.03,))
    scene = build_scene(ManipulationModel("home", COSTS, (Location("a", at=(0.4, 0.45)),), (cube,)))
    data, model, q = initial_state(scene), scene.mujoco, SWEEP[0]
    scene.robot.put(data, q, width=0.03)
    mujoco.mj_kinematics(model, data)
    own, geom = solid_geoms(model, part), int(solid_geoms(model, "cube")[0])

    def gap() -> float:
        mujoco.mj_kinematics(model, data)
        return min(mujoco.mj_geomDistance(model, data, int(one), geom, 1.0, None) for one in own)

    outward = np.array([np.cos(q[0]), np.sin(q[0]), 0.0])
    place = data.joint("cube").qpos
    place[:3] = data.geom_xpos[own].mean(axis=0) + 0.3 * outward
    while gap() > distance + 0.0002:
        place[:3] -= (gap() - distance) / 2 * outward
    assert gap() > distance - 0.0002
    check = CollisionChecker(scene)
    check.see(data, true_poses(scene, data))
    pair = f"the robot's {part}", "cube"
    assert (pair in check.touches(q, clearance=0.0015)) == there
    assert check.blockers(np.array([q, q]), clearance=0.0015) == ({"cube"} if on_path else set())
    assert pair not in check.touches(q)


def test_a_load_that_hangs_lower_than_the_fingers_is_in_the_way() -> None:
    places = (Location("a", at=(0.4, 0.45)), Location("b", at=(0.4, -0.45)))
    rod = Object("rod", "a", kind="box", size=(0.03, 0.12, 0.04))
    scene = build_scene(ManipulationModel("home", COSTS, places, (rod,)))
    scene = with_boxes(scene, {"post": ((0.55, 0.0, 0.087), (0.04, 0.004, 0.087))})
    data = initial_state(scene)
    scene.robot.put(data, SWEEP[0], width=0.03)
    mujoco.mj_kinematics(scene.mujoco, data)
    data.joint("rod").qpos[:3] = data.site("tcp").xpos
    mujoco.mj_kinematics(scene.mujoco, data)
    check = CollisionChecker(scene)
    check.see(data, true_poses(scene, data), handled="rod")
    assert check.blockers(SWEEP, clearance=0.0) == set()
    check.see(data, true_poses(scene, data), handled="rod", held=True)
    assert check.blockers(SWEEP, clearance=0.0) == {"post"}


def test_a_load_may_touch_what_carries_it_where_it_is_put_down(blocks: Scene) -> None:
    data, arm = initial_state(blocks), Arm(blocks.robot)
    lying = data.body("high").xpos.copy()
    above, below = (arm.reach([ToolPose.down(lying + [0.0, 0.0, up], 0.0)])[0] for up in (0.12, -0.004))
    blocks.robot.put(data, above, width=0.04)
    data.joint("high").qpos[2] += 0.12
    mujoco.mj_kinematics(blocks.mujoco, data)
    check = CollisionChecker(blocks)
    check.see(data, true_poses(blocks, data), handled="high", held=True)
    assert check.blockers(np.array([above, below]), clearance=0.0015) == set()
    assert check.blockers(np.array([above, below, above]), clearance=0.0015) == {"low"}


def test_a_load_may_touch_the_floor_of_a_bin_but_not_its_wall(blocks: Scene) -> None:
    spec, box = blocks.spec.copy(), mujoco.mjtGeom.mjGEOM_BOX
    body = spec.worldbody.add_body(name="bin", pos=(0.5, 0.2, 0.0))
    body.add_geom(type=box, size=(0.06, 0.06, 0.005), pos=(0.0, 0.0, 0.005))
    body.add_geom(type=box, size=(0.06, 0.005, 0.009), pos=(0.0, 0.08, 0.009))
    scene = replace(blocks, spec=spec, mujoco=spec.compile())
    arm, inside = Arm(scene.robot), np.array([0.5, 0.2, 0.01 + scene.shapes["high"].half[2]])
    for outside, met in (([0.0, 0.0, 0.15], set()), ([0.0, 0.2, 0.01], {"bin"})):
        data = initial_state(scene)
        path = np.array([arm.reach([ToolPose.down(inside + off, 0.0)])[0] for off in (outside, [0.0, 0.0, 0.0])])
        scene.robot.put(data, path[0], width=0.04)
        data.joint("high").qpos[:3] = inside + outside
        mujoco.mj_kinematics(scene.mujoco, data)
        check = CollisionChecker(scene)
        check.see(data, true_poses(scene, data), handled="high", held=True)
        assert check.blockers(path, clearance=0.0015) == met


@pytest.mark.parametrize(
    "end",
    [
        pytest.param((0.0, 0.052, 0.144), id="in a board above"),
        pytest.param((0.0, 0.04, 0.119), id="with a board in its middle"),
        pytest.param((0.0, 0.066, 0.12), id="deep in a wall"),
        pytest.param((0.0, 0.0695, 0.12), id="a little in a wall, in the air"),
    ],
)
def test_a_load_may_not_end_in_what_does_not_carry_it(end: tuple[float, float, float]) -> None:
    places = (Location("a", at=(0.4, 0.45)), Location("b", at=(0.5, 0.2)))
    rod = Object("rod", "a", kind="box", size=(0.03, 0.12, 0.04))
    plain = build_scene(ManipulationModel("home", COSTS, places, (rod,)))
    spec, box = plain.spec.copy(), mujoco.mjtGeom.mjGEOM_BOX
    body = spec.worldbody.add_body(name="shelf", pos=(0.5, 0.2, 0.0))
    body.add_geom(type=box, size=(0.06, 0.06, 0.005), pos=(0.0, 0.0, 0.005))
    body.add_geom(type=box, size=(0.03, 0.01, 0.005), pos=end)
    scene = replace(plain, spec=spec, mujoco=spec.compile())
    arm, data = Arm(scene.robot), initial_state(scene)
    places_of_tool = [np.array([0.5, 0.2, z]) for z in np.linspace(0.03, 0.12, 4)]
    path = np.array([arm.reach([ToolPose.down(place, 0.0)])[0] for place in places_of_tool])
    scene.robot.put(data, path[0], width=0.03)
    data.joint("rod").qpos[:] = [*places_of_tool[0], 1.0, 0.0, 0.0, 0.0]
    mujoco.mj_kinematics(scene.mujoco, data)
    check = CollisionChecker(scene)
    check.see(data, true_poses(scene, data), handled="rod", held=True)
    assert check.blockers(path[:2], clearance=0.0015) == set()
    assert check.touches(path[-1]) == {("rod", "shelf")}
    assert check.blockers(path, clearance=0.0015) == {"shelf"}
