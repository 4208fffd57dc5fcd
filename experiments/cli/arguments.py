"""Arguments that several commands take, and how their text becomes a value."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, NoReturn

from experiments.cli.completion import complete, scenario_files
from experiments.cli.status import BAD_INPUT
from prefplan.errors import choices
from prefplan.limits import Limits

Command = Callable[[argparse.Namespace], int]
"""Carries a command out and returns its exit status."""

Commands = argparse._SubParsersAction
"""Where a command adds itself: the value of `ArgumentParser.add_subparsers`."""


class Parser(argparse.ArgumentParser):
    """A parser that answers a wrong call with one sentence, like every other error, and the usage of the command."""

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """Parse arguments; end with status 2 at an unknown one, in the command that it was given to."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            wrong = unknown[0].partition("=")[0]
            if wrong.startswith("-"):
                self.error(f"unknown option {wrong} {choices(wrong, self._option_string_actions)}")
            self.error(f"unexpected argument {wrong!r}")
        return found, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Suggest the nearest valid value, where argparse lists them all."""
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, f"unknown value {value!r} {choices(value, map(str, action.choices))}")

    def error(self, message: str) -> NoReturn:
        """End with status 2, and show how the command is used."""
        told = message.removeprefix("argument ")
        self.exit(BAD_INPUT, f"{self.prog}: {told}\n{self.format_usage()}More: `{self.prog} --help`\n")


def add_command(
    commands: Commands[argparse.ArgumentParser], command: Command, summary: str, *examples: str, more: str = ""
) -> argparse.ArgumentParser:
    """Add a command with the name of its function, without a `_` at the end, and return its parser.

    Args:
        commands: where it is added.
        command: carries it out.
        summary: one sentence for the help.
        examples: calls that work, two at least.
        more: text at the end of the help, in lines of at most 120 characters.
    """
    lines = "".join(f"\n  {example}" for example in examples)
    parser = commands.add_parser(
        command.__name__.rstrip("_"),
        help=summary,
        description=summary,
        epilog=f"examples:{lines}" + (f"\n\n{more}" if more else ""),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_quiet(parser, default=argparse.SUPPRESS)
    parser.set_defaults(command=command)
    return parser


def add_quiet(parser: argparse.ArgumentParser, *, default: Any = False) -> None:
    """Add the switch that hides progress; it may stand before a command or after it."""
    parser.add_argument(
        "-q", "--quiet", action="store_true", default=default, help="show no progress, only results and errors"
    )


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add the scenario."""
    scenario = parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="name of a scenario that `prefplan list` shows, or path of a TOML file",
    )
    complete(scenario, scenario_files())


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the switch for output that programs read."""
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_max_cost(parser: argparse.ArgumentParser) -> None:
    """Add the bound on the total cost."""
    parser.add_argument(
        "--max-cost",
        type=number,
        metavar="C",
        help="only plans of at most this total cost; needed where the preference's contract is general",
    )


def add_at_most(parser: argparse.ArgumentParser) -> None:
    """Add bounds of costs and preferences by name."""
    parser.add_argument(
        "--at-most",
        action=Bound,
        type=named_number,
        default=None,
        metavar="NAME=VALUE",
        help="bound on a cost or a preference by its name, such as energy=40; may be repeated",
    )


class Bound(argparse.Action):
    """Collects bounds in a dictionary; of several on one name the last counts."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, values: Any, option_string: Any = None) -> None:
        """Add a bound."""
        name, value = values
        setattr(namespace, self.dest, {**(getattr(namespace, self.dest) or {}), name: value})


def add_max_preference(parser: argparse.ArgumentParser) -> None:
    """Add the bound on the preference penalty."""
    parser.add_argument("--max-preference", type=number, metavar="M", help="bound on the plan's preference penalty")


def add_within(parser: argparse.ArgumentParser) -> None:
    """Add how close a front must come to the exact one."""
    parser.add_argument(
        "--within",
        type=percentage,
        default=Decimal(0),
        metavar="P%",
        help="leave out what other plans are good enough for: each best trade-off has one whose cost and penalty are "
        "at most P %% larger (default: 0, the exact front)",
    )


def add_limits(parser: argparse.ArgumentParser, found: str) -> None:
    """Add the limits of a search, which ends with what it has `found` by then."""
    parser.add_argument("--max-seconds", type=seconds, metavar="S", help=f"stop after this time with {found}")
    parser.add_argument(
        "--max-memory", type=megabytes, metavar="MB", help=f"stop before the search takes more memory, with {found}"
    )


def limits_of(options: argparse.Namespace) -> Limits:
    """Return the limits that `add_limits` adds, from now on: as a context, also for reading a scenario."""
    seconds, memory = options.max_seconds, options.max_memory
    return Limits(math.inf if seconds is None else seconds, math.inf if memory is None else memory)


