"""Random scenes, each planned and carried out once: how general the arm's skills are.

Each has three to eight objects (cubes, boxes and cylinders), up to three obstacles, two or three tasks, and about every
third a shelf. Finished scenes are kept: after an interruption, the same command continues. Run it as `python -m
experiments.random_scenes`; it prints a page for `experiments/results/random_scenes.md`, and leaves every scene as a
file for `prefplan run`.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np
from joblib import Parallel, cpu_count, delayed

from experiments.cli.arguments import add_quiet, positive
from experiments.cli.files import make_folder, write_bytes
from experiments.cli.journal import Journal
from experiments.cli.options import add_options
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, INTERRUPTED
from experiments.commands.planning.checkup import check
from experiments.sweep.job import RolloutRecord, Sweep, failure_class, pack, roll_out
from experiments.sweep.recorded import RECORDS
from experiments.sweep.summary import share, wilson
from prefplan.errors import PrefplanError
from prefplan.front import NoPlanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from prefplan.scenario.decode import load
from sim.world.randomization import Perturbation

USUAL = Perturbation()
"""Greatest differences of the start poses."""

NEAR_M, FAR_M, ASIDE_RAD = 0.32, 0.68, 1.0
"""Locations are drawn at distances from the base between these two, and within this angle of straight ahead."""

BETWEEN_LOCATIONS_M, TO_OBSTACLES_M = 0.14, 0.11
"""Least distances of the centre of a location from another one's, and from an obstacle."""

SHELF_DEPTH_M, SHELF_WIDTH_M = 0.24, 0.5

TRIALS = 1000
"""Attempts to place one location or obstacle; if all fail, the whole scene is drawn again."""

REFUSED = "refused"
"""Class of a scene that `prefplan check` refuses."""


