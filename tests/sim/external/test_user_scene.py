"""Scenes from the user's MJCF: how they are built, what is refused, and a run in one."""

from __future__ import annotations

import re
import shutil
import warnings
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from forged_logs import log_of_run
from scenario_texts import TIDY
from scipy.spatial.transform import Rotation

from prefplan.errors import PrefplanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario, load
from sim.capability.feasibility import Feasibility
from sim.errors import SimulationError
from sim.evidence.certificate import certify
from sim.evidence.replay import RecordedWorld
from sim.external.bundle import packed
from sim.geometry.mjcf import solid_geoms
from sim.rendering.cameras import camera_names
from sim.world.randomization import Perturbation, perturbed
from sim.world.scene import Scene, build_scene, initial_state

LAB = """
<mujoco model="lab">
  <compiler meshdir="meshes" angle="degree"/>
  <asset><mesh name="cone" file="cone.stl"/></asset>
  <default><geom rgba="0.7 0.6 0.5 1"/></default>
  <include file="parts.xml"/>
  <worldbody>
    <light name="lamp" pos="0 0 3"/>
    <geom name="floor" type="plane" size="3 3 0.1"/>
    <body name="bench" pos="0.3 0 0.35">
      <geom type="box" size="0.6 0.8 0.35"/>
      <site name="left" pos="0.2 0.2 0.355"/>
      <site name="right" pos="0.2 -0.2 0.35"/>
      <site name="afloat" pos="0.2 -0.2 0.5"/>
    </body>
    <body name="cup" pos="1 0 1" euler="0 0 30">
      <freejoint/>
      <geom type="box" size="0.03 0.02 0.02" pos="0.1 0 0.02"/>
      <geom type="cylinder" size="0.01 0.01" pos="0.1 0 0.045"/>
    </body>
    <body name="cone" pos="0.9 0.5 0.75"><freejoint/><geom type="mesh" mesh="cone"/></body>
    <camera name="side" pos="1 -1 1"/>
  </worldbody>
  <actuator><position joint="slide" kp="10"/></actuator>
</mujoco>
"""

PARTS = """
<mujoco>
  <worldbody>
    <body name="drawer" pos="0.3 0.7 0.8">
      <joint name="slide" type="slide"/>
      <geom type="box" size="0.05 0.05 0.05"/>
    </body>
  </worldbody>
</mujoco>
"""

SCENARIO = """
[model]
kind = "manipulation"
start = "home"
scene = "lab.xml"
costs = { transit = 1, grasp = 1, transport = 1, release = 1 }
[model.robot]
at = [0, 0, 0.7]
[model.locations]
desk = { site = "left" }
tray = { site = "right" }
rest = { at = [0.6, 0, 0.7], kind = "bin" }
[model.objects]
cup = { start = "desk", body = "cup" }
"""


def write(folder: Path, *changes: tuple[str, str]) -> Scenario:
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    trimesh.creation.cone(0.03, 0.05, sections=8).export(folder / "meshes" / "cone.stl")
    (folder / "lab.xml").write_text(LAB)
    (folder / "parts.xml").write_text(PARTS)
    text = SCENARIO + TIDY
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    (folder / "lab.toml").write_text(text)
    return load(folder / "lab.toml")


MUG = """
<mujoco>
  <option timestep="0.005" gravity="0 0 -3"/>
  <size memory="20M"/>
  <asset><model name="rack" file="rack/rack.xml"/></asset>
  <worldbody>
    <geom name="floor" type="box" size="1 1 0.1" pos="0 0 -0.1" margin="0.01" gap="0.01"/>
    <site name="left" pos="0.5 0.2 0"/>
    <site name="right" pos="0.5 -0.2 0"/>
    <body name="mug" pos="0 0 1">
      <freejoint/>
      <inertial mass="0.1" pos="0 0 0" fullinertia="1e-4 2e-4 3e-4 0 0 0"/>
      <geom name="side" type="cylinder" size="0.02 0.03"/>
      <frame euler="0 0 90">
        <body name="handle" pos="0.03 0 0">
          <joint/>
          <geom name="ear" type="box" size="0.015 0.004 0.02" mass="0.01"/>
        </body>
      </frame>
    </body>
    <body pos="-0.5 0.8 0"><attach model="rack" body="rack" prefix="inner-"/></body>
  </worldbody>
  <contact>
    <exclude body1="mug" body2="handle"/>
    <pair geom1="ear" geom2="floor"/>
  </contact>
  <custom><tuple name="all"><element objtype="body" objname="mug"/></tuple></custom>
</mujoco>
"""

