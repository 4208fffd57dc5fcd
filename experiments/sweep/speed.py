"""Where the CPU time of a run goes, on one core: physics, motion planning, sensing and recording.

Run it as `python -m experiments.sweep.speed`, on an otherwise idle machine; it prints a page for
`experiments/results/speed.md`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import click
import mujoco
import numpy as np

from experiments.cli.command import call, command
from experiments.cli.status import DONE
from experiments.cli.values import positive
from experiments.runs.run_plan import begin, scene_of
from prefplan.planner import Planner
from prefplan.scenario.decode import load
from sim.motion.kinematics import Arm
from sim.motion.planning import MotionPlanner
from sim.perception.touch import ContactMonitor
from sim.simulation.collision import CollisionChecker
from sim.simulation.recorder import COMMANDS_PER_UNIT, Recorder
from sim.simulation.run import Run
from sim.simulation.workcell import Workcell
from sim.world.scene import Scene, initial_state

PARTS: dict[str, Sequence[tuple[Any, str]]] = {
    "physics (`mj_step`)": [(mujoco, "mj_step")],
    "planning: inverse kinematics and timing": [(Arm, "reach"), (Arm, "move")],
    "planning: collision checks": [(CollisionChecker, name) for name in ("see", "touches", "blockers")],
    "planning: search for paths": [(MotionPlanner, "plan")],
    "sensors": [(Workcell, "latest_pose")],
    "contact monitoring": [(ContactMonitor, "update")],
    "log": [(Recorder, name) for name in ("begin_period", "feel", "record", "end_period")],
}
"""The functions that make up each part of a run, as pairs of an owner and an attribute name."""

REST = "execution, control and the rest"


@command
@click.option("--repeats", type=positive, default="5", metavar="N", help="Of each (default: 5).")
@click.option("--scenario", "scenarios", multiple=True, metavar="NAME", help="Only this one; may be repeated.")
def speed(repeats: int, scenarios: Sequence[str]) -> int:
    """Measure where the time of a run goes, and print the page `experiments/results/speed.md`."""
    columns = {name: measure(name, repeats=repeats) for name in scenarios or ["case_study_3", "kitchen"]}
    print(markdown(columns))
    return DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(speed, "python -m experiments.sweep.speed", arguments)


def measure(name: str, *, repeats: int) -> dict[str, str]:
    """Return a scenario's column of the table as text, by row; times are CPU times, the least of the repeats.

    The ratio of a run to its bare steps is the median over the repeats.
    """
    problem = (scenario := load(name)).problem()
    scene, plan = scene_of(scenario), Planner(problem).cheapest()

    def carried_out() -> Run:
        loop = begin(problem, scene, plan)
        loop.run()
        return loop.record()

    rollout = carried_out()
    # In turns, so that other load on the machine slows both down.
    pairs = np.array([(_seconds(carried_out), _seconds(lambda: _step(scene, rollout))) for _ in range(repeats)])
    whole, bare = pairs.min(axis=0)
    spent = dict.fromkeys(PARTS, 0.0)
    with _timed(spent):
        total = sum(_seconds(carried_out) for _ in range(repeats))
    spent[REST] = total - sum(spent.values())
    shares = {part: f"{spent[part] / total:.1%}" for part in (*PARTS, REST)}
    planning = sum(spent[part] for part in PARTS if part.startswith("planning")) / total
    return {
        "simulated": f"{rollout.sim_seconds:.1f} s",
        "run": f"{whole:.2f} s",
        "times real time": f"{rollout.sim_seconds / whole:.0f}",
        "the same steps, bare": f"{bare:.2f} s",
        "run over bare steps": f"{np.median(pairs[:, 0] / pairs[:, 1]):.2f}",
        **shares,
        "planning in all": f"{planning:.1%}",
    }


def markdown(columns: dict[str, dict[str, str]]) -> str:
    """Return the table."""
    rows = [["", *columns], ["---"] * (1 + len(columns))]
    rows += [[row, *(column[row] for column in columns.values())] for row in next(iter(columns.values()))]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)


def _seconds(function: Callable[[], object]) -> float:
    began = time.thread_time()
    function()
    return time.thread_time() - began


def _step(scene: Scene, rollout: Run) -> None:
    """Simulate the steps of a rollout again, and nothing else."""
    data = initial_state(scene)
    for control in rollout.controls / COMMANDS_PER_UNIT:
        data.ctrl[:] = control
        mujoco.mj_step(scene.mujoco, data)


@contextmanager
def _timed(spent: dict[str, float]) -> Iterator[None]:
    """Add the CPU time of each part, s, without that of the parts that it calls."""
    running = [0.0]
    """Time of the parts that each running one has called."""

    def timed(function: Callable[..., Any], part: str) -> Callable[..., Any]:
        def call(*args: Any, **options: Any) -> Any:
            began = time.thread_time()
            running.append(0.0)
            try:
                return function(*args, **options)
            finally:
                took = time.thread_time() - began
                spent[part] += took - running.pop()
                running[-1] += took

        return call

    functions = [(owner, name, getattr(owner, name)) for part in PARTS.values() for owner, name in part]
    try:
        for part, owned in PARTS.items():
            for owner, name in owned:
                setattr(owner, name, timed(getattr(owner, name), part))
        yield
    finally:
        for owner, name, function in functions:
            setattr(owner, name, function)


if __name__ == "__main__":
    raise SystemExit(main())
