from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from skill_runs import assert_good

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.errors import SimulationError
from sim.execution.executor import execute
from sim.perception.grounding import slot_of
from sim.perception.sensors import object_pose, true_poses
from sim.robots.arms.panda import PANDA
from sim.world.layout import arrange
from sim.world.scene import build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M, MASSES_KG, opening, shape_of

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}

OBJECTS = {
    "cube": Object("x", "spot"),
    "small cube": Object("x", "spot", size=(0.03,)),
    "tin": Object("x", "spot", kind="cylinder", size=(0.055, 0.06)),
    "thin rod": Object("x", "spot", kind="cylinder", size=(0.02, 0.06)),
    "wide disc": Object("x", "spot", kind="cylinder", size=(0.065, 0.03)),
    "box": Object("x", "spot", kind="box", size=(0.075, 0.045, 0.03)),
    "box that only fits along x": Object("x", "spot", kind="box", size=(0.03, 0.08, 0.05)),
    "largest box": Object("x", "spot", kind="box", size=(0.12, 0.065, 0.06)),
}

ROUND = (
    "transit spot, grasp x, transport x stove, release x stove, grasp x, transport x bin, release x bin, grasp x, "
    "transport x plate, release x plate, grasp x, transport x top, release x top, grasp x, transport x spot, "
    "release x spot"
).split(", ")


def model_of(obj: Object) -> ManipulationModel:
    """Return a model in which one object meets every kind of location, and the top of another object."""
    return ManipulationModel(
        "home",
        COSTS,
        (
            Location("spot", at=(0.50, 0.0)),
            Location("base", at=(0.64, 0.12)),
            Location("top", on=("base",)),
            Location("stove", at=(0.43, 0.34), kind="stove", marks="cooked"),
            Location("plate", at=(0.34, -0.36), kind="plate"),
            Location("bin", at=(0.63, -0.22), kind="bin", capacity=2),
        ),
        (obj, Object("y", "base", kind="cylinder", size=(0.05, 0.055))),
    )


def laid_out(*objects: Object, locations: tuple[Location, ...] = (Location("spot", at=(0.5, 0.0)),)) -> None:
    arrange(ManipulationModel("home", COSTS, locations, objects), PANDA)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["small cube", "thin rod", "wide disc", "box that only fits along x", "largest box"])
def test_every_kind_and_extreme_size_is_taken_and_put_down_everywhere(name: str) -> None:
    rollout = execute(build_scene(model_of(OBJECTS[name])), ROUND, seed=1)
    assert_good(rollout)
    assert sum(event.kind == "placed" for event in rollout.events) == 5 and rollout.placement_error < 0.002


@pytest.mark.parametrize(
    ("obj", "half", "widths"),
    [
        (OBJECTS["cube"], [0.0225, 0.0225, 0.0225], [0.045, 0.045]),
        (OBJECTS["tin"], [0.0275, 0.0275, 0.03], [0.055, 0.055]),
        (OBJECTS["box"], [0.0225, 0.0375, 0.015], [0.045]),
        (OBJECTS["box that only fits along x"], [0.015, 0.04, 0.025], [0.03]),
        (Object("x", "spot", kind="box", size=(0.03, 0.05, 0.04)), [0.025, 0.015, 0.02], [0.05, 0.03]),
    ],
)
def test_the_hand_closes_along_y_unless_only_x_fits(obj: Object, half: list[float], widths: list[float]) -> None:
    shape = shape_of(obj, PANDA.gripper)
    assert shape.half == pytest.approx(half)
    assert shape.widths == pytest.approx(widths)
    assert all(width + 0.01 <= opening(width) <= PANDA.gripper.opening_m for width in shape.widths)


