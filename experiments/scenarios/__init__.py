"""The scenario files that ship: their names and folder; `prefplan.load` reads one."""

from prefplan.scenario.files import FOLDER, names

__all__ = ["FOLDER", "names"]
