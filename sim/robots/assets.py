"""Location of the robot files in the package gymnasium-robotics, which is located but never imported."""

import importlib.util
from pathlib import Path

from sim.errors import RobotError


def asset_folder(name: str) -> Path:
    """Return a folder of the package's assets; raise `RobotError` if the package is not installed."""
    found = importlib.util.find_spec("gymnasium_robotics")
    if found is None or found.origin is None:
        raise RobotError("it needs the package gymnasium-robotics: pip install gymnasium-robotics")
    return Path(found.origin).parent / "envs/assets" / name


def unavailable_because() -> str | None:
    """Return why robots with these files are not available on this machine; None if they are."""
    try:
        asset_folder("")
    except RobotError as error:
        return str(error)
    return None
