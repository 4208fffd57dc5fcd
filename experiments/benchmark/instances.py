"""Instances of the paper's benchmark: tasks F(a & F(b) & F(c)) on a 10 x 10 grid, preferred in the order listed."""

import random
import re
from collections.abc import Iterator, Sequence

from experiments.benchmark.published import FORMULAS, KNOWN_FRONTS
from prefplan import Front, GridModel, Order, Problem, Task
from prefplan.models.grid import Cell
from prefplan.plan import point_of

SIZE = 10

Points = list[list[float]]
"""Cost and preference of every point of a front."""

RANDOM, PAPER = "random cells", "paper's formulas"
FAMILIES = (RANDOM, PAPER)


def instance(family: str, tasks: int, seed: int) -> Problem:
    """Return an instance: tasks on three random cells each, or the first of the paper's formulas, shuffled."""
    if family == RANDOM:
        draw = random.Random(f"{tasks} tasks, seed {seed}")
        cells = [divmod(cell, SIZE) for _ in range(tasks) for cell in draw.sample(range(SIZE * SIZE), 3)]
        return on_grid([formula(*cells[3 * i : 3 * i + 3]) for i in range(tasks)])
    formulas = list(FORMULAS)
    random.Random(f"ordering {seed}").shuffle(formulas)
    return on_grid(formulas[:tasks])


def formula(a: Cell, b: Cell, c: Cell) -> str:
    """Return the task to visit a, and then b and c in either order."""
    return "F(x{}y{} & F(x{}y{}) & F(x{}y{}))".format(*a, *b, *c)


def on_grid(formulas: Sequence[str]) -> Problem:
    """Return a problem on a grid with unit costs, from (0, 0); a proposition such as `x3y5` names a cell."""
    named = {name: (int(x), int(y)) for text in formulas for name, x, y in re.findall(r"(x(\d)y(\d))", text)}
    model = GridModel((SIZE, SIZE), (0, 0), regions={name: [cell * 2] for name, cell in named.items()})
    tasks = [Task(f"phi{i}", text) for i, text in enumerate(formulas, start=1)]
    return Problem(model.transition_system(), tasks, Order())


def known() -> Iterator[tuple[str, Problem, Points]]:
    """Yield the instances whose fronts are known: the line of `KNOWN_FRONTS`, the instance and its front."""
    for line in KNOWN_FRONTS.split("\n")[1:-1]:
        tasks, _, front = line.partition(": ")
        cells = [[(int(xy[0]), int(xy[1])) for xy in task.split()] for task in tasks.split(",")]
        points = [[float(cost), float(mu)] for cost, mu in re.findall(r"\((\d+),(\d+)\)", front)]
        yield line, on_grid([formula(*abc) for abc in cells]), points


def points(front: Front) -> Points:
    """Return the points of a front, every cost and preference of each."""
    return [[*map(float, point_of(plan))] for plan in front]
