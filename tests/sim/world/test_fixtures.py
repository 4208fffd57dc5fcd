"""Fixtures: they stand on the table, carry locations, are obstacles, and are considered by the certificate."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from forged_logs import log_of_run
from scenario_texts import cup_scenario
from small_models import COSTS

from prefplan.models.manipulation.description import Location
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.surroundings import Fixture
from prefplan.scenario.decode import loads
from sim.errors import SimulationError
from sim.evidence.certificate import certify
from sim.evidence.replay import RecordedWorld
from sim.rendering.cameras import Camera
from sim.world.fixtures import PANEL_M, blocks_of
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.tabletop import MAX_SIDE_PX, TABLE_TOP

CRATE = '{ kind = "box", at = [0.42, -0.3, 0.05], size = [0.2, 0.24, 0.1], yaw = 15 }'

RAISED = cup_scenario(
    places={"desk": "{ at = [0.5, 0.1] }", "tray": "{ at = [0.42, -0.3, 0.1] }", "rest": "{ at = [0.4, 0.3] }"}
).replace("[model.locations]", f"[model.fixtures]\ncrate = {CRATE}\n[model.locations]")

SHELF = Fixture("shelf", "shelf", (0.62, 0.2, 0.0), (0.26, 0.45, 0.5), 180.0, (0.0, 0.25))


def model_with(*fixtures: Fixture, locations: tuple[Location, ...] = ()) -> ManipulationModel:
    model = loads(cup_scenario()).model
    assert isinstance(model, ManipulationModel)
    return replace(model, fixtures=fixtures, locations=(*model.locations, *locations))


@pytest.fixture(scope="module")
def shelf() -> Scene:
    here = Location("here", at=(0.56, 0.2)), Location("above", at=(0.56, 0.2, 0.25), marks="seen")
    locations = (Location("desk", at=(0.4, -0.2)), *here)
    return build_scene(replace(model_with(SHELF), locations=locations))


def test_an_object_is_put_onto_a_box_and_the_certificate_agrees() -> None:
    log = log_of_run(loads(RAISED), seed=1)
    assert [action.action for action in log.about.actions][-1] == "release cup tray"
    assert certify(log).refuted == ()
    world = RecordedWorld(log)
    world.show(len(log.times) - 1)
    assert world.resting(None) == {"cup": "tray"}
    assert log.qpos[-1, log.about.joints["cup"] + 2] == pytest.approx(0.1 + 0.0225, abs=0.001)


def test_boxes_collide_where_they_are_drawn() -> None:
    box = Fixture("wall", "box", (0.5, 0.35, 0.15), (0.3, 0.02, 0.3), 30.0)
    model = build_scene(model_with(box)).mujoco
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    hidden, drawn = (int(model.body("fixture wall").geomadr[0]) + i for i in (0, 1))
    for geom in (hidden, drawn):
        assert data.geom_xpos[geom] == pytest.approx(box.at, abs=1e-6)
    middle = data.geom_xmat[hidden].reshape(3, 3)
    assert middle[:, 0] == pytest.approx([np.cos(np.pi / 6), 0.5, 0.0])
    corners = data.geom_xpos[drawn] + model.mesh_vert @ data.geom_xmat[drawn].reshape(3, 3).T
    first, number = int(model.mesh("fixture wall_0").vertadr[0]), int(model.mesh("fixture wall_0").vertnum[0])
    local = (corners[first : first + number] - box.at) @ middle
    assert abs(local).max(axis=0) == pytest.approx([0.15, 0.01, 0.15], abs=1e-4)


def test_a_shelf_is_open_to_the_front_alone() -> None:
    back, *sides, board = blocks_of([SHELF])
    assert back.outline.centre[0] == pytest.approx(0.62 + 0.13 - PANEL_M / 2)
    assert sorted(side.outline.centre[1] for side in sides) == pytest.approx([0.2 - 0.219, 0.2 + 0.219])
    assert (board.low, board.high) == pytest.approx((0.25 - PANEL_M, 0.25))
    assert [block.high for block in blocks_of([SHELF]) if block.carries] == pytest.approx([0.25])


def test_locations_lie_one_above_the_other(shelf: Scene) -> None:
    low, high = (shelf.slots[name][0].position[2] for name in ("here", "above"))
    assert low == 0 and high == pytest.approx(0.25 + 0.004)
    data = initial_state(shelf)
    assert data.ncon == 0 or data.contact.dist.min() > -1e-3
    assert shelf.mujoco.light("above_glow").active == 0


def test_the_camera_looks_into_a_shelf(shelf: Scene) -> None:
    view = Camera(shelf, "fixed", (640, 480)).view()
    assert np.cos(np.radians(view.azimuth)) > 0


@pytest.mark.parametrize(
    ("fixtures", "location", "message"),
    [
        ((), (0.6, 0.3, 0.2), "locations.new.at: no fixture carries it 0.2 m above the table top; there, it can lie"),
        ((SHELF,), (0.6, 0.3, 0.2), "it can lie at 0 or 0.25 m"),
        ((SHELF,), (0.51, 0.3, 0.25), "locations.new.at: it reaches over the edge of the fixture 'shelf'"),
        (
            (replace(SHELF, boards=(0.0, 0.2, 0.4)),),
            (0.51, 0.3, 0.4),
            "locations.new.at: it reaches over the edge of the fixture 'shelf'",
        ),
        (
            (Fixture("wall", "box", (0.6, 0.3, 0.1), (0.1, 0.1, 0.2)),),
            (0.6, 0.3),
            "locations.new: the fixture 'wall' stands in it (its upper side is at 0.2 m)",
        ),
        (
            (replace(SHELF, boards=(0.05,)),),
            (0.6, 0.2),
            "locations.new: the fixture 'shelf' leaves 0.038 m above it, and its objects need 0.045 m",
        ),
        (
            (Fixture("post", "box", (0.31, 0, 0.4), (0.05, 0.05, 0.8)),),
            (0.6, 0.3),
            "fixtures.post: the robot's link6 at home would be ",
        ),
        (
            (replace(SHELF, size=(0.26, 0.024, 0.5)),),
            (0.6, 0.3),
            "fixtures.shelf.size: its sides and its back are 0.012 m thick, so it must be longer than 0.012 m",
        ),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(fixtures: tuple[Fixture, ...], location: tuple[float, ...], message: str) -> None:
    with pytest.raises(SimulationError) as caught:
        build_scene(model_with(*fixtures, locations=(Location("new", at=location),)))
    assert message in str(caught.value)


def test_a_long_wall_makes_no_large_picture() -> None:
    scene = build_scene(model_with(Fixture("wall", "box", (1.5, 0.0, 1.0), (0.1, 20.0, 2.0))))
    assert max(scene.spec.texture(TABLE_TOP).width, scene.spec.texture(TABLE_TOP).height) == MAX_SIDE_PX


WALL: dict[str, object] = {"kind": "box", "at": (0.5, 0.0, 0.1), "size": (0.1, 0.1, 0.2)}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "a"}, "fixtures.a: an object or a location has this name"),
        ({"kind": "wall"}, "fixtures.wall.kind: unknown kind 'wall' (valid: box, shelf)"),
        ({"size": (0.1, 0.0, 0.2)}, "fixtures.wall.size: must be positive lengths, not [0.1, 0.0, 0.2]"),
        ({"at": (500, 0, 100)}, "fixtures.wall.at: must be metres, at most 20, not [500, 0, 100]"),
        ({"size": (0.1, 30.0, 0.2)}, "fixtures.wall.size: must be metres, at most 20, not [0.1, 30.0, 0.2]"),
        ({"boards": (0.1,)}, "fixtures.wall.boards: only a shelf has boards"),
        (
            {"at": (0.5, 0.0, 0.0)},
            "fixtures.wall.at: it reaches 0.100 m into the table; `at` is its centre, so its height is at least 0.1",
        ),
        ({"kind": "shelf"}, "fixtures.wall.boards: missing; a shelf has one at least, as in boards = [0.0, 0.25]"),
        (
            {"kind": "shelf", "boards": (0.3,)},
            "fixtures.wall.boards: 0.3 is not from 0 to 0.2 m, the height of the shelf",
        ),
        ({"yaw": float("nan")}, "fixtures.wall.yaw: must be a finite number of degrees, not nan"),
    ],
)
def test_fixtures_that_make_no_sense_are_refused(changes: dict[str, object], message: str) -> None:
    fixture = Fixture(**{"name": "wall"} | WALL | changes)  # type: ignore[arg-type]
    model = ManipulationModel("home", COSTS, (Location("a", at=(0.4, 0.0)),), (), fixtures=(fixture,))
    with pytest.raises(SimulationError) as caught:
        build_scene(model)
    assert str(caught.value) == message
