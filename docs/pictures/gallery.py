"""The gallery: every scenario that ships, with its picture, its front and commands to try.

As an extension of Sphinx it writes the sections when the pages are built; called as a program it makes the pictures.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from frames import taken
from PIL import Image
from sphinx.application import Sphinx

from experiments import scenarios
from experiments.figures import maps, plans
from experiments.figures.figures import write_figure
from experiments.runs.run_plan import run_plan, scene_of
from experiments.scenarios import introduction
from prefplan import Front, Scenario, pareto_front
from prefplan.plan import PAIR
from prefplan.scenario.decode import load
from prefplan.text.layout import number

PICTURES = Path(__file__).parents[1] / "gallery"

WIDTH = 880
"""Width of a picture, pixels."""

QUALITIES = (78, 55, 40, 30)
"""Qualities of the WebP files: the first that is small enough."""

MOST_BYTES = 45_000
"""Bytes of a picture."""

MAP_SIDE = 7.5
"""Longer side of a map that is a picture of its own, inches, with text of 9 points."""

COMMANDS = {
    "graph": "prefplan draw plans {0} {0}.pdf\nprefplan report {0}",
    "grid": "prefplan draw plans {0} {0}.pdf\nprefplan report {0}",
    "manipulation": "prefplan run {0} --plan preference\nprefplan report {0}",
}
"""What to try with a scenario of each kind."""


def main() -> None:
    """Make the picture of every scenario: maps of its plans, or the preferred plan on the map or carried out."""
    PICTURES.mkdir(exist_ok=True)
    for name in scenarios.names():
        scenario = load(name)
        front = front_of(scenario)
        if scenario.model.kind == "manipulation":
            scene = scene_of(scenario)
            picture = taken(scenario, scene, run_plan(scenario, scene, front[-1]))
        elif scenario.model.kind == "graph":
            picture = _preferred(scenario, front)
        else:
            picture = _maps(scenario, front)
        save(picture, PICTURES / f"{name}.webp")


def front_of(scenario: Scenario) -> Front:
    """Return the front that a section shows."""
    return pareto_front(scenario.problem())


def save(picture: Image.Image, file: Path) -> None:
    """Write a picture as a small file."""
    picture.thumbnail((WIDTH, picture.height), Image.Resampling.LANCZOS)
    for quality in QUALITIES:
        picture.save(file, quality=quality, method=6)
        if file.stat().st_size <= MOST_BYTES:
            return


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the sections to the page `gallery` as Sphinx reads it."""
    app.connect("source-read", _add_sections)
    return {"parallel_read_safe": True}


def section(scenario: Scenario) -> str:
    """Return what the page says of a scenario."""
    name, tasks = scenario.name, [task.name for task in scenario.tasks]
    front = front_of(scenario)
    objectives = ["cost", "penalty"] if front.objectives == PAIR else front.objectives
    rows = [["plan", *objectives, *tasks], ["---:"] * (1 + len(objectives) + len(tasks))]
    for i, plan in enumerate(front):
        rows.append([str(i), *map(number, (*plan.objectives.values(), *plan.task_costs.values()))])
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    commands = COMMANDS[scenario.model.kind].format(name)
    return (
        f"## {name}\n\n{introduction(scenario.text)}\n\n![{name}](gallery/{name}.webp)\n\n{table}\n\n"
        f"```sh\nprefplan front {name}\n{commands}\n```\n"
    )


def _add_sections(app: Sphinx, page: str, source: list[str]) -> None:
    if page != "gallery":
        return
    for name in scenarios.names():
        scenario = load(name)
        app.env.note_dependency(scenario.path)
        source[0] += f"\n{section(scenario)}"


def _preferred(scenario: Scenario, front: Front) -> Image.Image:
    plan_map = maps.map_of(scenario)
    assert plan_map is not None
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "map.png")
        with maps.drawn(plan_map, front[-1], MAP_SIDE) as figure:
            write_figure(figure, file)
        return Image.open(file).convert("RGB")


def _maps(scenario: Scenario, front: Front) -> Image.Image:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "maps.png")
        plans.draw(scenario, front, file)
        return Image.open(file).convert("RGB")


if __name__ == "__main__":
    main()