class Drawing:
    """A random scene, as the lines of its scenario file."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw a scene."""
        self._rng = rng
        self._taken: list[tuple[np.ndarray, np.ndarray]] = []
        """Centres and half sides of the boxes that are occupied, m."""
        self.fixtures: list[str] = []
        self.locations: dict[str, str] = {}
        self.objects: dict[str, str] = {}
        self.tasks: list[str] = []
        if rng.random() < 1 / 3:
            self._add_shelf()
        for k in range(rng.integers(4)):
            self._add_obstacle(f"wall{k}")
        count = int(rng.integers(3, 9))
        for k in range(count + int(rng.integers(1, 4)) - len(self.locations)):
            self.locations[f"p{k}"] = self._at(self._free(np.zeros(2), BETWEEN_LOCATIONS_M / 2))
        starts = rng.permutation([*self.locations])[:count]
        for k, start in enumerate(starts):
            self.objects[f"o{k}"] = f'start = "{start}", {self._shape()}'
        free = rng.permutation([name for name in self.locations if name not in starts])
        self._add_tasks([str(place) for place in free])

    def text(self) -> str:
        """Return the scenario file."""

        def table(name: str, entries: dict[str, str]) -> list[str]:
            return ["", f"[model.{name}]", *(f"{key} = {{ {value} }}" for key, value in entries.items())]

        lines = ["[model]", 'kind = "manipulation"', 'start = "home"']
        lines += ["costs = { transit = 3, grasp = 1, transport = 5, release = 1 }"]
        lines += ["", "[model.fixtures]", *self.fixtures] if self.fixtures else []
        lines += table("locations", self.locations) + table("objects", self.objects)
        for k, formula in enumerate(self.tasks):
            lines += ["", "[[tasks]]", f'name = "task{k}"', f'formula = "{formula}"']
        return "\n".join([*lines, "", "[preference]", 'kind = "order"', ""])

    @staticmethod
    def _at(point: np.ndarray) -> str:
        return f"at = [{', '.join(f'{value:.3f}' for value in point)}]"

    def _free(self, half: np.ndarray, margin: float) -> np.ndarray:
        """Draw a centre for a box with these half sides, `margin` away from everything, and mark it occupied, m."""
        for _ in range(TRIALS):
            radius, angle = self._rng.uniform(NEAR_M, FAR_M), self._rng.uniform(-ASIDE_RAD, ASIDE_RAD)
            point = radius * np.array([np.cos(angle), np.sin(angle)])
            if all(np.any(abs(point - middle) > half + margin + sides) for middle, sides in self._taken):
                self._taken.append((point, half + margin))
                return point
        raise NoRoomError

    def _add_shelf(self) -> None:
        """Add a shelf on one side that is open towards the arm, with a location on each board."""
        side = self._rng.choice([-1, 1])
        middle, board = np.array([0.62, 0.3 * side]), self._rng.uniform(0.22, 0.3)
        size = f"[{SHELF_DEPTH_M}, {SHELF_WIDTH_M}, {board + 0.2:.3f}]"
        self.fixtures.append(
            f'shelf = {{ kind = "shelf", {self._at(np.array([*middle, 0.0]))}, size = {size}, yaw = 180, '
            f"boards = [0.0, {board:.3f}] }}"
        )
        front = middle - [0.07, 0]
        self.locations["low"] = self._at(front + [0, 0.09])
        self.locations["high"] = self._at(np.array([*front, board]))
        self._taken.append((middle, np.array([SHELF_DEPTH_M, SHELF_WIDTH_M]) / 2 + 0.08))

    def _add_obstacle(self, name: str) -> None:
        """Add a wall or a block with a random yaw."""
        # The centre of a box of whole centimetres is written exactly, in millimetres.
        size = np.round(self._rng.uniform([0.02, 0.05, 0.05], [0.1, 0.25, 0.3]), 2)
        half = np.full(2, np.hypot(*size[:2]) / 2)
        point = self._free(half, TO_OBSTACLES_M - BETWEEN_LOCATIONS_M / 2)
        size_text = ", ".join(f"{side:.3f}" for side in size)
        self.fixtures.append(
            f'{name} = {{ kind = "box", {self._at(np.array([*point, size[2] / 2]))}, size = [{size_text}], '
            f"yaw = {self._rng.uniform(0, 180):.0f} }}"
        )

    def _shape(self) -> str:
        """Return a cube, a box or a cylinder that the hand can span."""
        kind = self._rng.choice(["cube", "box", "cylinder"])
        if kind == "cube":
            return 'kind = "cube"'
        low, high = ([0.03] * 3, [0.06, 0.06, 0.1]) if kind == "box" else ([0.03, 0.03], [0.06, 0.1])
        size = ", ".join(f"{side:.3f}" for side in self._rng.uniform(low, high))
        return f'kind = "{kind}", size = [{size}]'

    def _add_tasks(self, free: list[str]) -> None:
        """Add two or three tasks: move an object to a free location, and in a third of them another one after it."""
        moved = self._rng.permutation([*self.objects])
        for k in range(min(int(self._rng.integers(2, 4)), len(moved))):
            goal = free[k % len(free)]
            formula = f"F {moved[k]}_{goal}"
            if self._rng.random() < 1 / 3:
                formula = f"F ({moved[k]}_{goal} & X F {moved[(k + 1) % len(moved)]}_{goal})"
            self.tasks.append(formula)


class NoRoomError(Exception):
    """A scene has no room for another location or obstacle."""


def scene_text(seed: int, number: int) -> str:
    """Return the scenario file of a scene, a pure function of the seed and the number."""
    for attempt in range(TRIALS):
        try:
            return Drawing(np.random.default_rng([seed, number, attempt])).text()
        except NoRoomError:
            continue
    raise AssertionError("no scene was drawn")


