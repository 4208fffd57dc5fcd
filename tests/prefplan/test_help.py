"""`help(prefplan)` opens with lines that run, and lists the names that matter."""

from __future__ import annotations

import contextlib
import io
import re
from textwrap import dedent

import prefplan

EXAMPLE, NAMES = (dedent(part) for part in re.findall(r"(?<=\n\n)(?: {4}.*\n|\n(?= {4}))+", prefplan.__doc__ or ""))


def test_the_lines_run_and_print_two_fronts_and_a_plan() -> None:
    assert len([line for line in EXAMPLE.splitlines() if line]) <= 10
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(EXAMPLE, {})
    assert out.getvalue().count("Pareto front of cost and penalty") == 2
    assert re.search(r"^cost \d+, penalty 0\n  coffee satisfied", out.getvalue(), re.MULTILINE)


def test_a_dozen_names_are_listed_and_all_that_are_mentioned_exist() -> None:
    listed = [line.split()[0] for line in NAMES.splitlines()]
    assert len(listed) == 12 and set(listed) <= set(prefplan.__all__)
    mentioned = set(re.findall(r"\b[A-Z][a-z]+(?:[A-Z][a-z]+)*\b", NAMES)) - {"Fronts", "Plans"}
    assert mentioned <= {*prefplan.__all__, "TOML"}
