from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import Fixture
from sim.capability.arrangement import beginning
from sim.errors import SimulationError
from sim.robots.arms.panda import PANDA
from sim.world.contacts import CARRIED_SHARE
from sim.world.layout import arrange
from sim.world.objects import start_slots
from sim.world.places import FLOOR, TableLayout
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M

COSTS = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}

A = Location("a", at=(0.5, 0.0))

HALF = np.array([0.0, 0.0, CUBE_EDGE_M / 2])


@pytest.fixture
def layout_of() -> Callable[..., TableLayout]:
    def make(*locations: Location) -> TableLayout:
        return arrange(ManipulationModel("home", COSTS, locations, ()), PANDA)

    return make


def settle(scene: Scene, data: mujoco.MjData, seconds: float) -> None:
    for _ in range(round(seconds / scene.mujoco.opt.timestep)):
        mujoco.mj_step(scene.mujoco, data)


def test_every_location_has_as_many_slots_as_it_has_room(scene: Scene) -> None:
    for place in scene.model.locations:
        row = scene.slots[place.name]
        assert [(slot.location, slot.index) for slot in row] == [(place.name, i) for i in range(place.capacity)]
        if place.at:
            assert np.mean([slot.position[:2] for slot in row], axis=0) == pytest.approx(place.at)


def test_a_location_on_others_lies_midway_and_one_object_higher(scene: Scene) -> None:
    left, right, top = (scene.slots[name][0].position for name in ("left", "right", "top"))
    assert top == pytest.approx((left + right) / 2 + [0, 0, CUBE_EDGE_M])


def test_an_object_whose_support_was_observed_to_be_missing_is_as_high_as_it_can_be(scene: Scene) -> None:
    observed = beginning(scene, {"pink": "top", "green": "right"}, {})
    starts = start_slots(observed.model, observed.slots, observed.shapes)
    assert starts["pink"].position == pytest.approx(scene.slots["top"][0].position)


def test_stacks_stand_on_stacks(layout_of: Callable[..., TableLayout]) -> None:
    slots = layout_of(
        Location("third", on=("second",)), Location("second", on=("first",)), Location("first", at=(0.5, 0.0))
    ).slots
    assert list(slots) == ["third", "second", "first"]
    assert slots["third"][0].position == pytest.approx([0.5, 0.0, 2 * CUBE_EDGE_M])


def test_fingers_close_past_a_near_neighbour_rather_than_into_the_gap(scene: Scene) -> None:
    for name in ("left", "right"):
        assert scene.slots[name][0].yaw % np.pi == pytest.approx(0)


def test_the_open_fingers_have_room_at_every_slot(scene: Scene) -> None:
    data = initial_state(scene)
    starts = start_slots(scene.model, scene.slots, scene.shapes)
    occupant = {slot.position.tobytes(): name for name, slot in starts.items()}
    for slot in (slot for row in scene.slots.values() for slot in row):
        name = occupant.get(slot.position.tobytes())
        inside = -1 if name is None else data.body(name).id
        line = np.array([np.cos(slot.yaw), np.sin(slot.yaw), 0.0])
        for direction in (line, -line):
            hit = np.array([-1], dtype=np.int32)
            start = slot.position + HALF - [0.0, 0.0, 0.01]
            distance = mujoco.mj_ray(scene.mujoco, data, start, direction, None, 1, inside, hit)
            assert distance < 0 or distance > 0.062, (slot, scene.mujoco.geom(hit[0]).name)


@pytest.mark.parametrize(
    ("locations", "message"),
    [
        ([Location("box", at=(0.5, 0.0), kind="bim")], r"box\.kind: .*did you mean 'bin'\?"),
        ([A, Location("b", at=(0.5, 0.04))], r"b: 0\.040 m from 'a', 1\.0 cm too close: .* at least 0\.050 m"),
        ([A, Location("b", at=(0.55, 0.0), kind="bin", capacity=2)], r"b: .* would touch"),
        ([replace(A, capacity=2), Location("b", on=("a",))], r"b\.on: 'a' has room for 2"),
        ([A, Location("b", on=("a",), capacity=2)], r"b\.capacity: .* 1, not 2"),
        ([replace(A, capacity=10**9)], r"a\.capacity: a row of 1000000000 objects would be \d+ m long, at most 20"),
        ([A, Location("b", on=("a",), kind="bin")], r"b\.kind: only a location on the table"),
        ([A, Location("b", at=(0.5, -0.2)), Location("c", on=("a", "b"))], r"c\.on: .* would not rest on it"),
    ],
)
def test_places_that_cannot_work_are_refused_by_name(
    layout_of: Callable[..., TableLayout], locations: list[Location], message: str
) -> None:
    with pytest.raises(SimulationError, match=rf"locations\.{message}"):
        layout_of(*locations)


