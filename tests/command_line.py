"""What tests of the command line share: a call of the program, and what comes of it."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import click
import pytest

from experiments.commands.command_line import main, program


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


def parsed(arguments: Sequence[str]) -> dict[str, Any]:
    """Return the parameters of a command that a call of the program gives, without carrying it out."""
    with program.make_context("prefplan", []) as context:
        name, command, rest = program.resolve_command(context, list(arguments))
        assert isinstance(command, click.Command)
        with command.make_context(name, rest, parent=context) as called:
            return called.params


def assert_is_error(result: Result, message: str) -> None:
    assert result.status == 2
    assert result.out == ""
    assert message in result.err
    assert "Traceback" not in result.err