def add_plan(parser: argparse.ArgumentParser) -> None:
    """Add the choice of a plan of the front; read by `experiments.cli.choice`."""
    parser.add_argument(
        "--plan",
        type=which_plan,
        default="cost",
        metavar="cost|preference|INDEX",
        help="which plan of the front: the cheapest, the preferred, or by its number from 0 (default: cost)",
    )
    add_max_preference(parser)
    add_max_cost(parser)


def add_fault(parser: argparse.ArgumentParser) -> None:
    """Add the faults of a run; read by `sim.execution.faults`."""
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="FAULT",
        help="inject a fault at the K-th action or the next one that it fits; may be repeated: slip@K, move:OBJECT@K, "
        "knock:OBJECT@K, miss:N@K, foreign:LOCATION@K, blind:SECONDS@K",
    )


def add_perturb(parser: argparse.ArgumentParser) -> None:
    """Add the random differences of a run from the nominal scene; read by `sim.world.randomization`."""
    parser.add_argument(
        "--perturb",
        metavar="KEY=VALUE,...",
        help="greatest random differences: position, centre (of mass), noise and bias (of the camera) in mm; angle in "
        "degrees; latency in ms; friction, pads, table, force and mass as a share (default: position=5,angle=5)",
    )


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add the choice of the robot."""
    parser.add_argument(
        "--robot",
        metavar="NAME",
        help="one of those that `prefplan robots` lists (default: the scenario's, or panda)",
    )


def add_video(parser: argparse._ActionsContainer) -> None:
    """Add whether and how videos are rendered; read by `experiments.cli.simulation_options`."""
    parser.add_argument("--no-video", action="store_true", help="render no video")
    add_look(parser)


def add_look(parser: argparse._ActionsContainer) -> None:
    """Add how videos look."""
    parser.add_argument(
        "--quality",
        metavar="NAME",
        default="draft",
        help="draft: 1280 x 720; final: 1920 x 1080 with soft shadows, in ten times the time (default: draft)",
    )
    add_camera(parser)
    parser.add_argument(
        "--inset", metavar="NAME", help="a second, small view in a corner: wrist or top, as --camera (default: none)"
    )
    parser.add_argument(
        "--size", type=picture_size, metavar="WxH", help="width and height in pixels (default: the quality's)"
    )


def add_camera(parser: argparse._ActionsContainer) -> None:
    """Add the camera; read by `experiments.cli.simulation_options.camera_of`."""
    parser.add_argument(
        "--camera",
        metavar="NAME",
        default="fixed",
        help="fixed: in front of the table; orbit: around its front; wrist: on the hand; top: from above; another "
        "camera of the scene's MJCF by its name; or azimuth and elevation in degrees and distance in m, such as "
        "156,-28,1.2 (default: fixed)",
    )


def add_seed(parser: argparse.ArgumentParser, differences: str = "at random by up to 5 mm and 5 degrees") -> None:
    """Add the seed of a run."""
    parser.add_argument(
        "--seed",
        type=whole,
        metavar="N",
        help=f"start each object off its nominal pose, {differences} (default: nominal poses)",
    )


def add_out(parser: argparse.ArgumentParser, default: str = "out/SCENARIO") -> None:
    """Add the folder for results."""
    parser.add_argument("--out", type=Path, metavar="DIR", help=f"folder for the results (default: {default})")


def add_no_open(parser: argparse.ArgumentParser) -> None:
    """Add the switch for machines without a browser."""
    parser.add_argument(
        "--no-open", "--no-browser", action="store_true", help="print the address of the page, but open no browser"
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Add the number of processes."""
    parser.add_argument("--jobs", type=positive, metavar="N", help="number of processes (default: one per core)")


def add_plot(parser: argparse.ArgumentParser) -> None:
    """Add the file for a figure."""
    parser.add_argument("--plot", metavar="FILE", help="draw a figure too; the file ends in .png, .svg or .pdf")


def number(text: str) -> Decimal:
    """Return a number >= 0, exactly."""
    try:
        value = Decimal(text)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number >= 0")
    return value


def named_number(text: str) -> tuple[str, Decimal]:
    """Return a name and a number >= 0, such as `energy=40`."""
    name, separator, value = text.partition("=")
    if not name or not separator:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE, such as energy=40")
    return name, number(value)


def percentage(text: str) -> Decimal:
    """Return a number of percent >= 0, with or without its sign."""
    return number(text.removesuffix("%").rstrip())


def seconds(text: str) -> float:
    """Return a time >= 0."""
    return float(number(text))


def megabytes(text: str) -> float:
    """Return an amount of memory in bytes."""
    return float(number(text)) * 2**20


def which_plan(text: str) -> str | int:
    """Return the name of a plan of the front: `cost`, `preference` or its index."""
    if text in ("cost", "preference"):
        return text
    if _is_integer(text):
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither cost nor preference nor a plan's number, counted from 0")


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