def carry_out(seed: int, number: int, folder: Path) -> RolloutRecord:
    """Draw and check a scene, carry its cheapest plan out if the check finds no fault, and return the record."""
    path = folder / f"scene_{number}.toml"
    write_bytes(path, scene_text(seed, number).encode())
    heading = {"scene": number, "replay": f"prefplan run {path} --seed {seed}"}
    scenario = load(path)
    try:
        found = check(scenario)
    except PrefplanError as error:
        return heading | {"class": REFUSED, "reason": str(error)}
    model = scenario.model
    assert isinstance(model, ManipulationModel)
    if found.faults or found.impossible:
        reason = found.faults[0] if found.faults else f"task {found.impossible[0]} cannot be satisfied"
        return heading | {"class": REFUSED, "reason": failure_class(reason, model)}
    try:
        plan = Planner(scenario.problem()).cheapest()
    except NoPlanError:
        return heading | {"class": REFUSED, "reason": "the tasks cannot be satisfied together"}
    sweep = Sweep(pack(scenario), str(path), "cost", plan, seed, USUAL, None, folder)
    return roll_out(sweep, number) | {"scene": number, "objects": len(model.objects), "fixtures": len(model.fixtures)}


def markdown(records: Sequence[RolloutRecord], seed: int) -> str:
    """Return the results as a page."""
    feasible = [record for record in records if record["class"] != REFUSED]
    completed = [record for record in feasible if record["completed"]]
    low, high = wilson(len(completed), len(feasible)) or (0.0, 1.0)
    rows = {
        "scenes": len(records),
        "refused by `prefplan check`": len(records) - len(feasible),
        "completed, of the others": f"{share(len(completed), len(feasible))} [{low:.1%}, {high:.1%}]",
        "wrongly called completed": sum(record["wrongly_completed"] for record in feasible),
        "with an unwanted contact": sum(record.get("contacts", 0) > 0 for record in feasible),
        "certificates that hold": sum(bool(record["certified"]) for record in feasible),
    }
    refusals = Counter(record["reason"] for record in records if record["class"] == REFUSED)
    failures = [record for record in feasible if not record["completed"] or record["refuted"]]
    return "\n".join(
        [
            "# Random scenes, each carried out once",
            "",
            f"`python -m experiments.random_scenes --scenes {len(records)} --seed {seed}`, MuJoCo "
            f"{version('mujoco')}: three to eight cubes, boxes and cylinders, up to three obstacles, a shelf in about "
            f"every third scene, two or three tasks, and start poses perturbed by {USUAL} (mm and degrees). Brackets: "
            "95 % interval (Wilson).",
            "",
            *("| | |", "| --- | --- |"),
            *(f"| {name} | {value} |" for name, value in rows.items()),
            "",
            *(["Refused:", ""] if refusals else []),
            *(f"- {count} x {why}" for why, count in refusals.most_common()),
            *([*([""] if refusals else []), "Failed:", ""] if failures else []),
            *(f"- {record['reason'] or '; '.join(record['refuted'])}: `{record['replay']}`" for record in failures),
        ]
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry out the scenes without a record, print the page and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=positive, default=200, metavar="N", help="how many (default: 200)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the scenes (default: 0)")
    parser.add_argument("--out", type=Path, default=Path("out/random_scenes"), help="records (default: %(default)s)")
    add_options(parser, "--jobs")
    add_quiet(parser)
    options = parser.parse_args(arguments)
    make_folder(options.out)
    about = {"prefplan": version("prefplan"), "mujoco": version("mujoco"), "seed": options.seed}
    with Journal(options.out / RECORDS, about, key="scene") as records, Bars(quiet=options.quiet) as bars:
        missing = [number for number in range(options.scenes) if number not in records.done]
        jobs = Parallel(n_jobs=options.jobs or cpu_count(), return_as="generator_unordered")
        try:
            done = jobs(delayed(carry_out)(options.seed, number, options.out) for number in missing)
            for count, record in enumerate(done, options.scenes - len(missing) + 1):
                records.add(record)
                bars("carrying out", count, options.scenes, "")
        except KeyboardInterrupt:
            print("interrupted; the same command continues", file=sys.stderr)
            return INTERRUPTED
        print(markdown([records.done[number] for number in range(options.scenes)], options.seed))
    return DONE


if __name__ == "__main__":
    sys.exit(main())