BRACKET = """
<mujoco>
  <worldbody>
    <geom type="box" size="1 1 0.1" pos="0 0 -0.1"/>
    <site name="left" pos="0.5 0.2 0"/>
    <site name="right" pos="0.5 -0.2 0"/>
    <body name="cup">
      <freejoint/>
      <geom type="box" size="0.05 0.015 0.02"/>
      <geom type="box" size="0.015 0.05 0.02" pos="0.05 0.03 0"/>
    </body>
  </worldbody>
</mujoco>
"""

RACK = """
<mujoco model="rack">
  <compiler meshdir="parts"/>
  <asset><mesh name="bar" file="bar.stl"/></asset>
  <worldbody><body name="rack"><geom type="mesh" mesh="bar"/></body></worldbody>
</mujoco>
"""


def scene_in(scenario: Scenario) -> Scene:
    assert isinstance(scenario.model, ManipulationModel)
    return build_scene(scenario.model)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return scene_in(write(tmp_path_factory.mktemp("lab")))


def test_locations_are_where_the_scene_has_them_on_what_carries_them(lab: Scene) -> None:
    heights = {name: row[0].position[2] for name, row in lab.slots.items()}
    assert heights == pytest.approx({"desk": 0.7, "tray": 0.7, "rest": 0.703}, abs=1e-4)
    assert lab.slots["desk"][0].position[:2] == pytest.approx([0.5, 0.2])


@pytest.mark.parametrize("name", ['name="board"', ""])
def test_a_free_body_that_is_no_object_is_fixed_and_carries_a_location(tmp_path: Path, name: str) -> None:
    board = f'<body {name} pos="0.5 -0.2 0.72"><freejoint/><geom type="box" size="0.1 0.1 0.02"/></body>'
    write(tmp_path)
    (tmp_path / "lab.xml").write_text(LAB.replace('<body name="cone"', f'{board}<body name="cone"'))
    text = (SCENARIO + TIDY).replace('tray = { site = "right" }', "tray = { at = [0.5, -0.2, 0.74] }")
    (tmp_path / "lab.toml").write_text(text)
    scene = scene_in(load(tmp_path / "lab.toml"))
    assert scene.slots["tray"][0].position[2] == pytest.approx(0.74, abs=1e-4)


def test_a_body_becomes_an_object_about_the_middle_of_its_box(lab: Scene) -> None:
    assert lab.shapes["cup"].half == pytest.approx([0.02, 0.03, 0.0275], abs=1e-4)
    data = initial_state(lab)
    solid = solid_geoms(lab.mujoco, "cup")
    assert len(solid) == 2
    lowest = data.geom_xpos[solid[0]][2] - 0.02
    assert lowest == pytest.approx(0.7, abs=1e-4)
    assert data.geom_xpos[solid[0]][:2] == pytest.approx([0.5, 0.2], abs=1e-4)


def test_only_objects_move_and_that_is_said(lab: Scene) -> None:
    free = lab.mujoco.jnt_type == mujoco.mjtJoint.mjJNT_FREE
    assert [lab.mujoco.joint(int(i)).name for i in np.flatnonzero(free)] == ["cup"]
    assert lab.warnings == (
        "scene: only objects can move; fixed in place: cone, drawer",
        "scene: without effect here: actuators",
    )
    assert lab.mujoco.nu == len(lab.robot.joints) + 1


def test_its_cameras_and_lights_count(lab: Scene) -> None:
    assert "side" in camera_names(lab)
    assert not lab.mujoco.light("studio_key").active and lab.mujoco.light("lab/lamp").active
    assert not any("table" in lab.mujoco.geom(i).name for i in range(lab.mujoco.ngeom))


def test_it_is_compiled_again_with_other_centres_of_mass(lab: Scene) -> None:
    other = perturbed(lab, Perturbation(centre=0.005), seed=1)
    assert other.mujoco.nmesh == lab.mujoco.nmesh
    assert not np.allclose(other.mujoco.body("cup").ipos, lab.mujoco.body("cup").ipos)


def test_a_plan_is_carried_out_there_and_its_log_stands_alone(tmp_path: Path) -> None:
    scenario = write(tmp_path / "deep" / "folder", ('"lab.xml"', '"../folder/lab.xml"'))
    log = log_of_run(scenario, seed=1)
    assert log.about.claims.completed
    shutil.rmtree(tmp_path / "deep")
    assert certify(log).refuted == ()
    world = RecordedWorld(log)
    world.show(len(log.times) - 1)
    assert set(world.resting(None)) == {"cup"}


