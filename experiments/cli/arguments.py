"""Arguments that several commands take, and how their text becomes a value."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from typing import NoReturn

from assets import VIDEO
from experiments.cli.completion import complete, scenario_files
from experiments.cli.status import BAD_INPUT

Command = Callable[[argparse.Namespace], int]
"""What carries a command out and returns its exit status."""

ROBOTS = ("default", "menagerie")
"""Those of `sim.robots.catalogue`, which takes a second to load."""

Commands = argparse._SubParsersAction
"""Where a command adds itself: what `ArgumentParser.add_subparsers` returns."""


class Parser(argparse.ArgumentParser):
    """A parser that answers a wrong call with one sentence, like everything else that is wrong."""

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        self.exit(BAD_INPUT, f"{self.prog}: {message.removeprefix('argument ')}; see `{self.prog} --help`\n")


def add_command(
    commands: Commands[argparse.ArgumentParser], command: Command, summary: str, *examples: str, more: str = ""
) -> argparse.ArgumentParser:
    """Add a command that bears its function's name, but for a `_` at the end, and return its parser.

    Args:
        commands: where it is added.
        command: what carries it out.
        summary: what it does, in one sentence.
        examples: calls that work, two at least.
        more: what else its help says at the end, in lines of at most 120 characters.
    """
    lines = "".join(f"\n  {example}" for example in examples)
    parser = commands.add_parser(
        command.__name__.rstrip("_"),
        help=summary,
        description=summary,
        epilog=f"examples:{lines}" + (f"\n\n{more}" if more else ""),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(command=command)
    return parser


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add the scenario."""
    scenario = parser.add_argument(
        "scenario", metavar="SCENARIO", help="name of a scenario that ships, or path of a TOML file"
    )
    complete(scenario, scenario_files())


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the switch that makes a command speak to programs."""
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_max_cost(parser: argparse.ArgumentParser) -> None:
    """Add the bound on the total cost."""
    parser.add_argument(
        "--max-cost",
        type=number,
        metavar="C",
        help="only plans of at most this total cost; needed where the preference's contract is general",
    )


def add_limits(parser: argparse.ArgumentParser, found: str) -> None:
    """Add the limits of a search's effort, which ends with what it `found` by then."""
    parser.add_argument("--max-seconds", type=seconds, metavar="S", help=f"stop after this time with {found}")
    parser.add_argument(
        "--max-memory", type=number, metavar="MB", help=f"stop before the search takes more memory, with {found}"
    )


def in_bytes(megabytes: Decimal | None) -> float | None:
    """Return the value of --max-memory in bytes."""
    return None if megabytes is None else float(megabytes) * 2**20


def add_plan(parser: argparse.ArgumentParser) -> None:
    """Add which plan of the front is meant."""
    parser.add_argument(
        "--plan",
        type=which_plan,
        default="cost",
        metavar="cost|preference|INDEX",
        help="which plan of the front: the cheapest, the preferred, or by its number from 0 (default: cost)",
    )


def add_fault(parser: argparse.ArgumentParser) -> None:
    """Add what shall go wrong; read by `sim.execution.faults`."""
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="FAULT",
        help="make something go wrong from the K-th action on; may be repeated: slip@K, move:OBJECT@K, "
        "knock:OBJECT@K, miss:N@K, foreign:LOCATION@K, blind:SECONDS@K",
    )


def add_perturb(parser: argparse.ArgumentParser) -> None:
    """Add how much each rollout's world differs from the nominal one; read by `sim.world.randomization`."""
    keys = "position and noise in mm, angle in degrees, friction and mass in shares"
    parser.add_argument(
        "--perturb",
        metavar="KEY=VALUE,...",
        help=f"greatest random differences: {keys} (default: position=5,angle=5)",
    )


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add the choice of the robot."""
    parser.add_argument(
        "--robot",
        choices=ROBOTS,
        default="default",
        help="the Panda that ships, or that of MuJoCo Menagerie, which is fetched once with git (default: default)",
    )


def add_film(parser: argparse.ArgumentParser) -> None:
    """Add how a film is made."""
    parser.add_argument("--no-video", action="store_true", help="render nothing")
    parser.add_argument(
        "--quality",
        choices=tuple(VIDEO["qualities"]),
        default="draft",
        help="of the video: 1280 x 720, or 1920 x 1080 with soft shadows at ten times the time (default: draft)",
    )
    parser.add_argument(
        "--camera",
        choices=VIDEO["cameras"],
        default="fixed",
        help="before the table, going round its front, or on the hand (default: fixed)",
    )


def number(text: str) -> Decimal:
    """Return a number >= 0, exactly."""
    try:
        value = Decimal(text)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number >= 0")
    return value


def seconds(text: str) -> float:
    """Return a time >= 0."""
    return float(number(text))


def which_plan(text: str) -> str | int:
    """Return how a plan of the front is named: `cost`, `preference` or its number."""
    if text in ("cost", "preference"):
        return text
    if text.isascii() and text.isdigit():
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither cost nor preference nor a plan's number, counted from 0")


def whole(text: str) -> int:
    """Return a whole number >= 0."""
    if text.isascii() and text.isdigit():
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a whole number >= 0")


def positive(text: str) -> int:
    """Return a whole number >= 1."""
    if text.isascii() and text.isdigit() and int(text):
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a whole number >= 1")


def plan_numbers(text: str) -> tuple[int, ...]:
    """Return the numbers of plans, such as `0,3`, each once and in order."""
    return tuple(sorted({whole(part.strip()) for part in text.split(",")}))


def picture_size(text: str) -> tuple[int, int]:
    """Return (width, height) in pixels, such as `1280x720`, both even as films need it."""
    width, cross, height = text.partition("x")
    if not (cross and width.isascii() and width.isdigit() and height.isascii() and height.isdigit()):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 1280x720")
    size = int(width), int(height)
    if any(side % 2 or not 16 <= side <= 4096 for side in size):
        raise argparse.ArgumentTypeError(f"{text!r}: width and height must be even and between 16 and 4096 pixels")
    return size
