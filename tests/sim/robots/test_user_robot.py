"""Robots from the user's MJCF, described by a table in a scenario."""

from __future__ import annotations

import os
import shutil
from dataclasses import fields, replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from scenario_texts import cup_scenario
from skill_runs import contacts

from prefplan.claims import Claims
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.surroundings import GripperSetup, RobotSetup
from prefplan.scenario.decode import load, loads
from sim.capability.feasibility import Feasibility
from sim.errors import SimulationError
from sim.evidence.log import log_of
from sim.evidence.replay import RecordedWorld
from sim.execution.executor import execute
from sim.export.mjcf import encode_mjcf
from sim.robots.arms.panda import PANDA, panda_spec
from sim.robots.catalogue import robot_for
from sim.robots.gripper import SuctionGripper
from sim.robots.import_mjcf import PREFIX, ImportedArm
from sim.robots.robot import ArmConstants
from sim.robots.user_robot import check_robot
from sim.world.scene import build_scene

TABLE = """[model.robot]
mjcf = "crane.xml"
joints = ["turn", "lift"]
tool = "tip"
gripper = { kind = "parallel", actuator = "fingers", open = 0.075, closed = 0.0, force = 20 }
home = [0.0, 0.4]
velocity = [2.0, 1.0]
torque = [200, 400]
[model.locations]"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("own")
    shutil.copy(Path(__file__).parent / "crane.xml", folder)
    text = cup_scenario(places={"desk": "{ at = [0.5, 0.0] }", "tray": "{ at = [0.3, 0.4] }"})
    path = folder / "crane.toml"
    path.write_text(text.replace("[model.locations]", TABLE))
    return path


@pytest.fixture(scope="module")
def setup(file: Path) -> RobotSetup:
    model = load(file).model
    assert isinstance(model, ManipulationModel)
    return model.robot_setup


def changed(setup: RobotSetup, folder: Path, *changes: tuple[str, str]) -> RobotSetup:
    """Return the setup of the crane with changes of its MJCF, which is written into a folder."""
    mjcf = (setup.folder / "crane.xml").read_text()
    for before, after in changes:
        assert before in mjcf
        mjcf = mjcf.replace(before, after, 1)
    (folder / "crane.xml").write_text(mjcf)
    return replace(setup, folder=folder)


def test_it_carries_out_a_plan(file: Path) -> None:
    model = load(file).model
    assert isinstance(model, ManipulationModel)
    scene = build_scene(model)
    assert scene.robot.name == "crane"
    assert scene.mujoco.geom("cup").rgba[0] != 0.8, "its defaults must not apply to the scene"
    rollout = execute(scene, ["transit desk", "grasp cup", "transport cup tray", "release cup tray"])
    assert rollout.completed, rollout.reason
    assert contacts(rollout.events) == []
    claims = Claims(completed=True, cost=0, task_costs={}, violation_costs={}, preference=0)
    log = log_of(scene, rollout, claims, scenario="crane", text=file.read_text())
    assert RecordedWorld(log).robot.name == "crane", "the log tells where the MJCF is"
    assert rollout.placement_error < 0.003


@pytest.mark.parametrize("part", ["crane.xml", "inner.xml"])
def test_an_mjcf_that_was_changed_is_read_again(setup: RobotSetup, tmp_path: Path, part: str) -> None:
    text = (setup.folder / "crane.xml").read_text()
    ranges = []
    (tmp_path / "crane.xml").write_text('<mujoco model="crane"><include file="inner.xml"/></mujoco>')
    for time, high in enumerate(("0.6", "0.7")):
        (tmp_path / part).write_text(text.replace("0 0.6", f"0 {high}"))
        os.utime(tmp_path / part, (time, time))
        robot = robot_for(replace(setup, folder=tmp_path))
        ranges.append(float(robot.ranges(robot.spec().compile())[1, 1]))
    assert ranges == [0.6, 0.7]


def test_its_meshes_are_exported(file: Path, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "parts" / "block.stl")
    text = (file.parent / "crane.xml").read_text()
    for old, new in (
        ('angle="degree"/>', 'angle="degree" meshdir="parts"/><asset><mesh name="block" file="block.stl"/></asset>'),
        ('<body name="column">', '<body name="column"><geom type="mesh" mesh="block" pos="0 0 0.1"/>'),
    ):
        text = text.replace(old, new)
    (tmp_path / "crane.xml").write_text(text)
    model = loads(file.read_text(), path=tmp_path / "crane.toml").model
    assert isinstance(model, ManipulationModel)
    scene = build_scene(model)
    files = encode_mjcf(scene)
    shown = mujoco.MjModel.from_xml_string(files["scene.xml"].decode(), files)
    assert np.allclose(shown.mesh_vert, scene.mujoco.mesh_vert, atol=1e-5)


@pytest.mark.parametrize(
    ("joint", "narrow", "bearing", "words"),
    [
        ('range="0 0.6"', 'range="0.15 0.6"', 0, "lift lacks 11 cm"),
        ('range="-150 150"', 'range="-100 70"', 90, "turn lacks 20 degrees"),
        ("", "", 165, "the arm cannot point down"),  # so far behind it the search without limits fails, too
    ],
)
def test_a_joint_that_cannot_move_far_enough_is_named(
    file: Path, tmp_path: Path, joint: str, narrow: str, bearing: float, words: str
) -> None:
    (tmp_path / "crane.xml").write_text((file.parent / "crane.xml").read_text().replace(joint, narrow))
    at = 0.5 * np.cos(np.radians(bearing)), 0.5 * np.sin(np.radians(bearing))
    (tmp_path / "crane.toml").write_text(file.read_text().replace("[0.5, 0.0]", str([*map(float, at)])))
    model = load(tmp_path / "crane.toml").model
    assert isinstance(model, ManipulationModel)
    assert words in str(Feasibility(build_scene(model)).check("cup", "desk").reason)


@pytest.mark.parametrize(
    ("element", "words"),
    [
        ('<compiler meshdir="/tmp"/>', "'/tmp' is no path relative to the file"),
        ('<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>', "MuJoCo cannot build it"),
    ],
)
def test_its_mjcf_passes_the_door_of_scenes(file: Path, tmp_path: Path, element: str, words: str) -> None:
    text = (file.parent / "crane.xml").read_text()
    (tmp_path / "crane.xml").write_text(text.replace("</mujoco>", f"{element}</mujoco>"))
    (tmp_path / "crane.toml").write_text(file.read_text())
    model = load(tmp_path / "crane.toml").model
    assert isinstance(model, ManipulationModel)
    with pytest.raises(SimulationError, match=f"robot.mjcf: .*crane.xml: .*{words}"):
        robot_for(model.robot_setup)


def test_the_width_between_the_fingers_follows_the_gear(setup: RobotSetup) -> None:
    gripper = robot_for(setup).gripper
    assert gripper.command(0.038) == pytest.approx(0.038 * 100 / 0.03, rel=0.01)
    assert gripper.width(gripper.command(0.05)) == pytest.approx(0.05)
    assert gripper.positions(0.05) == pytest.approx([0.025, 0.025], abs=1e-4)


def test_what_is_derived_of_the_pandas_hand_is_what_is_known_of_it() -> None:
    constants = {field.name: getattr(PANDA, field.name) for field in fields(ArmConstants)}
    hand = GripperSetup("parallel", PANDA.gripper.actuator, force=15, open=0.08)
    arm = ImportedArm(mjcf=panda_spec, gripper=hand, **constants)
    found, known = arm.robot().gripper, PANDA.gripper
    assert found.pads == tuple(PREFIX + pad for pad in known.pads)
    for size in ("finger_depth_m", "finger_half_width_m", "fingertip_m", "palm_height_m", "palm_half_width_m"):
        assert getattr(found, size) == pytest.approx(getattr(known, size), abs=0.006), size
    assert found.squeeze_m == pytest.approx(known.squeeze_m, abs=1e-3)
    assert found.command(0.03) == pytest.approx(0.03, abs=1e-4)


def test_the_motor_has_the_force_that_the_table_says(setup: RobotSetup) -> None:
    spec = robot_for(setup).spec()
    # The gear turns a width of 1 m into a length of 100.
    assert np.abs(spec.actuator(PREFIX + "fingers").forcerange) == pytest.approx([0.2, 0.2], rel=0.02)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mjcf": "none.xml"}, "robot.mjcf: .*none.xml: no such file"),
        ({"mjcf": "x" * 300}, "robot.mjcf: .*xxx: no such file"),
        ({"joints": ("turn", "lfit")}, r"robot: .*crane.xml: no joint 'lfit' in its MJCF \(did you mean 'lift'\?\)"),
        ({"joints": ("lift", "turn")}, "the joint 'turn' is not behind 'lift'"),
        ({"tool": "top"}, r"robot: .*crane.xml: no site 'top' in its MJCF \(did you mean 'tip'\?\)"),
        ({"home": (0.0, 0.7)}, "robot.home: 0.7 is not from 0 to 0.6, the range of 'lift'"),
        ({"open": 0.2}, "the fingers should open from 0 to 0.2 m, but their range is -?0.000 to 0.076 m"),
        ({"kind": "suction"}, "the actuator 'fingers' is no adhesion actuator"),
        ({"actuator": "motor"}, "the actuator 'motor' of the gripper drives 'turn', a joint of the arm"),
        (
            {
                "joints": ("turn", "lift", "left"),
                "home": (0.0, 0.4, 0.0),
                "velocity": (1.0, 1.0, 1.0),
                "torque": (200.0, 400.0, 1.0),
            },
            "the actuator 'fingers' is not moved by 'left', the last joint",
        ),
    ],
)
def test_what_does_not_fit_the_mjcf_is_told(setup: RobotSetup, change: dict[str, object], words: str) -> None:
    assert setup.gripper is not None
    hand = {key: value for key, value in change.items() if hasattr(setup.gripper, key)}
    rest = {key: value for key, value in change.items() if key not in hand}
    with pytest.raises(SimulationError, match=words):
        robot_for(replace(setup, gripper=replace(setup.gripper, **hand), **rest))


@pytest.mark.parametrize("force", [0.0, -5.0, float("nan"), 2000.0])
def test_a_force_that_no_gripper_has_is_refused(setup: RobotSetup, force: float) -> None:
    assert setup.gripper is not None
    with pytest.raises(SimulationError, match=r"robot.gripper.force: must be above 0 and at most 500 N, not"):
        check_robot(replace(setup, gripper=replace(setup.gripper, force=force)))


def test_links_inside_each_other_at_home_are_told(setup: RobotSetup, tmp_path: Path) -> None:
    wide = ('size="0.05 0.05 0.4"', 'size="0.5 0.05 0.4"'), ("<body pos", '<body name="left" pos')
    with pytest.raises(SimulationError, match="robot.home: the links 'column' and 'left' are inside each other there"):
        robot_for(changed(setup, tmp_path, *wide))


@pytest.mark.parametrize(
    ("spring", "press"), [("", 0.0003), ('<joint type="slide" axis="0 0 1" stiffness="500"/>', 0.003)]
)
def test_a_cup_is_pressed_as_far_as_it_gives_way(setup: RobotSetup, tmp_path: Path, spring: str, press: float) -> None:
    """Joints of the hand need no name."""
    mjcf = (setup.folder / "crane.xml").read_text().replace('mass="0.02" contype="0" conaffinity="0"', 'mass="0.02"')
    mjcf = mjcf.replace('<body name="cup" pos="0.5 0 0.006">', f'<body name="cup" pos="0.5 0 0.006">{spring}')
    adhesion = '<adhesion name="suck" body="cup" ctrlrange="0 1"/></actuator>'
    (tmp_path / "crane.xml").write_text(mjcf.replace("</actuator>", adhesion))
    hand = GripperSetup("suction", "suck", 30.0)
    gripper = robot_for(replace(setup, gripper=hand, folder=tmp_path)).gripper
    assert isinstance(gripper, SuctionGripper) and gripper.press_m == press


def test_what_only_a_whole_scene_has_is_left_out(
    setup: RobotSetup, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    others = '<size memory="10M" nkey="2"/><visual><map znear="0.05"/></visual><statistic extent="2"/>'
    mjcf = (setup.folder / "crane.xml").read_text().replace("<default>", f"{others}<default>", 1)
    mjcf = mjcf.replace('<geom type="box" size="0.05', '<geom name="a" type="box" size="0.05')
    mjcf = mjcf.replace('<geom type="box" size="0.25', '<geom name="b" type="box" size="0.25')
    pair = '<contact><pair geom1="a" geom2="b"/></contact><tendon>'
    (tmp_path / "crane.xml").write_text(mjcf.replace("<tendon>", pair))
    assert robot_for(replace(setup, folder=tmp_path)).spec().compile().npair == 0
    assert not recwarn.list


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (
            'type="slide" axis="0 0 1" range="0 0.6"',
            'type="ball" range="0 60"',
            "'lift' is neither a hinge nor a slide",
        ),
        ("<equality>", '<equality><joint joint1="turn" joint2="lift"/>', "'turn' and 'lift' of the arm are coupled by"),
    ],
)
def test_joints_that_no_arm_can_have_are_told(
    setup: RobotSetup, tmp_path: Path, before: str, after: str, words: str
) -> None:
    with pytest.raises(SimulationError, match=f"robot: .*crane.xml: the joints? {words}"):
        robot_for(changed(setup, tmp_path, (before, after)))


def test_a_frame_around_the_robot_moves_it(setup: RobotSetup, tmp_path: Path) -> None:
    outer = '<frame pos="0.1 0 0.1" euler="0 0 20"><frame euler="0 0 10">'
    column = '<body name="column" pos="0.2 0 0" euler="0 0 5">'
    framed = changed(
        setup, tmp_path, ('<body name="column">', outer + column), ("</worldbody>", "</frame></frame></worldbody>")
    )
    base = robot_for(framed).spec().compile().body(f"{PREFIX}column")
    assert base.pos == pytest.approx([0.1 + 0.2 * np.cos(np.radians(30)), 0.2 * np.sin(np.radians(30)), 0.1])
    half = np.radians(35) / 2
    assert base.quat == pytest.approx([np.cos(half), 0, 0, np.sin(half)])


def test_springs_at_its_joints_do_not_draw_it_aside(setup: RobotSetup, tmp_path: Path) -> None:
    sprung = changed(setup, tmp_path, ('damping="5"/>', 'damping="5" stiffness="60" springref="-60"/>'))
    assert not robot_for(sprung).spec().compile().jnt_stiffness.any()


def test_what_drives_and_couples_joints_that_are_fixed_goes_with_them(setup: RobotSetup, tmp_path: Path) -> None:
    coupled = changed(
        setup,
        tmp_path,
        ('<body name="column">', '<body name="post"><joint name="rise"/><geom size="0.02"/><body name="column">'),
        ("</worldbody>", "</body></worldbody><sensor><jointpos joint='rise'/></sensor>"),
        ("<tendon>", '<tendon><fixed name="rope"><joint joint="rise" coef="1"/></fixed>'),
        ("<equality>", '<equality><joint joint1="rise" joint2="turn"/>'),
        ("<actuator>", '<actuator><motor joint="rise"/><motor tendon="rope"/>'),
    )
    spec, plain = robot_for(coupled).spec(), robot_for(setup).spec()
    for parts in ("joints", "tendons", "equalities", "actuators"):
        assert [part.name for part in getattr(spec, parts)] == [part.name for part in getattr(plain, parts)]


def test_its_name_is_none_of_the_catalogue(setup: RobotSetup, tmp_path: Path) -> None:
    shutil.copy(setup.folder / "crane.xml", tmp_path / "fetch.xml")
    assert robot_for(replace(setup, mjcf="fetch.xml", folder=tmp_path)).name == "fetch.xml"


def test_an_unknown_name_in_a_scenario_is_told_with_its_key() -> None:
    with pytest.raises(SimulationError, match=r"^robot: unknown name 'pandda' \(did you mean 'panda'\?\)"):
        robot_for(RobotSetup("pandda"))
