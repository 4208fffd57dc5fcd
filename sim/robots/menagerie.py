"""The Panda of MuJoCo Menagerie, fetched by robot_descriptions and given the names and the grip of our own."""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import mujoco

from sim.errors import RobotError
from sim.geometry.mjcf import HIDDEN
from sim.robots.panda import PANDA, panda_spec
from sim.robots.robot import check_parts

REPOSITORY = "https://github.com/deepmind/mujoco_menagerie.git"
"""Where robot_descriptions fetches from; git's own settings may send it elsewhere."""

ANSWER_TIMEOUT_S = 20
"""How long the repository may take to answer before it counts as out of reach, s."""

GIT_SETTINGS = {"GIT_TERMINAL_PROMPT": "0", "GIT_HTTP_LOW_SPEED_LIMIT": "1000", "GIT_HTTP_LOW_SPEED_TIME": "30"}
"""Git asks for no password, and gives a download up that falls below 1 kB/s for half a minute."""

FINGERS = ("left_finger", "right_finger")

ALTERNATIVE = "the robot `default` needs no download"


def menagerie_spec(meshes: bool | None = None) -> mujoco.MjSpec:
    """Return Menagerie's Panda with the names of our own; it has its own meshes, whatever is asked for.

    Bodies, inertia, joints, limits, arm gains and shapes are Menagerie's. Ours are the names of the actuators, gravity
    compensation, the tool's site, the gripper's command in metres with a force that holds a block (Menagerie's own
    presses a 45 mm block with a third of a newton), and what of the fingers touches: one stiff box each and a pad.

    Raises:
        RobotError: it cannot be fetched, or is not the robot that is expected.
    """
    path = fetch()
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        check_parts(spec, joint=PANDA.joints + PANDA.gripper.joints, body=(PANDA.base, "hand", *FINGERS))
        driven = {actuator.target for actuator in spec.actuators}
        for name in (*PANDA.joints, "split"):
            if name not in driven:
                raise RobotError(f"no actuator of {name!r} in its MJCF")
    except (ValueError, RobotError) as error:
        raise RobotError(f"{path}: the robot `menagerie` is not as expected: {error}; {ALTERNATIVE}") from None
    for element in (*spec.keys, *spec.lights):
        spec.delete(element)
    _name_actuators(spec)
    _set_grip(spec)
    _set_contacts(spec)
    spec.body("hand").add_site(name=PANDA.tool, pos=panda_spec(meshes=False).site(PANDA.tool).pos)
    for name in PANDA.joints + PANDA.gripper.joints:
        spec.joint(name).parent.gravcomp = 1
    spec.body("hand").gravcomp = 1
    return spec


def fetch() -> Path:
    """Return the path of Menagerie's `panda.xml`: from robot_descriptions' cache, else downloaded into it.

    Raises:
        RobotError: robot_descriptions or git is missing, or nothing is cached and the repository out of reach.
    """
    with patch.dict(os.environ, GIT_SETTINGS), contextlib.redirect_stdout(sys.stderr):
        try:
            if not _cached():
                _check_reachable()
            module = importlib.import_module("robot_descriptions.panda_mj_description")
        except ModuleNotFoundError:
            install = "pip install '.[menagerie]', in a clone of prefplan"
            raise RobotError(f"the robot `menagerie` needs: {install}; {ALTERNATIVE}") from None
        except FileNotFoundError:
            raise RobotError(
                f"the robot `menagerie` is fetched with git, which is not installed; {ALTERNATIVE}"
            ) from None
        except Exception as error:
            # GitPython's errors share no useful root, and it must not be imported where git is missing.
            raise RobotError(
                f"the robot `menagerie` is not cached and cannot be fetched: {_summary(error)}; {ALTERNATIVE}"
            ) from None
    path = Path(module.MJCF_PATH)
    if not path.is_file():
        raise RobotError(f"the robot `menagerie` is not where it should be, {path}; {ALTERNATIVE}")
    return path


def _cached() -> bool:
    """Return whether robot_descriptions will find what it wants without asking the network."""
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")).expanduser()
    commit = os.environ.get("ROBOT_DESCRIPTION_COMMIT")
    folder = cache / (f"mujoco_menagerie-{commit}/mujoco_menagerie" if commit else "mujoco_menagerie")
    if not (folder / ".git").is_dir():
        return False
    known = ["git", "-C", str(folder), "cat-file", "-e", f"{commit or 'HEAD'}^{{commit}}"]
    return subprocess.run(known, capture_output=True).returncode == 0


def _check_reachable() -> None:
    """Raise an error unless the repository answers soon: git itself waits minutes for a silent network."""
    try:
        ask = ["git", "ls-remote", REPOSITORY, "HEAD"]
        subprocess.run(
            ask, capture_output=True, text=True, timeout=ANSWER_TIMEOUT_S, check=True, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        raise ConnectionError(f"{REPOSITORY} does not answer within {ANSWER_TIMEOUT_S} s") from None
    except subprocess.CalledProcessError as error:
        raise ConnectionError(error.stderr) from None


def _summary(error: Exception) -> str:
    """Return the line of an error that says what is wrong: git's first `fatal:` or `error:`, else the last one."""
    told = re.search(r"(?:fatal|error): (.*?)'?$", str(error), re.MULTILINE)
    return told[1].strip() if told else (str(error).strip().splitlines() or [type(error).__name__])[-1]


def _name_actuators(spec: mujoco.MjSpec) -> None:
    for actuator in spec.actuators:
        actuator.name = actuator.target if actuator.target in PANDA.joints else PANDA.gripper.actuator


def _set_grip(spec: mujoco.MjSpec) -> None:
    """Let the gripper's command be the width between the pads, with the stiffness of our own gripper.

    Its tendon `split` is half the width long and gives each finger half of its force; ours is the width and gives
    all. Hence twice the force per command, four times per length.
    """
    own = panda_spec(meshes=False).actuator(PANDA.gripper.actuator)
    gripper = spec.actuator(PANDA.gripper.actuator)
    gripper.gainprm[0] = 2 * own.gainprm[0]
    gripper.biasprm[:3] = 4 * own.biasprm[:3]
    gripper.ctrlrange = [0.0, PANDA.gripper.opening_m]
    gripper.forcerange = 2 * own.forcerange


def _set_contacts(spec: mujoco.MjSpec) -> None:
    """Keep the robot's shapes from touching one another, and give the fingers our boxes and pads."""
    for geom in list(spec.geoms):
        if not geom.contype and not geom.conaffinity:
            continue
        if geom.parent.name in FINGERS:
            spec.delete(geom)
        else:
            geom.contype, geom.conaffinity, geom.group = 2, 1, HIDDEN
    own = panda_spec(meshes=False)
    for finger in FINGERS:
        for source in own.body(finger).geoms:
            geom = spec.body(finger).add_geom(name=source.name, type=source.type, size=source.size, pos=source.pos)
            geom.contype, geom.conaffinity, geom.group = source.contype, source.conaffinity, HIDDEN
            geom.friction, geom.condim, geom.priority = source.friction, source.condim, source.priority
            geom.solref, geom.solimp = source.solref, source.solimp


MENAGERIE_PANDA = replace(PANDA, name="menagerie", mjcf=menagerie_spec)