@pytest.fixture(scope="module")
def mug(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = tmp_path_factory.mktemp("mug")
    (folder / "rack" / "parts").mkdir(parents=True)
    (folder / "rack" / "rack.xml").write_text(RACK)
    trimesh.creation.box((0.1, 0.1, 0.4)).export(folder / "rack" / "parts" / "bar.stl")
    changes = (('"cup"', '"mug"'), ("at = [0, 0, 0.7]", "at = [0, 0]"), ("[0.6, 0, 0.7]", "[0.6, 0]"))
    scenario = write(folder, *changes)
    (folder / "lab.xml").write_text(MUG)
    with warnings.catch_warnings(action="error"):
        return scene_in(scenario)


def test_an_object_is_all_that_is_in_its_body(mug: Scene) -> None:
    shape, data = mug.shapes["cup"], initial_state(mug)
    assert sorted(shape.half) == pytest.approx([0.02, 0.03, 0.0325], abs=1e-4)
    middles = [data.geom_xpos[geom] for geom in solid_geoms(mug.mujoco, "cup")]
    assert np.linalg.norm(middles[0] - middles[1]) == pytest.approx(0.03)
    # Parts that have an inertia of their own, and others, count as the file says: each about its own middle.
    assert mug.mujoco.body("cup").mass == pytest.approx(0.11)
    squares = (0.03 - 0.03 * 0.01 / 0.11) ** 2 * 0.01 + (0.03 * 0.01 / 0.11) ** 2 * 0.1
    handle = 0.01 / 3 * np.array([0.015**2 + 0.02**2, 0.004**2 + 0.02**2, 0.015**2 + 0.004**2])
    expected = np.array([1e-4, 2e-4, 3e-4]) + handle + np.array([squares, 0.0, squares])
    assert sorted(mug.mujoco.body("cup").inertia) == pytest.approx(sorted(expected), rel=1e-3)


def test_the_hand_takes_a_body_where_its_faces_are(mug: Scene) -> None:
    pairs = [pair for pair in mug.shapes["cup"].pairs if pair.direction[2] == 0]
    assert any(abs(pair.width - 0.04) < 1e-3 for pair in pairs), "the side"


def test_a_body_that_lies_reaches_as_far_as_its_shapes(mug: Scene) -> None:
    model, points = mug.mujoco, []
    for geom, (x, y, z) in zip(solid_geoms(model, "cup"), ((0.02, 0.02, 0.03), (0.015, 0.004, 0.02)), strict=True):
        turns = np.linspace(0, 2 * np.pi, 64)
        round_ = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER
        rim = (
            np.column_stack([np.cos(turns), np.sin(turns)])
            if round_
            else np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
        )
        corners = np.array([(x * u, y * v, z * up) for u, v in rim for up in (-1, 1)])
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        points.append(corners @ turn.reshape(3, 3).T + model.geom_pos[geom])
    for rotation in Rotation.random(5, random_state=0).as_matrix():
        heights = np.concatenate(points) @ rotation[2]
        assert mug.shapes["cup"].depth(rotation) == pytest.approx(-heights.min(), abs=2e-4)
        assert mug.shapes["cup"].support(rotation[2]) == pytest.approx(heights.max(), abs=2e-4)


def test_what_is_held_by_a_part_of_it_is_tried_out(tmp_path: Path) -> None:
    scenario = write(tmp_path, ("at = [0, 0, 0.7]", "at = [0, 0]"), ("[0.6, 0, 0.7]", "[0.6, 0]"))
    (tmp_path / "lab.xml").write_text(BRACKET)
    assert Feasibility(scene_in(scenario)).check("cup", "tray").reason is None


@pytest.mark.parametrize(
    ("geoms", "kind"),
    [
        ('<geom type="cylinder" size="0.02 0.03"/>', "cylinder"),
        ('<geom type="box" size="0.02 0.025 0.03" euler="0 0 90"/>', "box"),
        ('<geom type="box" size="0.02 0.025 0.03" euler="0 0 30"/>', "mesh"),
        ('<geom type="cylinder" size="0.02 0.03" euler="90 0 0"/>', "mesh"),
        ('<geom type="cylinder" size="0.02 0.03"/><geom size="0.01" contype="0" conaffinity="0"/>', "mesh"),
        ('<geom type="capsule" size="0.02 0.02"/>', "mesh"),
    ],
)
def test_a_body_of_one_upright_shape_is_taken_however_it_lies(tmp_path: Path, geoms: str, kind: str) -> None:
    """As a box or a cylinder of ours; of all others, the hand looks for faces."""
    scenario = write(tmp_path, ("at = [0, 0, 0.7]", "at = [0, 0]"), ("[0.6, 0, 0.7]", "[0.6, 0]"))
    inside = re.sub(r"<freejoint/>.*?</body>", f"<freejoint/>{geoms}</body>", BRACKET, flags=re.DOTALL)
    (tmp_path / "lab.xml").write_text(inside)
    scene = scene_in(scenario)
    shape = scene.shapes["cup"]
    assert shape.kind == kind
    assert (shape.surface is not None) == (kind == "mesh")
    again = build_scene(scene.model)
    assert again.shapes["cup"].kind == kind and again.sha256 == scene.sha256


def test_what_has_no_effect_is_said(mug: Scene) -> None:
    assert mug.warnings == (
        "scene: only objects can move; fixed in place: handle",
        "scene: without effect here: margins of geoms, option timestep, option gravity",
    )
    assert mug.mujoco.opt.gravity[2] == -9.81 and mug.mujoco.geom_margin.max() == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"lab.xml"', '"lob.xml"', "scene: {0}/lob.xml: no such file"),
        ('"lab.xml"', f'"{"x" * 300}.xml"', "xxx.xml: no such file"),
        ('"lab.xml"', '"lab.toml"', "scene: {0}/lab.toml: "),
        ('site = "left"', 'site = "lift"', "desk.site: {0}/lab.xml has no site 'lift' (did you mean 'left'?)"),
        ('site = "left"', 'site = "afloat"', "locations.desk: nothing in {0}/lab.xml carries it"),
        ('body = "cup"', 'body = "cap"', "objects.cup.body: {0}/lab.xml has no body 'cap' (did you mean 'cup'?)"),
        (
            'body = "cup"',
            'body = "bench"',
            "objects.cup.body: 'bench' of {0}/lab.xml has no free joint; those with one: cup, cone",
        ),
        ("at = [0, 0, 0.7]", "at = [0, 0, 0.1]", "mm inside 'bench' in {0}/lab.xml"),
        ('cup = { start = "desk"', 'hand = { start = "desk"', "objects.hand: another part of the simulated scene has"),
        (
            'body = "cup" }',
            'body = "cup" }\nmug = { start = "tray", body = "cup" }',
            "objects.mug.body: 'cup' is already the object 'cup'",
        ),
        ('body = "cup"', 'body = "cup", mass = 2', "objects.cup.mass: as {0}/lab.xml says for 'cup'; leave it out"),
        ('body = "cup"', 'body = "cup", rgba = [1, 0, 0, 1]', "objects.cup.rgba: as {0}/lab.xml says"),
        ('"lab.xml"', '"/lab.xml"', "model.scene: must be a path from the folder of the scenario file"),
        ('scene = "lab.xml"', "", "model.locations.desk.site: only with `scene`, a MJCF file beside the scenario"),
        ('site = "left"', 'site = "left", at = [0, 1]', "locations.desk: needs only one of 'at', 'on' and 'site'"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_named_with_the_file(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(PrefplanError) as caught:
        scene_in(write(tmp_path, (old, new)))
    assert message.format(tmp_path) in str(caught.value)


def test_an_object_that_nothing_holds_up_is_refused(tmp_path: Path) -> None:
    scenario = write(tmp_path)
    (tmp_path / "lab.xml").write_text(
        LAB.replace('size="0.6 0.8 0.35"', 'size="0.6 0.8 0.35" contype="4" conaffinity="4"')
    )
    with pytest.raises(SimulationError, match=r"objects.cup: where it starts, .*lab.xml does not hold it"):
        scene_in(scenario)


@pytest.mark.parametrize("gone", ["lab.xml", "parts.xml", "meshes/cone.stl"])
def test_a_file_that_has_gone_since_is_named(tmp_path: Path, gone: str) -> None:
    model = write(tmp_path).model
    assert isinstance(model, ManipulationModel)
    assert set(packed(model)) == {"lab.xml", "parts.xml", "meshes/cone.stl"}
    (tmp_path / gone).unlink()
    with pytest.raises(SimulationError, match=Path(gone).name):
        packed(model)
