"""The help has examples: every command shows calls that work."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

import pytest

from experiments.commands import command_line
from prefplan.scenario.decode import load

PLANNING = ("front", "plan", "automaton", "list", "check")
"""Commands quick enough that their examples are carried out here."""

SIMULATED = ("run", "view", "sweep", "measure")
"""Commands that need an arm."""


def parsers() -> dict[str, argparse.ArgumentParser]:
    """Return the parser of each command."""
    (found,) = [action for action in command_line.parser()._actions if isinstance(action, argparse._SubParsersAction)]
    return dict(found.choices)


def examples(parser: argparse.ArgumentParser) -> list[str]:
    """Return the calls that a help text shows."""
    shown, _, _ = (parser.epilog or "").partition("\n\n")
    return [line.strip() for line in shown.splitlines()[1:]]


COMMANDS = parsers()
EVERY = [(name, line) for name, parser in COMMANDS.items() for line in examples(parser)]
QUICK = [line for name, line in EVERY if name in PLANNING]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_what_it_does_and_shows_two_examples(name: str) -> None:
    parser = COMMANDS[name]
    assert parser.description and parser.description.endswith(".")
    assert len(examples(parser)) >= 2


@pytest.mark.parametrize(("name", "line"), EVERY)
def test_every_example_is_a_call_of_its_command_with_a_scenario_that_it_can_take(name: str, line: str) -> None:
    for part in line.split(" && "):
        program, *arguments = shlex.split(part.partition(" > ")[0])
        assert program == "prefplan"
        options = command_line.parser().parse_args(arguments)
        if getattr(options, "scenario", None):
            kind = load(options.scenario, measured=False).model.kind
            assert name not in SIMULATED or kind == "manipulation"
    assert f"prefplan {name}" in line


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_fits_a_terminal_except_for_examples_to_copy(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = COMMANDS[name].format_help().splitlines()
    assert [line for line in lines if len(line) > 80 and not line.startswith("  ")] == []


@pytest.mark.parametrize("line", QUICK)
def test_the_examples_that_plan_work(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert command_line.main(shlex.split(line)[1:]) == 0
    assert capsys.readouterr().out


def test_the_help_says_what_each_exit_status_means(capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line.main(["--help"]) == 0
    shown = capsys.readouterr().out
    _, _, statuses = shown.partition("exit status:\n")
    assert [line.split()[0] for line in statuses.split("\n\n")[0].splitlines()] == ["0", "2", "3", "4", "130"]
    for name in COMMANDS:
        assert f"    {name}" in map(str.rstrip, (line[:14] for line in shown.splitlines()))
