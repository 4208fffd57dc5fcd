from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from observers import Before
from skill_runs import assert_clean, assert_placed, perform_all
from small_models import TOWER

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.errors import SimulationError
from sim.perception.grounding import slot_of
from sim.perception.sensors import NoisySensor, ObjectPose, object_pose, true_poses
from sim.perception.touch import HOLD_FORCE_N
from sim.robots.arms.panda import PANDA
from sim.simulation.workcell import Workcell
from sim.skills import grasp_choice
from sim.skills.catalogue import SKILLS, perform
from sim.skills.placing import free_slot
from sim.skills.release import GLOW_DURATION_S
from sim.skills.skill import SkillError
from sim.world.contacts import scale_friction
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M


@pytest.fixture
def own_scene(scene: Scene) -> Scene:
    """Return a scene that a test may spoil."""
    return build_scene(scene.model)


def test_what_would_rest_on_supports_of_different_heights_is_not_put_down() -> None:
    spots = {"left": (0.5, 0.03), "right": (0.5, -0.03), "near": (0.45, 0.3), "far": (0.45, -0.3)}
    places = (*(Location(name, at=at) for name, at in spots.items()), Location("top", on=("left", "right")))
    objects = (Object("one", "left"), Object("low", "right", size=(0.035,)), Object("two", "near"), Object("x", "far"))
    scene = build_scene(ManipulationModel("home", dict.fromkeys(SKILLS, 1), places, objects))
    with pytest.raises(SkillError, match="x would not rest on low"):
        free_slot(Workcell(scene, initial_state(scene)), "x", "top")


def test_what_carries_an_object_is_not_in_its_way_however_noisy_the_sensor() -> None:
    places = (Location("base", at=(0.5, 0.0)), Location("top", on=("base",)), Location("far", at=(0.45, -0.3)))
    objects = (Object("low", "base"), Object("x", "far"))
    scene = build_scene(ManipulationModel("home", dict.fromkeys(SKILLS, 1), places, objects))
    cell = Workcell(scene, initial_state(scene), sensor=NoisySensor(0.002, seed=2))
    assert all(free_slot(cell, "x", "top").location == "top" for _ in range(100))


def test_transit_brings_the_empty_hand_over_a_location(scene: Scene) -> None:
    cell = perform_all(scene, "transit bin1")
    centre = np.mean([slot.position for slot in scene.slots["bin1"]], axis=0)
    offset = cell.data.site("tcp").xpos - centre - [0.0, 0.0, CUBE_EDGE_M / 2]
    assert np.hypot(*offset[:2]) < 0.002 and 0.1 < offset[2] < 0.15
    assert_clean(cell)


@pytest.mark.parametrize("seed", range(2))
def test_grasp_lifts_what_lies_askew(scene: Scene, seed: int) -> None:
    cell = Workcell(scene, initial_state(scene, seed=seed, position=0.008, angle=np.radians(10)))
    perform(cell, "transit top")
    perform(cell, "grasp pink")
    assert cell.held() == "pink"
    assert object_pose(scene, cell.data, "pink").position[2] > 0.15
    grasped = next(event for event in cell.events if event.kind == "grasped")
    assert grasped.detail["object"] == "pink" and min(grasped.detail["force"]) > 5
    for base, location in (("blue", "left"), ("green", "right")):
        slot = slot_of(scene, true_poses(scene, cell.data), base)
        assert slot is not None and slot.location == location, "the bases should stay where they are"
    assert_clean(cell)


def test_what_has_crept_down_to_the_ends_of_the_pads_is_still_held(scene: Scene) -> None:
    cell = perform_all(scene, "transit top", "grasp pink")
    hanging = scene.shapes["pink"].half[2] + 0.0075
    cell.data.joint("pink").qpos[2] = cell.data.site("tcp").xpos[2] - hanging
    cell.wait(0.3)
    assert min(cell.contacts.pad_forces) > HOLD_FORCE_N and cell.held() == "pink"
    cell.data.joint("pink").qpos[2] -= 0.004
    cell.wait(0.3)
    assert cell.held() is None


