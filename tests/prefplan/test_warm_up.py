"""`is_compiled` tells whether the kernels are cached, so that a notice to wait is not shown in vain."""

from __future__ import annotations

import os
import subprocess
import sys

from prefplan import Order, Problem, Task, TransitionSystem, pareto_front
from prefplan.models.kernels import compile_kernels
from prefplan.warm_up import is_compiled


def test_after_a_compiled_search_it_is_compiled() -> None:
    compile_kernels()
    system = TransitionSystem.from_transitions([("a", "go", "b", 1)], start="a", labels={"b": ["there"]})
    assert len(pareto_front(Problem(system, [Task("t", "F there")], Order()))) == 1
    assert is_compiled()


def test_kernels_run_in_python_for_a_debugger() -> None:
    script = """
from prefplan import Order, Problem, Task, TransitionSystem, pareto_front
from prefplan.warm_up import is_compiled

steps = [("s", "go", "t", 2), ("t", "go", "s", 1)]
system = TransitionSystem.from_transitions(steps, start="s", labels={"s": ["a"], "t": ["b"]})
front = pareto_front(Problem(system, [Task("x", "F b"), Task("y", "F a")], Order()))
print([plan.cost for plan in front], is_compiled())
"""
    done = subprocess.run(
        [sys.executable, "-c", script], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True
    )
    assert done.stdout == "[2] True\n", done.stderr