def test_only_what_overlaps_is_refused(layout_of: Callable[..., TableLayout]) -> None:
    """Whether the fingers have space in such a grid depends on what is where: that is not a fault of the layout."""
    layout_of(*(Location(f"s{i}", at=(0.5 + 0.06 * (i % 3), 0.06 * (i // 3 - 1))) for i in range(9)))


def test_two_objects_never_fit_where_the_layout_leaves_less_than_the_gap_between_them(
    layout_of: Callable[..., TableLayout],
) -> None:
    layout_of(A, Location("b", at=(0.5, 0.05)))
    with pytest.raises(SimulationError, match=r"0\.047 m from 'a', 0\.3 cm too close"):
        layout_of(A, Location("b", at=(0.5, 0.047)))


def test_long_objects_side_by_side_are_turned_such_that_they_fit() -> None:
    beams = tuple(Object(f"beam{i}", f"s{i}", kind="box", size=(0.03, 0.12, 0.03)) for i in range(2))
    places = Location("s0", at=(0.42, 0.1)), Location("s1", at=(0.52, 0.1))
    layout = arrange(ManipulationModel("home", COSTS, places, beams), PANDA)
    assert [row[0].yaw for row in layout.slots.values()] == [0.0, 0.0]


def test_a_row_is_turned_again_if_another_one_turned_beside_it() -> None:
    rows = (
        Location("a", at=(0.488, 0.139), capacity=3, kind="plate"),
        Location("b", at=(0.557, -0.067), capacity=3),
        Location("c", at=(0.359, 0.079), capacity=3),
    )
    layout = arrange(ManipulationModel("home", COSTS, rows, (Object("cube", "a"),)), PANDA)
    assert [row[0].yaw for row in layout.slots.values()] == pytest.approx([0.0, np.pi / 2, 0.0])


def board(name: str, start: str, length: float) -> Object:
    return Object(name, start, kind="box", size=(0.04, length, 0.03))


def test_objects_that_stand_side_by_side_need_no_gap() -> None:
    """Putting an object down needs one, which trying it out tells; standing there does not."""
    places = Location("s0", at=(0.5, 0.0)), Location("s1", at=(0.552, 0.0))
    objects = tuple(Object(f"cube{i}", f"s{i}", size=(0.05,)) for i in range(2))
    arrange(ManipulationModel("home", COSTS, places, objects), PANDA)
    with pytest.raises(SimulationError, match=r"0\.049 m from 's0', 0\.1 cm too close"):
        nearer = places[0], replace(places[1], at=(0.549, 0.0))
        arrange(ManipulationModel("home", COSTS, nearer, objects), PANDA)


def test_the_least_sides_of_all_objects_tell_whether_two_locations_overlap() -> None:
    """The cube fits beside the long board in no direction, but the thin board does."""
    places = Location("s0", at=(0.5, 0.0)), Location("s1", at=(0.574, 0.0)), Location("s2", at=(0.5, 0.075))
    long = replace(board("long", "s0", 0.096), size=(0.053, 0.096, 0.064))
    objects = (
        long,
        Object("cube", "s2", size=(0.053,)),
        replace(board("thin", "away", 0.058), size=(0.033, 0.058, 0.03)),
    )
    away = Location("away", at=(0.5, -0.3))
    arrange(ManipulationModel("home", COSTS, (*places, away), objects), PANDA)


def test_an_object_is_turned_such_that_it_is_not_inside_a_wall() -> None:
    places = Location("s0", at=(0.5, 0.0)), Location("s1", at=(0.5, 0.07))
    wall = Fixture("wall", "box", (0.56, 0.035, 0.1), (0.06, 0.3, 0.2))
    objects = board("board0", "s0", 0.09), board("board1", "s1", 0.03)
    arrange(ManipulationModel("home", COSTS, places, objects, fixtures=(wall,)), PANDA)


def test_below_a_board_there_must_be_room_for_the_lowest_object_only() -> None:
    shelf = Fixture("shelf", "shelf", (0.6, 0.3, 0.0), (0.24, 0.5, 0.3), yaw=180, boards=(0.0, 0.08))
    places = Location("low", at=(0.55, 0.3)), Location("out", at=(0.4, 0.0)), Location("side", at=(0.4, -0.2))
    objects = Object("tall", "out", kind="cylinder", size=(0.04, 0.1)), Object("cube", "side", size=(0.04,))
    arrange(ManipulationModel("home", COSTS, places, objects, fixtures=(shelf,)), PANDA)
    with pytest.raises(
        SimulationError, match=r"locations\.low: the fixture 'shelf' leaves 0\.068 m above it, .* 0\.100 m"
    ):
        objects = replace(objects[0], start="low"), objects[1]
        arrange(ManipulationModel("home", COSTS, places, objects, fixtures=(shelf,)), PANDA)


def test_the_scene_stands_still_at_its_nominal_start(scene: Scene) -> None:
    data = initial_state(scene)
    settle(scene, data, 1.0)
    for obj, slot in start_slots(scene.model, scene.slots, scene.shapes).items():
        assert data.body(obj).xpos == pytest.approx(slot.position + HALF, abs=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_perturbed_start_stays_within_bounds_and_stands(scene: Scene, seed: int) -> None:
    data = initial_state(scene, seed=seed)
    places = {name: data.body(name).xpos.copy() for name in start_slots(scene.model, scene.slots, scene.shapes)}
    for name, slot in start_slots(scene.model, scene.slots, scene.shapes).items():
        off = places[name] - slot.position - HALF
        assert np.abs(off[:2]).max() <= 0.005 and off[2] == pytest.approx(0)
        turn = 2 * np.arctan2(data.body(name).xquat[3], data.body(name).xquat[0]) - slot.yaw
        assert abs((turn + np.pi / 4) % (np.pi / 2) - np.pi / 4) <= np.radians(5) + 1e-9
    assert min((contact.dist for contact in data.contact), default=0.0) > -1e-6
    settle(scene, data, 1.0)
    for name, place in places.items():
        assert data.body(name).xpos == pytest.approx(place, abs=1e-3)


def test_nothing_but_contact_holds_an_object(scene: Scene) -> None:
    model = scene.mujoco
    assert model.nmocap == 0
    assert model.neq == 1 and model.eq_type[0] == mujoco.mjtEq.mjEQ_JOINT
    assert {model.joint(name).id for name in ("finger_joint1", "finger_joint2")} == {
        int(model.eq_obj1id[0]),
        int(model.eq_obj2id[0]),
    }
    assert model.nexclude == 0
    for obj in scene.model.objects:
        assert model.joint(obj.name).type == mujoco.mjtJoint.mjJNT_FREE


def test_an_object_dropped_over_a_bin_stays_between_its_walls(scene: Scene) -> None:
    data = initial_state(scene)
    middle = np.mean([slot.position for slot in scene.slots["bin1"]], axis=0)
    data.joint("green").qpos[:3] = middle + [0.02, 0.02, 0.05]
    data.joint("green").qvel[:2] = [0.1, 0.2]
    settle(scene, data, 1.5)
    inside = data.body("green").xpos - middle
    assert np.abs(inside[:2]).max() < 0.0665
    assert data.body("green").xpos[2] == pytest.approx(FLOOR["bin"] + CUBE_EDGE_M / 2, abs=2e-3)


def test_objects_without_a_colour_get_different_ones(arch_model: ManipulationModel) -> None:
    plain = replace(arch_model, objects=tuple(Object(obj.name, obj.start) for obj in arch_model.objects))
    scene = build_scene(plain)
    colours = {tuple(scene.mujoco.mat(obj.name).rgba) for obj in plain.objects}
    assert len(colours) == 3


def test_objects_rest_flat_on_stoves_and_plates_even_in_rows() -> None:
    model = ManipulationModel(
        "home",
        COSTS,
        (
            Location("stove", at=(0.45, 0.30), kind="stove", capacity=2, marks="cooked"),
            Location("plate", at=(0.45, -0.30), kind="plate", capacity=2),
        ),
        tuple(
            Object(f"{place}{i}", place, kind="cylinder", size=(0.05, 0.03 + 0.02 * i))
            for place in ("stove", "plate")
            for i in range(2)
        ),
    )
    scene = build_scene(model)
    data = initial_state(scene, seed=1)
    settle(scene, data, 1.0)
    for obj, slot in start_slots(model, scene.slots, scene.shapes).items():
        assert data.body(obj).xpos[2] == pytest.approx(FLOOR[slot.location] + scene.shapes[obj].half[2], abs=1e-3)
        assert data.body(obj).xmat[8] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("kind", FLOOR)
def test_a_location_of_any_kind_that_marks_has_what_glows(kind: str) -> None:
    place = Location("wash", at=(0.45, 0.30), kind=kind, capacity=2, marks="clean")
    model = build_scene(ManipulationModel("home", COSTS, (place,), ())).mujoco
    glowing = model.geom_matid == model.mat("wash_glow").id
    assert glowing.any() and set(model.geom_bodyid[glowing]) == {model.body("wash_base").id}
    assert not model.geom_contype[glowing].any() and model.light("wash_glow").active == 0


def test_a_cylinder_between_the_pads_never_counts_as_deep_in_one(scene: Scene) -> None:
    """With MuJoCo's default tolerance, in this pose, as recorded in a run, it is 10.9 mm deep."""
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody>
        <body pos="0.3409827 0.3244219 0.1180751" quat="0.0027281 0.9235707 0.0126559 0.3832095">
          <freejoint/><geom type="box" size="0.0088 0.0055 0.0092"/></body>
        <body pos="0.3401326 0.3598055 0.1188116" quat="-0.0023587 -0.5716458 0.8204639 -0.0073790">
          <freejoint/><geom type="cylinder" size="0.03 0.015"/></body>
        </worldbody></mujoco>""")
    model.opt.ccd_tolerance = scene.mujoco.opt.ccd_tolerance
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon and np.allclose(data.contact.dist, -0.00012, atol=1e-5)


@pytest.mark.parametrize(("load", "carrier"), [(3.0, 0.05), (0.4, 0.004), (3.0, 0.001)])
def test_a_light_object_carries_a_heavy_one(load: float, carrier: float) -> None:
    places = (A, Location("above", on=("a",)))
    objects = (
        Object("light", "a", kind="box", size=(0.05, 0.05, 0.05), mass=carrier),
        Object("heavy", "above", kind="box", size=(0.10, 0.05, 0.06), mass=load),
    )
    scene = build_scene(ManipulationModel("home", COSTS, places, objects))
    data = initial_state(scene)
    before = data.joint("heavy").qpos[2]
    settle(scene, data, 1.0)
    assert abs(data.joint("heavy").qpos[2] - before) < 0.002
    assert data.contact.dist.min() > -0.001


def test_only_what_is_too_light_for_the_heaviest_object_has_stiffer_contacts() -> None:
    masses = {"usual": 0.6, "light": 0.06, "heavy": 2.8}
    places = [Location(name, at=(0.5, y)) for name, y in zip(masses, (-0.2, 0.0, 0.2), strict=True)]
    objects = [Object(name, name, kind="cube", mass=mass) for name, mass in masses.items()]
    model = build_scene(ManipulationModel("home", COSTS, tuple(places), tuple(objects))).mujoco

    def stiffness(name: str) -> float:
        impedance = model.geom_solimp[model.body_geomadr[model.body(name).id], 0]
        return float(impedance / (1 - impedance))

    assert stiffness("usual") == stiffness("heavy")
    assert stiffness("light") / stiffness("heavy") == pytest.approx(2.8 / 0.06 / CARRIED_SHARE)
