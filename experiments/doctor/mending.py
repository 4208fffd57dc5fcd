"""The one command that installs what is missing, on the systems for which it is known."""

from __future__ import annotations

import platform
import shlex
import sys

SYSTEM_PACKAGES = {
    "egl": {
        "debian": "sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri",
        "fedora": "sudo dnf install mesa-libEGL mesa-dri-drivers",
    },
    "glfw": {
        "debian": "sudo apt-get install libgl1 libglx-mesa0 libgl1-mesa-dri",
        "fedora": "sudo dnf install mesa-libGL mesa-dri-drivers",
    },
    "osmesa": {
        "debian-12": "sudo apt-get install libosmesa6",
        "ubuntu-22.04": "sudo apt-get install libosmesa6",
        "ubuntu-24.04": "sudo apt-get install libosmesa6",
    },
    "browser": {
        "debian": "sudo apt-get install chromium",
        "ubuntu": "sudo snap install chromium",
        "fedora": "sudo dnf install chromium",
        "macos": "brew install --cask google-chrome",
    },
}
"""By what is missing and by system. Where no command is known to be right none is named; newer Mesas have no OSMesa."""


def system_family() -> tuple[str, ...]:
    """Return what this system is called in `SYSTEM_PACKAGES`, the most particular name first."""
    if sys.platform == "darwin":
        return ("macos",)
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        return ()
    name = release.get("ID", "")
    return (f"{name}-{release.get('VERSION_ID', '')}", name, *release.get("ID_LIKE", "").split())


def installs(what: str) -> str | None:
    """Return the command that installs a part of the system, or None where it is not known."""
    commands = SYSTEM_PACKAGES[what]
    return next((commands[name] for name in system_family() if name in commands), None)


def pip_installs(*requirements: str) -> str:
    """Return the command that installs Python packages beside prefplan."""
    return shlex.join([sys.executable, "-m", "pip", "install", *requirements])
