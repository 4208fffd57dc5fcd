"""Menagerie's Panda: robot_descriptions' own code, on a git repository made here that stands in for the real one."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from sim.errors import RobotError
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots import import_mjcf
from sim.robots.arms.panda import PANDA, panda_spec
from sim.robots.catalogue import robot_named
from sim.robots.import_mjcf import PREFIX
from sim.robots.menagerie import REPOSITORY, menagerie_mjcf

STAND_IN = Path(__file__).parent / "menagerie"
DESCRIPTION = "robot_descriptions.panda_mj_description"


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false"]
    done = subprocess.run(["git", *identity, *arguments], cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.strip()


def commit(folder: Path) -> str:
    """Commit all there is; return the commit's name."""
    git(folder, "add", "--all")
    git(folder, "commit", "--quiet", "--message", "A stand-in for Menagerie")
    return git(folder, "rev-parse", "HEAD")


@pytest.fixture(scope="module")
def monkeymodule() -> Iterator[pytest.MonkeyPatch]:
    with pytest.MonkeyPatch.context() as patch:
        yield patch


def isolate(patch: pytest.MonkeyPatch, folder: Path, settings: str) -> None:
    """Let git read these settings alone, robot_descriptions start with an empty cache, and no module be left."""
    folder.joinpath("gitconfig").write_text(settings)
    patch.setenv("GIT_CONFIG_GLOBAL", str(folder / "gitconfig"))
    patch.setenv("GIT_CONFIG_NOSYSTEM", "1")
    patch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(folder / "cache"))
    patch.delenv("ROBOT_DESCRIPTION_COMMIT", raising=False)
    patch.delitem(sys.modules, DESCRIPTION, raising=False)
    import_mjcf._imported.cache_clear()


