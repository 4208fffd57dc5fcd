"""The scenario files that ship, found by name or path."""

from prefplan.scenario.decode import load as find
from prefplan.scenario.files import FOLDER, names

__all__ = ["FOLDER", "find", "names"]