@pytest.mark.parametrize("location", ["san", "bin1", "bin2", "table", "top"])
def test_release_and_grasp_work_everywhere(scene: Scene, location: str) -> None:
    cell = perform_all(scene, "transit top", "grasp pink")
    if location != "top":
        perform(cell, f"transport pink {location}")
    perform(cell, f"release pink {location}")
    assert_placed(cell, "pink", location)
    perform(cell, "grasp pink")
    assert cell.held() == "pink"
    assert_clean(cell)


@pytest.fixture(scope="module")
def heavy(scene: Scene) -> Scene:
    """The arch with a pink block as heavy as the arm can bear."""
    objects = tuple(replace(obj, mass=PANDA.payload_kg) if obj.name == "pink" else obj for obj in scene.model.objects)
    return build_scene(replace(scene.model, objects=objects))


def test_the_payload_is_carried_within_the_limits_and_does_not_draw_the_arm_down(heavy: Scene) -> None:
    cell = perform_all(heavy, "transit top", "grasp pink", "transport pink table")
    cell.settle()
    assert np.linalg.norm(cell.arm.tool(cell.angles).position - cell.arm.tool(cell.reference).position) < 5e-4
    perform(cell, "release pink table")
    assert_placed(cell, "pink", "table")
    assert_clean(cell)


def scene_with_cube(at: tuple[float, float], mass: float) -> Scene:
    """Return a scene with a cube at the location `far`."""
    costs = dict.fromkeys(("transit", "grasp", "transport", "release"), 1)
    model = ManipulationModel("home", costs, (Location("far", at=at),), (Object("cube", "far", mass=mass),))
    return build_scene(model)


@pytest.mark.parametrize(("at", "mass"), [((0.757, 0.147), 2.63), ((0.607, -0.55), 2.66), ((0.8, 0.0), 3.0)])
def test_a_payload_far_from_the_base_is_lifted_and_put_back_within_the_torques_of_the_arm(
    at: tuple[float, float], mass: float
) -> None:
    cell = perform_all(scene_with_cube(at, mass), "transit far", "grasp cube", "release cube far")
    assert_placed(cell, "cube", "far")
    loads = cell.recorder.arrays
    assert np.abs(loads["torques"] / PANDA.torque_limits).max() < 0.99, "a joint at its limit does not follow"
    assert np.abs(loads["torque_rates"] / PANDA.torque_rate_limits).max() < 0.7


@pytest.mark.parametrize(
    ("at", "mass", "too_high"),
    [((0.274, -0.696), 0.245, 0.0), ((0.75, 0.0), 0.245, 0.0), ((0.55, 0.1), 0.1, 0.0035), ((0.55, 0.1), 1.0, 0.002)],
    ids=["far to the side", "far ahead", "seen too high", "heavy and seen too high"],
)
def test_an_object_touches_down_gently(at: tuple[float, float], mass: float, too_high: float) -> None:
    scene, sensor = scene_with_cube(at, mass), None
    if too_high:
        sensor = NoisySensor(0.0015, seed=1, bias=np.array([0.0, 0.0, too_high]))
    cell = Workcell(scene, initial_state(scene), sensor=sensor)
    for action in ("transit far", "grasp cube", "release cube far"):
        perform(cell, action)
    loads = cell.recorder.arrays
    assert (loads["torque_rates"][loads["times"] > cell.events[-2].time] / PANDA.torque_rate_limits).max() < 0.9


def test_an_arm_that_loses_its_payload_does_not_stay_raised(heavy: Scene) -> None:
    cell = perform_all(heavy, "transit top", "grasp pink")
    cell.settle()
    cell.grip(PANDA.gripper.opening_m, 0.25)
    cell.wait(1.0)
    assert cell.held() is None
    assert np.abs(cell.angles - cell.reference).max() < 1e-4


