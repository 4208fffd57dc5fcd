"""The command line: one program, `prefplan`."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from experiments.arguments import Command
from experiments.commands import automaton, front, measure, plan, run, sweep, verify
from experiments.status import BAD_INPUT, DONE, INTERRUPTED
from prefplan.errors import PrefplanError

COMMANDS = (front, plan, run, verify, sweep, measure, automaton)
"""In the order of the help text."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program and return its exit status."""
    options = _parser().parse_args(arguments)
    command: Command = options.command
    try:
        status = command(options)
        sys.stdout.flush()
        return status
    except PrefplanError as error:
        print(f"prefplan: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # The reader has what it wants; nothing more can be flushed to it, at exit either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="prefplan",
        description="Plan temporal tasks at the best trade-offs of cost and preference, and carry the plans out.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add(commands)
    return parser
