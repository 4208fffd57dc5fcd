"""Kernels give the same in Python and compiled, and machine code on disk is that of the sources."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from judge.random_problems import random_problem

from prefplan import cheapest_plan, pareto_front
from prefplan.models.kernels import compile_kernels, forget_outdated
from prefplan.scenario.decode import from_dict


def test_machine_code_is_kept_while_no_source_changes(tmp_path: Path) -> None:
    forget_outdated(tmp_path)
    index = tmp_path / "search.run-1.py3.nbi"
    index.touch()
    forget_outdated(tmp_path)
    assert index.exists()


def test_machine_code_of_other_sources_is_forgotten(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    forget_outdated(folder)
    index = folder / "search.run-1.py3.nbi"
    index.touch()
    (folder / "sources.sha256").write_text("of other sources")
    forget_outdated(folder)
    assert not index.exists()
    assert [file.name for file in folder.iterdir()] == ["sources.sha256"]


SEEDS = range(40)

PLANS = """
import itertools, sys, types
from prefplan.models import kernels
from {module} import plans_of
kernels.time = types.SimpleNamespace(thread_time=itertools.count().__next__)  # a second between any two looks
kernels.Interpreter.seconds_left = float(sys.argv[1])
for seed in map(int, sys.argv[2:]):
    print(plans_of(seed))
print("numba" in sys.modules, file=sys.stderr)
"""


def plans_of(seed: int) -> list[tuple[str, ...]]:
    """Return the actions of the front of a random problem, and its cheapest plan's."""
    kind = ("order", "weighted-sum")[seed % 2]
    problem = from_dict(random_problem(seed, kind=kind, relaxed=kind != "order").scenario()).problem()
    front = pareto_front(problem, max_cost=20)
    return [plan.actions for plan in (*front, *([cheapest_plan(problem)] if front else []))]


@pytest.mark.parametrize(("seconds", "compiles"), [("inf", "False"), ("100", "True")])
def test_kernels_find_the_same_plans_in_python_and_from_any_time_on_compiled(seconds: str, compiles: str) -> None:
    compile_kernels()
    expected = [str(plans_of(seed)) for seed in SEEDS]
    folder = Path(__file__).parent
    script = PLANS.format(module=Path(__file__).stem)
    path = os.pathsep.join(map(str, (folder, folder.parents[1], folder.parents[2])))
    done = subprocess.run(
        [sys.executable, "-c", script, seconds, *map(str, SEEDS)],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert done.stderr.splitlines()[-1] == compiles, done.stderr
    assert done.stdout.splitlines() == expected