def stand_in(patch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Put a repository where git finds Menagerie's; return its folder."""
    repository = folder / "repository"
    shutil.copytree(STAND_IN, repository)
    git(repository, "init", "--quiet")
    isolate(patch, folder, f'[url "{repository.as_uri()}"]\n\tinsteadOf = {REPOSITORY}\n')
    patch.setenv("ROBOT_DESCRIPTION_COMMIT", commit(repository))
    return repository


@pytest.fixture(scope="module")
def menagerie(tmp_path_factory: pytest.TempPathFactory, monkeymodule: pytest.MonkeyPatch) -> Path:
    """Return the repository's folder; for the whole module `menagerie` is the stand-in."""
    return stand_in(monkeymodule, tmp_path_factory.mktemp("menagerie"))


@pytest.fixture(scope="module")
def panda(menagerie: Path) -> mujoco.MjModel:
    return robot_named("menagerie").spec().compile()


def test_it_is_fetched_without_output_by_robot_descriptions_and_kept_in_its_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    repository = stand_in(monkeypatch, tmp_path)
    folder = Path(menagerie_mjcf("panda_mj_description").modelfiledir)
    out, err = capfd.readouterr()
    assert out == "" and "Cloning" in err
    assert folder.is_relative_to(tmp_path / "cache")
    assert (folder / "panda.xml").read_text() == (repository / "franka_emika_panda/panda.xml").read_text()
    monkeypatch.setenv("GIT_ALLOW_PROTOCOL", "none")
    monkeypatch.delitem(sys.modules, DESCRIPTION)
    again = menagerie_mjcf("panda_mj_description").modelfiledir
    assert Path(again) == folder, "what is cached needs no network"


def test_kinematics_and_limits_are_those_of_our_own_panda(panda: mujoco.MjModel) -> None:
    own = panda_spec().compile()
    for name in (*PANDA.joints, *PANDA.gripper.joints):
        assert panda.joint(PREFIX + name).range == pytest.approx(own.joint(name).range)
    for name in PANDA.joints:
        for field in ("ctrlrange", "forcerange"):
            assert getattr(panda.actuator(PREFIX + name), field) == pytest.approx(getattr(own.actuator(name), field))
    theirs, ours = mujoco.MjData(panda), mujoco.MjData(own)
    rng = np.random.default_rng(1)
    for q in rng.uniform(*own.jnt_range[:7].T, size=(50, 7)):
        theirs.qpos[:7] = ours.qpos[:7] = q
        mujoco.mj_kinematics(panda, theirs)
        mujoco.mj_kinematics(own, ours)
        tool = theirs.site(PREFIX + PANDA.tool)
        # Menagerie rounds the hand's orientation to seven digits.
        assert tool.xpos == pytest.approx(ours.site(PANDA.tool).xpos, abs=1e-7)
        assert tool.xmat == pytest.approx(ours.site(PANDA.tool).xmat, abs=1e-6)


def test_only_pads_boxes_and_hulls_collide_and_no_part_of_the_robot_touches_another(panda: mujoco.MjModel) -> None:
    fingers = {panda.body(f"{PREFIX}{side}_finger").id for side in ("left", "right")}
    colliding = [geom for geom in map(panda.geom, range(panda.ngeom)) if geom.contype[0] or geom.conaffinity[0]]
    pads = {PREFIX + pad for pad in PANDA.gripper.pads}
    assert {geom.name for geom in colliding if int(geom.bodyid[0]) in fingers} == {
        *pads,
        f"{PREFIX}left_finger_shape",
        f"{PREFIX}right_finger_shape",
    }
    assert set(robot_named("menagerie").gripper.pads) == pads
    assert {(int(geom.contype[0]), int(geom.conaffinity[0])) for geom in colliding} == {(2, 1)}
    own = panda_spec().compile()
    for pad in PANDA.gripper.pads:
        for field in ("pos", "size", "friction", "solref", "solimp", "condim", "priority"):
            assert getattr(panda.geom(PREFIX + pad), field) == pytest.approx(getattr(own.geom(pad), field))


def test_its_gripper_is_derived_as_that_of_our_own_panda_is_known(menagerie: Path) -> None:
    theirs, ours = robot_named("menagerie").gripper, PANDA.gripper
    for size in ("opening_m", "squeeze_m", "firm_force_n", "finger_depth_m", "fingertip_m", "palm_height_m"):
        assert getattr(theirs, size) == pytest.approx(getattr(ours, size), abs=0.006), size
    assert theirs.opened(theirs.positions(0.05)) == pytest.approx(0.05, abs=1e-4)


def test_the_arm_of_either_robot_reaches_the_same_way(menagerie: Path) -> None:
    place, robot = np.array([0.5, 0.1, 0.1]), robot_named("menagerie")
    ours, theirs = (Arm(one).reach([ToolPose.down(place, 0.0)])[0] for one in (PANDA, robot))
    assert theirs == pytest.approx(ours, abs=1e-4)


@pytest.mark.parametrize(
    ("settings", "protocol", "message"),
    [
        ("", "none", "cannot be fetched: transport 'https' not allowed; the robot `panda` needs"),
        (f'[url "ext::sleep 30 "]\n\tinsteadOf = {REPOSITORY}\n', "ext", "does not answer within 0.5 s; the robot"),
    ],
)
def test_without_an_answer_and_a_cache_the_error_names_the_default_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, settings: str, protocol: str, message: str
) -> None:
    monkeypatch.setattr("sim.robots.menagerie.ANSWER_TIMEOUT_S", 0.5)
    isolate(monkeypatch, tmp_path, settings)
    monkeypatch.setenv("GIT_ALLOW_PROTOCOL", protocol)
    with pytest.raises(RobotError, match=message):
        robot_named("menagerie")


def test_a_commit_that_does_not_exist_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(monkeypatch, tmp_path)
    monkeypatch.setenv("ROBOT_DESCRIPTION_COMMIT", "1" * 40)
    with pytest.raises(RobotError, match="cannot be fetched: .*1{40}; the robot `panda`"):
        robot_named("menagerie")


def test_missing_robot_descriptions_and_git_are_named(
    menagerie: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import_mjcf._imported.cache_clear()
    with monkeypatch.context() as patch, pytest.raises(RobotError, match=r"pip install '\.\[menagerie\]', in a clone"):
        patch.setitem(sys.modules, "robot_descriptions", None)
        robot_named("menagerie")
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RobotError, match="git, which is not installed; the robot `panda`"):
        robot_named("menagerie")


@pytest.mark.parametrize(
    ("name", "other", "named"),
    [
        ("joint4", "elbow", "no joint 'joint4'"),
        ("actuator8", "grip", "no actuator 'actuator8'"),
        ("<body", "<corpse", "Schema violation|Error"),
    ],
)
def test_another_robot_in_its_place_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, other: str, named: str
) -> None:
    repository = stand_in(monkeypatch, tmp_path)
    path = repository / "franka_emika_panda/panda.xml"
    path.write_text(path.read_text().replace(name, other))
    monkeypatch.setenv("ROBOT_DESCRIPTION_COMMIT", commit(repository))
    with pytest.raises(RobotError, match=f"the robot `menagerie` is not available here: .*(?:{named})"):
        robot_named("menagerie")


def test_an_unknown_robot_is_refused() -> None:
    with pytest.raises(RobotError, match=r"unknown robot 'menagery' \(did you mean 'menagerie'\?\)"):
        robot_named("menagery")
