"""The help has examples: every command shows calls that work."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest
from command_line import parsed

from experiments.cli.command import Command
from experiments.commands import command_line
from experiments.commands.command_line import FOLDERS, program
from prefplan.scenario.decode import load

PLANNING = ("front", "plan", "automaton", "list", "check")
"""Commands quick enough that their examples are carried out here."""

SIMULATED = ("run", "view", "sweep", "measure")
"""Commands that need an arm."""


def commands() -> dict[str, Command]:
    """Return the commands by name."""
    with program.make_context("prefplan", []) as context:
        return {name: found for name in FOLDERS if (found := program.get_command(context, name))}


def examples(command: Command) -> list[str]:
    """Return the calls that a help text shows."""
    shown, _, _ = (command.epilog or "").removeprefix("\b\n").partition("\n\n")
    return [line.strip() for line in shown.splitlines()[1:]]


COMMANDS = commands()
EVERY = [(name, line) for name, command in COMMANDS.items() for line in examples(command)]
QUICK = [line for name, line in EVERY if name in PLANNING]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_what_it_does_and_shows_two_examples(name: str) -> None:
    command = COMMANDS[name]
    assert command.help and command.help.endswith(".")
    assert len(examples(command)) >= 2


@pytest.mark.parametrize(("name", "line"), EVERY)
def test_every_example_is_a_call_of_its_command_with_a_scenario_that_it_can_take(name: str, line: str) -> None:
    for part in line.split(" && "):
        called, *arguments = shlex.split(part.partition(" > ")[0])
        assert called == "prefplan"
        options = parsed(arguments)
        if options.get("scenario"):
            kind = load(options["scenario"], measured=False).model.kind
            assert name not in SIMULATED or kind == "manipulation"
    assert f"prefplan {name}" in line


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_fits_a_terminal_except_for_examples_to_copy(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with program.make_context("prefplan", []) as context:
        lines = COMMANDS[name].get_help(click.Context(COMMANDS[name], parent=context, info_name=name)).splitlines()
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
    _, _, statuses = shown.partition("Exit status:\n")
    assert [line.split()[0] for line in statuses.split("\n\n")[0].splitlines()] == ["0", "2", "3", "4", "5", "130"]
    for name in COMMANDS:
        assert re.search(rf"^  {name}  ", shown, re.MULTILINE)