def test_a_base_is_taken_and_put_back_beside_its_neighbour(scene: Scene) -> None:
    away = ("transit top", "grasp pink", "transport pink table", "release pink table")
    cell = perform_all(scene, *away, "transit left", "grasp blue", "transport blue bin2", "release blue bin2")
    assert_placed(cell, "blue", "bin2")
    for action in ("grasp blue", "transport blue left", "release blue left"):
        perform(cell, action)
    assert_placed(cell, "blue", "left")
    for action in ("transit table", "grasp pink", "transport pink top", "release pink top"):
        perform(cell, action)
    assert_placed(cell, "pink", "top")
    assert_clean(cell)


def test_a_bin_takes_two_and_gives_back_either(scene: Scene) -> None:
    into_bin = ["transit {0}", "grasp {1}", "transport {1} bin1", "release {1} bin1"]
    actions = [action.format(*what) for what in (("top", "pink"), ("left", "blue")) for action in into_bin]
    cell = perform_all(scene, *actions)
    assert_placed(cell, "pink", "bin1")
    assert_placed(cell, "blue", "bin1")
    perform(cell, "grasp pink")
    assert cell.held() == "pink"
    assert_clean(cell)


def test_a_marking_location_glows_while_it_works(scene: Scene) -> None:
    cell = perform_all(scene, "transit top", "grasp pink", "transport pink san", "release pink san")
    glow = cell.recorder.arrays["glow"]
    index = list(scene.slots).index("san")
    assert set(glow) == {-1, index}
    assert np.sum(glow == index) == pytest.approx(GLOW_DURATION_S * 30, abs=2)
    assert np.all(np.diff(np.flatnonzero(glow == index)) == 1)


def test_grasping_what_is_not_there_is_refused(scene: Scene) -> None:
    cell = perform_all(scene, "transit san")
    with pytest.raises(SkillError, match="pink is not below the hand"):
        perform(cell, "grasp pink")


@pytest.mark.parametrize(
    ("before", "action"),
    [(["transit top"], "grasp pink"), (["transit top", "grasp pink"], "transport pink bin1")],
)
def test_an_object_too_slippery_to_hold_is_noticed(own_scene: Scene, before: list[str], action: str) -> None:
    cell = perform_all(own_scene, *before)
    scale_friction(own_scene.mujoco, {}, pads=dict.fromkeys(PANDA.gripper.pads, 0.01), table=1.0)
    with pytest.raises(SkillError, match="both finger pads: pink is not held"):
        perform(cell, action)
    assert cell.held() is None


def test_an_occupied_place_is_refused(scene: Scene) -> None:
    cell = perform_all(scene, "transit top", "grasp pink")
    cell.data.joint("green").qpos[:3] = scene.slots["san"][0].position + [0.01, 0.0, CUBE_EDGE_M / 2]
    mujoco.mj_forward(scene.mujoco, cell.data)
    with pytest.raises(SkillError, match="no room for pink on san: green is 4.1 cm too close"):
        perform(cell, "transport pink san")


def test_the_arm_goes_over_what_is_in_the_way(scene: Scene) -> None:
    cell = perform_all(scene, "transit bin1")
    posts = {"blue": 0.0225, "pink": 0.0675, "green": 0.1125}
    for obj, z in posts.items():
        cell.data.joint(obj).qpos[:] = [0.46, 0.0, z, 1, 0, 0, 0]
    mujoco.mj_forward(scene.mujoco, cell.data)
    perform(cell, "transit san")
    assert_clean(cell)
    assert object_pose(scene, cell.data, "green").position[2] == pytest.approx(0.1125, abs=0.002)


def test_the_hand_stays_above_a_tower_over_its_foot() -> None:
    cell = perform_all(build_scene(TOWER), "transit a", "transit c", "grasp three", "release three c")
    assert_placed(cell, "three", "c")
    assert_clean(cell)


