"""Where the files of robots are that other packages bring."""

import importlib.util
from pathlib import Path


def asset_folder(name: str) -> Path | None:
    """Return a folder of gymnasium-robotics' assets, or None if they are not installed."""
    found = importlib.util.find_spec("gymnasium_robotics")
    if found is None or not found.submodule_search_locations:
        return None
    folder = Path(found.submodule_search_locations[0], "envs/assets", name)
    return folder if folder.is_dir() else None


def mesh_folder() -> Path | None:
    """Return the folder with the Panda's `visual` and `collision` STL files, or None if they are not installed."""
    return asset_folder("kitchen_franka/franka_assets/meshes")
