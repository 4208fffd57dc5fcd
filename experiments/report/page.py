"""The report's folder: the page, its scripts and style."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.cli.browser import template
from experiments.cli.files import make_folder, write_bytes
from experiments.figures.diagrams import node_link
from experiments.report import pictures
from experiments.report.data import page_data
from experiments.report.preference_words import in_words
from experiments.scenarios import introduction
from prefplan import Front, Scenario

if TYPE_CHECKING:
    from experiments.report.recordings import Recording

PARTS = "page"
"""Folder of the page's parts, in this package and in the report."""

INDEX = "index.html"

SCRIPTS = ("dom", "clock", "timeline", "pictures", "chart", "wishes", "scene", "panel", "report")
"""The page's scripts, each after those that it uses."""


def write_page(
    scenario: Scenario,
    front: Front,
    recordings: Mapping[int, Recording],
    folder: Path,
    *,
    notices: tuple[str, ...] = (),
) -> Path:
    """Write a report's page and all that it needs besides videos and logs; return its path.

    Recordings are of some plans, by their numbers on the front; their files must be in the folder. Notices are
    sentences for the reader.

    Raises:
        PrefplanError: a file cannot be written.
    """
    make_folder(folder / PARTS)
    for part in files(__package__).joinpath(PARTS).iterdir():
        if part.name.endswith((".js", ".css")):
            write_bytes(folder / PARTS / part.name, part.read_bytes())
    if recordings:
        # Imported late: it loads MuJoCo, which the page of a grid does not need.
        from experiments.report.scene import write_scene

        write_scene(recordings, folder / PARTS)
    if node_link.program() is None:
        notices = (*notices, "Automata are tables, and plans on graphs have no pictures: Graphviz is not installed.")
    if front.ended is not None:
        missing = f"The search was not completed ({front.ending}). There may be plans that cost more and are preferred."
        notices = (missing, *notices)
    problem, data = scenario.problem(), page_data(scenario, front, recordings) | {"scene": bool(recordings)}
    text = template(__package__, f"{PARTS}/index.html").render(
        name=scenario.name,
        about=introduction(scenario.text),
        preferences=[(one, in_words(one.preference, problem.names, problem.display)) for one in problem.preferences],
        costs=[problem.cost_names[one.cost] for one in problem.objectives],
        front=front,
        reason=front.reason,
        tasks=data["tasks"],
        pictures=pictures.automata(problem) | pictures.plans(scenario, front, folder / PARTS),
        notices=notices,
        data=data,
        scripts=SCRIPTS,
    )
    write_bytes(folder / INDEX, text.encode())
    return folder / INDEX