def test_the_hand_opens_less_where_a_wall_is_near(scene: Scene) -> None:
    """A block 6.5 mm off its slot along the closing direction leaves the opened fingers no room in a bin."""
    slot = scene.slots["bin1"][0]
    data = initial_state(scene)
    along = np.array([np.cos(slot.yaw), np.sin(slot.yaw)])
    data.joint("pink").qpos[:3] = [*slot.position[:2] + 0.0065 * along, slot.position[2] + CUBE_EDGE_M / 2]
    data.joint("blue").qpos[:2] = scene.slots["bin1"][1].position[:2]
    assert_taken(scene, data, "pink", "bin1")


def test_the_hand_opens_less_where_it_lets_go_beside_others(own_scene: Scene) -> None:
    cell = perform_all(own_scene, "transit top", "grasp pink", "transport pink table")
    slot = own_scene.slots["table"][0]
    closing = np.array([np.cos(slot.yaw), np.sin(slot.yaw)])
    beside = {"blue": closing, "green": np.array([-closing[1], closing[0]])}
    for obj, side in beside.items():
        point = [*slot.position[:2] + 0.077 * side, slot.position[2] + CUBE_EDGE_M / 2]
        cell.data.joint(obj).qpos[:] = [*point, np.cos(slot.yaw / 2), 0, 0, np.sin(slot.yaw / 2)]
    mujoco.mj_forward(own_scene.mujoco, cell.data)
    perform(cell, "release pink table")
    assert_placed(cell, "pink", "table")
    assert_clean(cell)


def assert_taken(scene: Scene, data: mujoco.MjData, obj: str, location: str) -> None:
    """Fail unless the hand grasps an object at a location without a collision."""
    mujoco.mj_forward(scene.mujoco, data)
    cell = Workcell(scene, data)
    perform(cell, f"transit {location}")
    perform(cell, f"grasp {obj}")
    assert cell.held() == obj
    assert_clean(cell)