def test_masses_follow_the_volume_within_limits() -> None:
    assert shape_of(OBJECTS["cube"], PANDA.gripper).mass == pytest.approx(0.055)
    assert shape_of(OBJECTS["tin"], PANDA.gripper).mass == pytest.approx(
        0.055 * np.pi / 4 * 0.055**2 * 0.06 / CUBE_EDGE_M**3
    )
    assert shape_of(OBJECTS["thin rod"], PANDA.gripper).mass == MASSES_KG[0]
    assert shape_of(OBJECTS["largest box"], PANDA.gripper).mass == MASSES_KG[1]


def test_a_yaw_is_known_up_to_the_symmetry_of_the_shape() -> None:
    turn = np.radians(80)
    cube, box, tin = (shape_of(OBJECTS[name], PANDA.gripper) for name in ("cube", "box", "tin"))
    assert cube.yaw_near(turn, 0.0) == pytest.approx(np.radians(-10))
    assert box.yaw_near(turn, 0.0) == pytest.approx(turn)
    assert box.yaw_near(np.radians(170), 0.0) == pytest.approx(np.radians(-10))
    assert tin.yaw_near(turn, 0.3) == 0.3


@pytest.mark.parametrize(
    ("kind", "size", "message"),
    [
        ("cylindre", None, r"kind: unknown kind 'cylindre' \(did you mean 'cylinder'\?"),
        ("box", None, r"size: missing; a box has length along x, .* height, in m"),
        ("cylinder", (0.05,), r"size: a cylinder has diameter, height, .* not \[0\.05\]"),
        ("cube", (0.05, 0.05, 0.05), r"size: a cube has edge, in metres, not \[.*0\.05\]"),
        ("cube", (-0.05,), r"size: must be positive, not \[-0\.05\]"),
        ("cube", (float("nan"),), r"size: must be positive, not \[nan\]"),
        ("cylinder", (1e200, 0.06), r"size: must be metres, at most 20, not \[1e\+200, 0.06\]"),
        ("cube", (0.07,), r"size: 0\.07 m wide, but the hand grasps .* 0\.02 to 0\.065"),
        ("box", (0.08, 0.01, 0.04), r"size: 0\.08 m wide"),
        ("cylinder", (0.015, 0.05), r"size: 0\.015 m wide"),
        ("cylinder", (0.05, 0.11), r"size: 0\.11 m high, .* 0\.028 to 0\.104"),
        ("box", (0.05, 0.05, 0.02), r"size: 0\.02 m high"),
        ("box", (0.2, 0.05, 0.04), r"size: 0\.2 m long, .* to 0\.12 m"),
    ],
)
def test_what_the_hand_cannot_take_is_refused_by_name(kind: str, size: tuple[float, ...] | None, message: str) -> None:
    with pytest.raises(SimulationError, match=rf"objects\.x\.{message}"):
        laid_out(Object("x", "spot", kind=kind, size=size))


@pytest.mark.parametrize(("kind", "size"), [("box", (0.1, 0.14, 0.02)), ("cylinder", (0.12, 0.2)), ("mesh", None)])
def test_what_is_fixed_may_be_larger_than_the_hand(kind: str, size: tuple[float, ...] | None, tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.14, 0.2)).export(tmp_path / "tower.stl")
    file = "tower.stl" if kind == "mesh" else None
    post = Object("post", "a", kind=kind, size=size, file=file, fixed=True)
    places = Location("a", at=(0.45, 0.2)), Location("b", at=(0.45, -0.2)), Location("c", at=(0.6, -0.05))
    model = ManipulationModel("home", COSTS, places, (post, Object("cube", "b")), folder=tmp_path)
    assert_good(execute(build_scene(model), ["transit b", "grasp cube", "transport cube c", "release cube c"]))
    with pytest.raises(SimulationError, match="objects.post"):
        build_scene(replace(model, objects=(replace(post, fixed=False), Object("cube", "b"))))


