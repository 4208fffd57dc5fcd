"""The names of the package `sim`: each is loaded on first access, and has the type that its module gives it."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import sim


def test_types_are_those_of_the_files() -> None:
    source = Path(sim.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    typed = {
        alias.asname: (f"sim.{node.module}", alias.name)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert sorted(typed) == sim.__all__
    for name, (file, original) in typed.items():
        assert getattr(importlib.import_module(file), original) is getattr(sim, name)
        assert name in dir(sim)


def test_a_name_that_does_not_exist_is_named() -> None:
    with pytest.raises(AttributeError, match="No sim attribute exceute"):
        _ = importlib.import_module("sim").exceute


def test_importing_the_package_loads_nothing_but_mujoco() -> None:
    script = "import sys, sim, sim.errors; print(*(name for name in sys.modules if name.startswith('sim.')))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["sim.errors"]
