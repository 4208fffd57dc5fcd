"""Objects from mesh files: their parts, messages about bad files, and a run that carries one."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from forged_logs import log_of_run
from scenario_texts import cup_scenario

from prefplan.errors import LimitError, PrefplanError
from prefplan.limits import Limits
from prefplan.models.manipulation.description import Object
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario, load
from sim.errors import SimulationError
from sim.evidence.certificate import certify
from sim.evidence.replay import RecordedWorld
from sim.evidence.scenario_checks import check_scenario
from sim.external import meshes
from sim.external.meshes import mesh_of
from sim.geometry.antipodes import DIRECTIONS, antipodes
from sim.geometry.mjcf import solid_geoms
from sim.robots.arms.panda import PANDA
from sim.robots.arms.panda_suction import PANDA_SUCTION
from sim.world.grasps import grasps
from sim.world.scene import build_scene

TUBE = trimesh.creation.annulus(0.018, 0.028, 0.05, sections=12)


@pytest.fixture(autouse=True)
def no_kept_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    meshes._loaded.cache_clear()


def scenario_with(folder: Path, keys: str) -> Scenario:
    path = folder / "cup.toml"
    path.write_text(cup_scenario().replace('cup = { start = "desk"', f'cup = {{ start = "desk", kind = "mesh", {keys}'))
    return load(path)


def model_of(scenario: Scenario) -> ManipulationModel:
    assert isinstance(scenario.model, ManipulationModel)
    return scenario.model


def test_a_convex_mesh_is_one_part_about_the_middle_of_its_box(tmp_path: Path) -> None:
    solid = trimesh.creation.icosphere(2, 25.0)
    solid.apply_translation([100.0, 0.0, 30.0])
    solid.export(tmp_path / "ball.obj")
    found = mesh_of(Object("o", "a", kind="mesh", file="ball.obj", scale=0.001), tmp_path)
    assert found.size == pytest.approx([0.05] * 3, abs=1e-3)
    assert len(found.parts) == 1 and found.warning is None
    assert found.drawn.bounds.mean(axis=0) == pytest.approx([0, 0, 0], abs=1e-9)


def test_a_mesh_of_many_faces_is_simplified_in_collisions_too(tmp_path: Path) -> None:
    trimesh.creation.icosphere(6, 0.025).export(tmp_path / "ball.stl")
    found = mesh_of(Object("o", "a", kind="mesh", file="ball.stl"), tmp_path)
    (part,) = found.parts
    assert len(part.faces) <= meshes.MAX_FACES and found.warning is None
    assert part.extents == pytest.approx([0.05] * 3, abs=2e-4)
    assert part.volume == pytest.approx(4 / 3 * np.pi * 0.025**3, rel=0.01)


def test_a_hole_stays_free_and_parts_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    TUBE.export(tmp_path / "tube.stl")
    tube = Object("o", "a", kind="mesh", file="tube.stl")
    parts = mesh_of(tube, tmp_path).parts
    assert not any(part.contains([[0.0, 0.0, 0.0]])[0] for part in parts)
    assert sum(part.volume for part in parts) == pytest.approx(TUBE.volume, rel=0.25)
    meshes._loaded.cache_clear()
    monkeypatch.delattr(meshes, "run_apart")
    again = mesh_of(tube, tmp_path).parts
    assert [part.volume for part in again] == [part.volume for part in parts]


def test_a_decomposition_ends_with_the_time_of_its_limits(tmp_path: Path) -> None:
    trimesh.creation.torus(0.02, 0.005, major_sections=400, minor_sections=200).export(tmp_path / "ring.stl")
    began = time.perf_counter()
    with Limits(seconds=2), pytest.raises(LimitError, match="time limit"):
        mesh_of(Object("o", "a", kind="mesh", file="ring.stl"), tmp_path)
    assert time.perf_counter() - began < 6


def test_an_open_mesh_collides_as_its_hull_and_that_is_said(tmp_path: Path) -> None:
    leaky = TUBE.copy()
    leaky.update_faces(np.arange(len(leaky.faces)) > 3)
    leaky.export(tmp_path / "open.stl")
    scene = build_scene(model_of(scenario_with(tmp_path, 'file = "open.stl"')))
    assert scene.warnings == ("objects.cup: its surface is not closed, so that it collides as its convex hull",)
    assert len(solid_geoms(scene.mujoco, "cup")) == 1


def test_a_mesh_has_its_mass_and_lies_along_the_line_on_which_it_is_taken(tmp_path: Path) -> None:
    trimesh.creation.box([0.1, 0.04, 0.05]).export(tmp_path / "bar.stl")
    scene = build_scene(model_of(scenario_with(tmp_path, 'file = "bar.stl", mass = 0.3')))
    assert scene.mujoco.body("cup").mass[0] == pytest.approx(0.3)
    assert scene.shapes["cup"].half == pytest.approx([0.02, 0.05, 0.025])
    (geom,) = solid_geoms(scene.mujoco, "cup")
    assert 2 * np.sort(scene.mujoco.geom_aabb[geom, 3:]) == pytest.approx([0.04, 0.05, 0.1], abs=1e-6)


def test_it_is_carried_and_its_log_stands_alone(tmp_path: Path) -> None:
    TUBE.convex_hull.export(tmp_path / "tube.stl")
    scenario = scenario_with(tmp_path, 'file = "tube.stl"')
    log = log_of_run(scenario, seed=3)
    assert log.about.claims.completed
    assert check_scenario(log, scenario).holds
    TUBE.convex_hull.copy().apply_scale(1.01).export(tmp_path / "tube.stl")
    assert "tube.stl" in check_scenario(log, scenario).words
    assert certify(log, scenario=scenario).refuted
    (tmp_path / "tube.stl").unlink()
    assert certify(log).refuted == ()
    world = RecordedWorld(log)
    world.show(len(log.times) - 1)
    assert set(world.resting(None)) == {"cup"}


def bracket() -> trimesh.Trimesh:
    """Return an L of legs 30 mm wide, in a box of 90 x 90 x 40 mm that no hand spans."""
    corners = np.array([(0, 0), (90, 0), (90, 30), (30, 30), (30, 90), (0, 90), (15, 15)]) / 1000
    points = np.array([(*corner, height) for height in (0.0, 0.04) for corner in corners])
    sides = [(i, (i + 1) % 6) for i in range(6)]
    faces = [face for i, j in sides for face in ((6, j, i), (13, i + 7, j + 7), (i, j, j + 7), (i, j + 7, i + 7))]
    return trimesh.Trimesh(points, faces)


def in_bracket(point: np.ndarray) -> bool:
    x, y, z = point + [0.045, 0.045, 0.02]
    return min(x, y) > 0 and max(x, y) < 0.09 and min(x, y) < 0.03 and 0 < z < 0.04


def test_a_mesh_is_taken_where_opposite_faces_are_near_enough_and_the_fingers_fit(tmp_path: Path) -> None:
    bracket().export(tmp_path / "bracket.stl")
    scenario = scenario_with(tmp_path, 'file = "bracket.stl"')
    scene = build_scene(model_of(scenario))
    for grasp in grasps(scene.shapes["cup"], PANDA.gripper):
        assert grasp.width == pytest.approx(0.03 if not grasp.rotation[2, 1] else 0.04, abs=1e-3)
        assert in_bracket(grasp.position)
        ends = grasp.position + np.outer([1, -1], (grasp.opening / 2 + 0.001) * grasp.rotation[:, 1])
        assert not any(map(in_bracket, ends))
    log = log_of_run(scenario, seed=3)
    assert log.about.claims.completed and certify(log).refuted == ()


def test_a_suction_cup_takes_a_mesh_where_it_is_flat_and_the_hand_fits(tmp_path: Path) -> None:
    bracket().export(tmp_path / "bracket.stl")
    scenario = scenario_with(tmp_path, 'file = "bracket.stl"')
    model, cup = model_of(scenario), PANDA_SUCTION.gripper
    shape = build_scene(model, robot="panda_suction").shapes["cup"]
    faces = {tuple(np.round(seat.normal) + 0.0) for seat in shape.seats}
    assert faces >= {(0, 0, 1), (0, 0, -1), (-1, 0, 0), (0, -1, 0)}
    for grasp in grasps(shape, cup):
        lip = 0.99 * cup.finger_half_width_m * np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)])
        hand = cup.palm_half_width_m * np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)])
        below, above, palm = (
            grasp.position + np.column_stack([flat, np.full(len(flat), depth - cup.press_m)]) @ grasp.rotation.T
            for flat, depth in ((lip, 5e-4), (lip, -5e-4), (hand, -cup.palm_height_m))
        )
        assert all(map(in_bracket, below)) and not any(map(in_bracket, [*above, *palm]))
    log = log_of_run(replace(scenario, model=replace(model, robot="panda_suction")), seed=3)
    assert log.about.claims.completed and certify(log).refuted == ()
    trimesh.creation.icosphere(2, 0.025).export(tmp_path / "bracket.stl")
    with pytest.raises(SimulationError, match=r"cup.file: it is nowhere flat over 0.028 x 0.028 m"):
        build_scene(model, robot="panda_suction")


def test_pairs_of_faces_are_those_that_stand_opposite_each_other() -> None:
    wedge = trimesh.Trimesh([(0, 0, 0), (0.06, 0, 0), (0, 0.06, 0), (0, 0, 0.05), (0.06, 0, 0.05), (0, 0.06, 0.05)])
    surface = meshes.MeshParts(wedge.convex_hull, (wedge.convex_hull,)).surface
    assert {tuple(pair.direction) for pair in antipodes(surface, 0.02, 0.065)} == {(0.0, 0.0, 1.0)}
    ball = trimesh.creation.icosphere(3, 0.025)
    pairs = antipodes(meshes.MeshParts(ball, (ball,)).surface, 0.02, 0.065)
    assert all(pair.width == pytest.approx(0.05, abs=2e-3) for pair in pairs) and len(pairs) == len(DIRECTIONS)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('file = "none.stl"', "objects.cup.file: {}/none.stl: no such file or directory"),
        ('file = "folder.stl"', "objects.cup.file: {}/folder.stl: is a directory"),
        ('file = "cup.toml"', "objects.cup.file: 'cup.toml' is neither an STL nor an OBJ file"),
        ('file = "bad.stl"', "objects.cup.file: {}/bad.stl: no mesh can be read from it"),
        ('file = "flat.obj"', "objects.cup.file: {}/flat.obj: no mesh can be read from it (it has no volume)"),
        ('file = "tube.stl", scale = 10', "objects.cup.scale: 0.5 m high, but the hand grasps objects of"),
        (
            'file = "tube.stl", scale = 1000',
            "objects.cup.scale: its longest side is 50 m; 0.001 if the file is in milli",
        ),
        ('file = "tube.stl", scale = 1e-300', "objects.cup.scale: its longest side is 5e-302 m"),
        ("mass = 1", "objects.cup.file: missing; an STL or OBJ file beside the scenario"),
        ('file = "tube.stl", mass = 0', "objects.cup.mass: must be positive, not 0"),
        ('file = "tube.stl", size = [1, 2, 3]', "objects.cup.size: a mesh is as large as its file says"),
    ],
)
def test_what_is_no_mesh_is_refused(tmp_path: Path, keys: str, message: str) -> None:
    (tmp_path / "bad.stl").write_text("no mesh")
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv .05 0 0\nv .05 0 .05\nv 0 0 .05\nf 1 2 3 4\n")
    (tmp_path / "folder.stl").mkdir()
    trimesh.creation.box([0.05, 0.05, 0.05]).export(tmp_path / "tube.stl")
    with pytest.raises(PrefplanError) as caught:
        build_scene(model_of(scenario_with(tmp_path, keys)))
    assert isinstance(caught.value, SimulationError) or "model." in message
    assert message.format(tmp_path) in str(caught.value)
