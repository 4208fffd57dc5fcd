"""What tests of the command line share: a call of the program, what comes of it, and a scenario."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from experiments.commands.command_line import main


class Result(NamedTuple):
    status: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.out)
        return found


Run = Callable[..., Result]


def call(capsys: pytest.CaptureFixture[str], *arguments: str) -> Result:
    """Call the program in this process; return its exit status and what it wrote."""
    status = main(arguments)
    captured = capsys.readouterr()
    return Result(status, captured.out, captured.err)


DETOUR = """
[model]
kind = "graph"
start = "s"
propositions = ["never"]
transitions = [
  { from = "s", to = "shop", cost = 1 },
  { from = "shop", to = "bank", cost = 2.5 },
  { from = "s", to = "bank", cost = 3 },
  { from = "bank", to = "shop", cost = 2 },
]
[model.labels]
shop = ["bread"]
bank = ["money"]

[[tasks]]
name = "pay"
formula = "F money"

[[tasks]]
name = "buy"
formula = "F bread"

[preference]
kind = "order"
"""


def assert_is_error(result: Result, message: str) -> None:
    assert result.status == 2
    assert result.out == ""
    assert message in result.err
    assert "Traceback" not in result.err
