"""MuJoCo Menagerie, downloaded once by robot_descriptions into its cache."""

from __future__ import annotations

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

from sim.errors import RobotError

REPOSITORY = "https://github.com/deepmind/mujoco_menagerie.git"
"""Where robot_descriptions downloads from, unless git's settings redirect it."""

ANSWER_TIMEOUT_S = 20
"""How long the repository may take to answer before it counts as unreachable, s."""

GIT_SETTINGS = {"GIT_TERMINAL_PROMPT": "0", "GIT_HTTP_LOW_SPEED_LIMIT": "1000", "GIT_HTTP_LOW_SPEED_TIME": "30"}
"""Git asks for no password, and aborts a download that stays below 1 kB/s for half a minute."""

INSTALL = "pip install '.[menagerie]', in a clone of prefplan"

ALTERNATIVE = "the robot `panda` needs no download"


def hindrance() -> str | None:
    """Return why Menagerie is not available here, and how to change that; None if it is."""
    if importlib.util.find_spec("robot_descriptions") is None:
        return f"it needs {INSTALL}"
    if shutil.which("git") is None:
        return "it is fetched with git, which is not installed"
    if _cached():
        return None
    with patch.dict(os.environ, GIT_SETTINGS):
        try:
            _check_reachable()
        except ConnectionError as error:
            return f"it is not cached and cannot be fetched: {_summary(error)}"
    return None


def fetch(description: str, robot: str) -> Path:
    """Return the path of a robot's MJCF: from robot_descriptions' cache, else downloaded into it.

    Args:
        description: its module of robot_descriptions, such as `panda_mj_description`.
        robot: its name here, for messages.

    Raises:
        RobotError: robot_descriptions or git is missing, or nothing is cached and the repository is unreachable.
    """
    with patch.dict(os.environ, GIT_SETTINGS), contextlib.redirect_stdout(sys.stderr):
        try:
            if not _cached():
                _check_reachable()
            module = importlib.import_module(f"robot_descriptions.{description}")
        except ModuleNotFoundError:
            raise RobotError(f"the robot `{robot}` needs: {INSTALL}; {ALTERNATIVE}") from None
        except FileNotFoundError:
            raise RobotError(
                f"the robot `{robot}` is fetched with git, which is not installed; {ALTERNATIVE}"
            ) from None
        except Exception as error:
            # GitPython's errors share no useful root, and it must not be imported where git is missing.
            raise RobotError(
                f"the robot `{robot}` is not cached and cannot be fetched: {_summary(error)}; {ALTERNATIVE}"
            ) from None
    path = Path(module.MJCF_PATH)
    if not path.is_file():
        raise RobotError(f"the robot `{robot}` is not at its expected path, {path}; {ALTERNATIVE}")
    return path


def _cached() -> bool:
    """Return whether robot_descriptions will find Menagerie without using the network."""
    cache = Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")).expanduser()
    commit = os.environ.get("ROBOT_DESCRIPTION_COMMIT")
    folder = cache / (f"mujoco_menagerie-{commit}/mujoco_menagerie" if commit else "mujoco_menagerie")
    if not (folder / ".git").is_dir():
        return False
    known = ["git", "-C", str(folder), "cat-file", "-e", f"{commit or 'HEAD'}^{{commit}}"]
    return subprocess.run(known, capture_output=True).returncode == 0


def _check_reachable() -> None:
    """Raise `ConnectionError` unless the repository answers soon: git itself would wait for minutes."""
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
