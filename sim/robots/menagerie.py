"""MuJoCo Menagerie, downloaded once by robot_descriptions into its cache."""

import contextlib
import importlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

import mujoco

from sim.errors import RobotError

REPOSITORY = "https://github.com/deepmind/mujoco_menagerie.git"
"""Where robot_descriptions downloads from, unless git's settings redirect it."""

ANSWER_TIMEOUT_S = 20
"""How long the repository may take to answer before it counts as unreachable, s."""

GIT_SETTINGS = {"GIT_TERMINAL_PROMPT": "0", "GIT_HTTP_LOW_SPEED_LIMIT": "1000", "GIT_HTTP_LOW_SPEED_TIME": "30"}
"""Git asks for no password, and aborts a download that stays below 1 kB/s for half a minute."""


def unavailable_because() -> str | None:
    """Return why Menagerie is not available here, and how to change that; None if it is."""
    if importlib.util.find_spec("robot_descriptions") is None:
        return "it needs pip install '.[menagerie]', in a clone of prefplan"
    if shutil.which("git") is None:
        return "it is fetched with git, which is not installed"
    if _cached():
        return None
    try:
        # Git itself would wait for minutes.
        subprocess.run(
            ["git", "ls-remote", REPOSITORY, "HEAD"],
            env=os.environ | GIT_SETTINGS,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=True,
            timeout=ANSWER_TIMEOUT_S,
        )
    except subprocess.TimeoutExpired:
        return f"it is not cached and cannot be fetched: {REPOSITORY} does not answer within {ANSWER_TIMEOUT_S} s"
    except subprocess.CalledProcessError as error:
        return f"it is not cached and cannot be fetched: {_summary(error.stderr)}"
    return None


def menagerie_mjcf(description: str) -> mujoco.MjSpec:
    """Return the cached or downloaded MJCF of a robot, such as `panda_mj_description`, with its root at the origin.

    Raises:
        RobotError: robot_descriptions or git is missing, or nothing is cached and the repository is unreachable.
        ValueError: MuJoCo cannot read the MJCF.
    """
    if reason := unavailable_because():
        raise RobotError(reason)
    with patch.dict(os.environ, GIT_SETTINGS), contextlib.redirect_stdout(sys.stderr):
        try:
            path = Path(importlib.import_module(f"robot_descriptions.{description}").MJCF_PATH)
        except Exception as error:  # GitPython's errors share no useful root
            raise RobotError(f"it is not cached and cannot be fetched: {_summary(str(error))}") from None
    if not path.is_file():
        raise RobotError(f"it is not at its expected path, {path}")
    spec = mujoco.MjSpec.from_file(str(path))
    spec.worldbody.first_body().pos = [0, 0, 0]
    return spec


def _cached() -> bool:
    """Return whether robot_descriptions will find Menagerie without using the network."""
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")).expanduser()
    commit = os.environ.get("ROBOT_DESCRIPTION_COMMIT")
    folder = cache / (f"mujoco_menagerie-{commit}/mujoco_menagerie" if commit else "mujoco_menagerie")
    if not os.path.isdir(folder / ".git"):  # unlike that of `Path`, also False if the cache may not be read
        return False
    known = ["git", "-C", str(folder), "cat-file", "-e", f"{commit or 'HEAD'}^{{commit}}"]
    return subprocess.run(known, capture_output=True).returncode == 0


def _summary(message: str) -> str:
    """Return the line of an error that says what is wrong: git's first `fatal:` or `error:`, else the last one."""
    found = re.search(r"(?:fatal|error): (.*?)'?$", message, re.MULTILINE)
    return found[1].strip() if found else (message.strip().splitlines() or ["no reason is given"])[-1]
