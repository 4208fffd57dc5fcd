"""The parsers of commands, and how the text of an argument becomes a value."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation
from typing import Any, NoReturn

from experiments.cli.status import BAD_INPUT
from prefplan.errors import choices

Command = Callable[[argparse.Namespace], int]
"""Carries a command out and returns its exit status."""

Commands = argparse._SubParsersAction
"""Where a command adds itself: the value of `ArgumentParser.add_subparsers`."""


class Parser(argparse.ArgumentParser):
    """A parser that reports a wrong call in one sentence, and names the call that shows the usage."""

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """Parse arguments; end with status 2 at an unknown one."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            wrong = unknown[0].partition("=")[0]
            if wrong.startswith("-"):
                self.error(f"unknown option {wrong} {choices(wrong, self._option_string_actions)}")
            self.error(f"unexpected argument {wrong!r}")
        return found, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Suggest the nearest valid value, where argparse would list them all."""
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, f"unknown value {value!r} {choices(value, map(str, action.choices))}")

    def error(self, message: str) -> NoReturn:
        """End with status 2, and say what shows the usage."""
        told = message.removeprefix("argument ")
        self.exit(BAD_INPUT, f"{self.prog}: {told}\nUsage: `{self.prog} --help`\n")


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Wraps paragraphs to the width of the terminal, except those with indented lines, such as examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.rstrip().split("\n\n")
        return "\n\n".join(part if "\n " in part else textwrap.fill(part, width) for part in paragraphs)


def add_command(
    commands: Commands[argparse.ArgumentParser], command: Command, *examples: str, more: str = ""
) -> argparse.ArgumentParser:
    """Add a command with the name of its function, without a `_` at the end, and return its parser.

    The first line of the function's docstring is its summary in the help.

    Args:
        commands: the subparsers to which it is added.
        command: carries it out.
        examples: at least two calls that work.
        more: text at the end of the help, see `HelpFormatter`.
    """
    summary = (command.__doc__ or "").partition("\n")[0]
    lines = "".join(f"\n  {example}" for example in examples)
    parser = commands.add_parser(
        command.__name__.rstrip("_"),
        help=summary,
        description=summary,
        epilog=f"examples:{lines}" + (f"\n\n{more}" if more else ""),
        formatter_class=HelpFormatter,
    )
    add_quiet(parser, default=argparse.SUPPRESS)
    parser.set_defaults(command=command)
    return parser


def add_quiet(parser: argparse.ArgumentParser, *, default: Any = False) -> None:
    """Add the switch that hides progress; it may stand before a command or after it."""
    parser.add_argument(
        "-q", "--quiet", action="store_true", default=default, help="show no progress, only results and errors"
    )


class Bound(argparse.Action):
    """Collects bounds in a dictionary; the last bound on a name counts."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, values: Any, option_string: Any = None) -> None:
        """Add a bound."""
        name, value = values
        setattr(namespace, self.dest, {**(getattr(namespace, self.dest) or {}), name: value})


def number(text: str, *, unit: str = "") -> Decimal:
    """Return a number >= 0 as an exact decimal; messages name its unit."""
    try:
        value = Decimal(text)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number{unit and f' of {unit}'} >= 0")
    return value


def named_number(text: str) -> tuple[str, Decimal]:
    """Return a name and a number >= 0, such as `energy=40`."""
    name, separator, value = text.partition("=")
    if not name or not separator:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE, such as energy=40")
    return name, number(value)


def seconds(text: str) -> float:
    """Return a time >= 0, s."""
    return float(number(text, unit="seconds"))


def megabytes(text: str) -> float:
    """Return an amount of memory given in MiB, in bytes."""
    return float(number(text, unit="MiB")) * 2**20


PLANS = {"cost": "cost", "preference": "preference", "cheapest": "cost", "preferred": "preference"}
"""What a plan may be called, and its name."""


def which_plan(text: str) -> str | int:
    """Return the name of a plan of the front: `cost`, `preference` or its index."""
    if text in PLANS:
        return PLANS[text]
    if _is_integer(text):
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no plan: a number from 0, or one of {', '.join(PLANS)}")


def whole(text: str, *, least: int = 0) -> int:
    """Return a whole number, not smaller than the least one."""
    if _is_integer(text) and int(text) >= least:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a whole number >= {least}")


def positive(text: str) -> int:
    """Return a whole number >= 1."""
    return whole(text, least=1)


def _is_integer(text: str) -> bool:
    return text.isascii() and text.isdigit()


def plan_numbers(text: str) -> tuple[int, ...]:
    """Return indices of plans, such as `0,3`, each once and in order."""
    return tuple(sorted({whole(part.strip()) for part in text.split(",")}))


def picture_size(text: str) -> tuple[int, int]:
    """Return (width, height) in pixels, such as `1280x720`, both even as videos need it."""
    width, _, height = text.partition("x")
    if not (_is_integer(width) and _is_integer(height)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 1280x720")
    size = int(width), int(height)
    if any(side % 2 or not 16 <= side <= 4096 for side in size):
        raise argparse.ArgumentTypeError(f"{text!r}: width and height must be even and between 16 and 4096 pixels")
    return size