def test_what_rests_on_several_objects_needs_them_equally_high() -> None:
    locations = (Location("a", at=(0.5, 0.03)), Location("b", at=(0.5, -0.03)), Location("bridge", on=("a", "b")))
    cubes = (Object("one", "a"), Object("two", "b"))
    laid_out(*cubes, locations=locations)
    with pytest.raises(SimulationError, match=r"locations\.bridge\.on: .* 'one' is 0\.045 m high and 'two' 0\.05 m"):
        laid_out(cubes[0], replace(cubes[1], kind="cylinder", size=(0.045, 0.05)), locations=locations)


def test_slots_grow_with_the_largest_object() -> None:
    row = (Location("row", at=(0.5, 0.0), capacity=2, kind="bin"),)
    distances = []
    for objects in ((), (OBJECTS["box"],), (OBJECTS["largest box"],)):
        model = ManipulationModel("home", COSTS, row, tuple(replace(obj, start="row") for obj in objects))
        first, second = arrange(model, PANDA).slots["row"]
        distances.append(float(np.hypot(*(second.position - first.position)[:2])))
    assert distances == pytest.approx([0.064, 0.075 + 0.019, 0.12 + 0.019])


def test_locations_that_only_suit_smaller_objects_are_refused() -> None:
    near = (Location("spot", at=(0.5, 0.0)), Location("other", at=(0.5, 0.06)))
    laid_out(OBJECTS["cube"], locations=near)
    with pytest.raises(SimulationError, match=r"locations\.\w+: "):
        laid_out(OBJECTS["largest box"], locations=near)


def test_the_palm_over_a_low_object_passes_beside_a_high_one() -> None:
    flat = Object("flat", "row", kind="box", size=(0.03, 0.03, 0.028))
    high = Object("high", "row", kind="cylinder", size=(0.03, 0.06))
    row = (Location("row", at=(0.5, 0.0), capacity=2), Location("away", at=(0.45, 0.35)))
    scene = build_scene(ManipulationModel("home", COSTS, row, (flat, high)))
    assert_good(execute(scene, ["transit row", "grasp flat", "transport flat away", "release flat away"]))


def test_the_hand_between_two_wide_slots_is_over_their_location() -> None:
    row = Location("row", at=(0.5, 0.0), capacity=2)
    model = ManipulationModel("home", COSTS, (row,), (replace(OBJECTS["largest box"], start="row"),))
    assert_good(execute(build_scene(model), ["transit row", "grasp x", "release x row"]))


def test_a_slot_on_others_is_as_high_as_what_lies_there() -> None:
    model = model_of(replace(OBJECTS["box"], start="top"))
    scene = build_scene(model)
    data = initial_state(scene, seed=3)
    assert data.body("x").xpos[2] == pytest.approx(0.055 + 0.015)
    slot = slot_of(scene, true_poses(scene, data), "x")
    assert slot is not None and slot.location == "top"


def test_what_fell_over_rests_nowhere() -> None:
    scene = build_scene(model_of(Object("x", "spot", kind="cylinder", size=(0.05, 0.05))))
    data = initial_state(scene)
    assert object_pose(scene, data, "x").tilt == pytest.approx(0)
    data.joint("x").qpos[3:] = [np.sqrt(0.5), np.sqrt(0.5), 0, 0]
    mujoco.mj_forward(scene.mujoco, data)
    assert object_pose(scene, data, "x").tilt == pytest.approx(np.pi / 2)
    assert slot_of(scene, true_poses(scene, data), "x") is None


def test_what_is_tilted_reaches_farther_down() -> None:
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    rotation = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    cube = shape_of(Object("cup", "desk"), PANDA.gripper)
    can = shape_of(Object("can", "desk", kind="cylinder", size=(0.04, 0.05)), PANDA.gripper)
    for shape, across, up in ((cube, 0.0225, 0.0225), (can, 0.02, 0.025)):
        assert shape.depth(np.eye(3)) == pytest.approx(up)
        assert shape.depth(rotation) == pytest.approx(s * across + c * up)