def lying_in_bin1(scene: Scene, *, along: float, across: float, yaw: float) -> Workcell:
    """Return the hand over bin1, with pink this far from its centre along and across the closing direction, m."""
    slots = scene.slots["bin1"]
    direction = np.array([np.cos(slots[0].yaw), np.sin(slots[0].yaw)])
    middle = np.mean([slot.position for slot in slots], axis=0)
    data = initial_state(scene)
    point = middle[:2] + along * direction + across * np.array([direction[1], -direction[0]])
    data.joint("pink").qpos[:] = [*point, middle[2] + CUBE_EDGE_M / 2, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
    mujoco.mj_forward(scene.mujoco, data)
    assert data.ncon and data.contact.dist.min() > -0.001, "it should lie free of the walls"
    cell = Workcell(scene, data)
    perform(cell, "transit bin1")
    return cell


@pytest.mark.parametrize(("along", "across", "yaw"), [(0.024, 0.025, 11), (0.030, -0.035, 41), (0.043, 0.033, 0)])
def test_what_lies_near_a_rim_is_held_by_its_top(scene: Scene, along: float, across: float, yaw: float) -> None:
    cell = lying_in_bin1(scene, along=along, across=across, yaw=np.radians(yaw))
    perform(cell, "grasp pink")
    assert cell.data.site("tcp").xpos[2] - object_pose(scene, cell.data, "pink").position[2] > 0.015
    for action in ("transport pink table", "release pink table"):
        perform(cell, action)
    assert_placed(cell, "pink", "table")
    assert_clean(cell)


@pytest.mark.parametrize(
    ("along", "across", "yaw"),
    [
        # With the hand open, one finger would come down outside the bin, and press on its wall when closing.
        pytest.param(0.017, 0.042, 2, id="wall-between-the-fingers"),
        # The open fingers would just fit in if the arm had no tracking error.
        pytest.param(0.0047, 0.0286, 82.4, id="wall-close-by"),
    ],
)
def test_fingers_touch_no_wall_as_they_close(scene: Scene, along: float, across: float, yaw: float) -> None:
    cell = lying_in_bin1(scene, along=along, across=across, yaw=np.radians(yaw))
    perform(cell, "grasp pink")
    assert cell.held() == "pink"
    assert_clean(cell)


def test_an_object_is_not_lowered_onto_one_that_has_come_meanwhile(scene: Scene) -> None:
    cell = perform_all(scene, "transit top", "grasp pink", "transport pink table")
    place, began = scene.slots["table"][0].position, cell.data.time

    def disturb() -> None:
        if cell.data.time > began + 0.15:
            cell.observers.clear()
            cell.data.joint("green").qpos[:3] = place + [0.0, 0.028, CUBE_EDGE_M / 2]

    Before(cell, disturb)
    with pytest.raises(SkillError, match="no room for pink on table: green is 2.3 cm too close"):
        perform(cell, "release pink table")
    assert cell.held() == "pink"
    assert_clean(cell)


def test_what_hangs_askew_is_not_pressed_onto_the_table(scene: Scene) -> None:
    cell = perform_all(scene, "transit top", "grasp pink", "transport pink table", seed=None)
    line = cell.data.site("tcp").xmat.reshape(3, 3)[:, 1]
    tilted, half = np.zeros(4), np.radians(37) / 2
    swing = np.array([np.cos(half), *np.sin(half) * line])
    mujoco.mju_mulQuat(tilted, swing, cell.data.joint("pink").qpos[3:])
    cell.data.joint("pink").qpos[3:] = tilted
    mujoco.mj_forward(scene.mujoco, cell.data)
    lowest: list[float] = []

    def look() -> None:
        pose = object_pose(scene, cell.data, "pink")
        lowest.append(float(pose.position[2]) - scene.shapes["pink"].depth(pose.rotation))

    Before(cell, look)
    perform(cell, "release pink table")
    assert min(lowest) > -0.002
    assert_clean(cell)
    assert object_pose(scene, cell.data, "pink").tilt < 0.01


@pytest.mark.parametrize(
    "pose",
    [
        pytest.param([0.5198, -0.2604, 0.0254, 0.7709, 0.0, 0.0, 0.6369], id="beside the wall"),
        pytest.param([0.5242, -0.2951, 0.0336, 0.6196, -0.3534, -0.3464, 0.6093], id="leaning on it"),
    ],
)
def test_what_rubs_on_the_wall_of_a_bin_is_raised_gently(scene: Scene, pose: list[float]) -> None:
    """At the usual speed it sticks, and as it gets free the joints' acceleration reaches 107 to 117 % of the limit."""
    data = initial_state(scene)
    data.joint("blue").qpos[:] = pose
    assert_taken(scene, data, "blue", "bin2")


class LowSensor(NoisySensor):
    """A noisy sensor that happens to observe everything this much too low, m."""

    low = CUBE_EDGE_M / 2 + 0.010

    def observe(self, scene: Scene, data: mujoco.MjData, obj: str) -> ObjectPose:
        """Return the true pose, lowered."""
        pose = object_pose(scene, data, obj)
        return replace(pose, position=pose.position - [0.0, 0.0, self.low])


@pytest.mark.parametrize(("noise", "held"), [(0.0, None), (0.001, "pink")])
def test_what_is_held_by_its_edge_is_not_taken_for_lost_by_a_noisy_sensor(
    scene: Scene, noise: float, held: str | None
) -> None:
    cell = perform_all(scene, "transit top", "grasp pink")
    cell.sensor = LowSensor(noise, seed=0)
    assert cell.held() == held


@pytest.mark.parametrize(("destination", "where"), [("table", " at table"), (None, "")])
def test_an_object_that_no_grasp_sets_upright_is_said_to_be_one(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, destination: str | None, where: str
) -> None:
    cell = Workcell(scene, initial_state(scene))
    monkeypatch.setattr(grasp_choice, "find_grasp", lambda *given, **options: None)
    pose = cell.observe("pink")
    with pytest.raises(SimulationError, match=f"^pink cannot be set upright{where} in any grasp$"):
        grasp_choice.choose_grasp(cell, "pink", pose, pose.yaw, destination)
