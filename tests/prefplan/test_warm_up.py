"""Kernels: whether they are cached, so that a notice to wait is not shown in vain; and who may call them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

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


def test_what_would_crash_when_python_calls_it_is_an_error() -> None:
    script = """
from prefplan.product.heap import heap_pop
from prefplan.models.kernels import compile_kernels

compile_kernels()
heap_pop([], [], 0, None)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 1 and "heap_pop: compiled, only kernels may call it" in done.stderr


def test_nothing_is_compiled_while_another_thread_runs_kernels_in_python(tmp_path: Path) -> None:
    script = """
import threading, time
from prefplan.models import kernels

inside, tries = threading.Event(), []

@kernels.kernel
def waits() -> bool:
    inside.set()
    time.sleep(0.3)
    return waits.compiled is None

def compiles() -> None:
    inside.wait()
    kernels.compile_kernels()

thread = threading.Thread(target=compiles)
thread.start()
print(waits())
thread.join()
print(waits.compiled is None)
"""
    file = tmp_path / "waits.py"  # numba keeps the code of files alone
    file.write_text(script)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, file], env=environment, capture_output=True, text=True)
    assert done.stdout == "True\nFalse\n", done.stderr
