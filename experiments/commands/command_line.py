"""The command line: one program, `prefplan`."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

import prefplan
from experiments.cli.arguments import Command, HelpFormatter, Parser, add_quiet
from experiments.cli.status import BAD_INPUT, DONE, FAILED, INTERRUPTED
from experiments.commands.execution import demo, export, film, measure, report, run, sweep, verify, view
from experiments.commands.machine import completion, doctor, robots
from experiments.commands.planning import automaton, check, draw, front, init, plan
from experiments.commands.planning import list as list_command
from prefplan.errors import LimitError, PrefplanError
from prefplan.front import UnfinishedError

COMMANDS = (
    init,
    list_command,
    demo,
    check,
    front,
    plan,
    run,
    report,
    film,
    export,
    view,
    verify,
    sweep,
    measure,
    automaton,
    draw,
    robots,
    doctor,
    completion,
)
"""In the order of the help text."""

SIMULATION = "pip install '.[sim]', in a clone of prefplan"
"""Installs the simulation."""

EPILOG = """\
examples:
  prefplan demo                                the paper's manipulation case study, with videos and a page
  prefplan front example                       the Pareto front and its plans
  prefplan plan example --max-preference 3     the cheapest plan within a bound on the penalty
  prefplan run case_study_3 --plan preference  carry the preferred plan out, with a video

exit status:
  0    done
  2    invalid arguments or input: stderr says what is valid
  3    no plan exists, or none within the bounds given
  4    the execution failed, a run was refuted, or a limit ended the search before any plan was found
  130  interrupted by Ctrl-C

`prefplan COMMAND --help` shows the arguments of a command and more examples. Commands with --json print one JSON
object on stdout and nothing else. Colour and framed tables are for terminals only; NO_COLOR=1 turns colour off.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program and return its exit status."""
    status = DONE
    try:
        status = _carry_out(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader has closed the pipe, so flushing at exit would fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return status


def _carry_out(arguments: Sequence[str] | None) -> int:
    try:
        options = parser().parse_args(arguments)
        command: Command = options.command
        return command(options)
    except SystemExit as end:  # argparse has printed the help or an error
        return int(end.code or 0)
    except (UnfinishedError, LimitError) as error:
        print(f"prefplan: {error}", file=sys.stderr)
        return FAILED
    except PrefplanError as error:
        print(f"prefplan: {error}", file=sys.stderr)
        return BAD_INPUT
    except ModuleNotFoundError as error:
        if error.name != "mujoco":  # what `sim` loads first
            raise
        print(f"prefplan: {options.command.__name__} needs the simulation: {SIMULATION}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED


def parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line."""
    parser = Parser(
        prog="prefplan",
        description="Plan temporal tasks at the best trade-offs of cost and preference, and carry the plans out.",
        epilog=EPILOG,
        formatter_class=HelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"prefplan {prefplan.__version__}")
    add_quiet(parser)
    parser.set_defaults(program=parser, command=help_)
    commands = parser.add_subparsers(metavar="COMMAND", title="commands")
    for command in COMMANDS:
        command.add(commands)
    return parser


def help_(options: argparse.Namespace) -> int:
    """Print the help of the program."""
    options.program.print_help()
    return DONE
