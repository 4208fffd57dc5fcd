"""The values of arguments and options: their conversion from text, their errors, and their shell completion."""

import glob
import re
from collections.abc import Callable, Iterable
from decimal import Decimal, InvalidOperation
from pathlib import Path

import click

WHOLE, POSITIVE = click.IntRange(min=0), click.IntRange(min=1)

PATH = click.Path(path_type=Path)
"""A path, whether or not something is there."""

Completion = Callable[[click.Context, click.Parameter, str], list[str]]
"""Returns the completions that shells offer for the first letters of a value."""


def files(ending: str, names: Callable[[], Iterable[str]] = tuple) -> Completion:
    """Return a function that gives shells the names, files with an ending, such as `.toml`, and folders."""

    def complete(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
        found = [name for name in names() if name.startswith(incomplete)]
        paths = sorted(Path(name) for name in glob.glob(f"{glob.escape(incomplete)}*"))
        found += [f"{path}/" for path in paths if path.is_dir()]
        return found + [str(path) for path in paths if path.suffix == ending and not path.is_dir()]

    return complete


def number(text: str, *, unit: str = "") -> Decimal:
    """Return a number >= 0 as an exact decimal; messages name its unit."""
    try:
        value = Decimal(text)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or value < 0:
        raise click.BadParameter(f"{text!r} is not a number{unit and f' of {unit}'} >= 0")
    return value


def named_number(text: str) -> tuple[str, Decimal]:
    """Return a name and a number >= 0, such as `energy=40`."""
    name, separator, value = text.partition("=")
    if not name or not separator:
        raise click.BadParameter(f"{text!r} is not NAME=VALUE, such as energy=40")
    return name, number(value)


def seconds(text: str) -> float:
    """Return a time >= 0, s."""
    return float(number(text, unit="seconds"))


def megabytes(text: str) -> float:
    """Return an amount of memory given in MiB, in bytes."""
    return float(number(text, unit="MiB")) * 2**20


PLANS = {"cost": "cost", "preference": "preference", "cheapest": "cost", "preferred": "preference"}
"""The words for a plan, and the name that each stands for."""


def which_plan(text: str) -> str | int:
    """Return the name of a plan of the front: `cost`, `preference` or its index."""
    if text in PLANS:
        return PLANS[text]
    if text.isascii() and text.isdigit():
        return int(text)
    raise click.BadParameter(f"{text!r} is no plan: a number from 0, or one of {', '.join(PLANS)}")


def plan_numbers(text: str) -> tuple[int, ...]:
    """Return indices of plans, such as `0,3`, each once and in order."""
    return tuple(sorted({WHOLE(part) for part in text.split(",")}))


def picture_size(text: str) -> tuple[int, int]:
    """Return (width, height) in pixels, such as `1280x720`, both even as videos need it."""
    found = re.fullmatch(r"([0-9]+)x([0-9]+)", text)
    if not found:
        raise click.BadParameter(f"{text!r} is not a size such as 1280x720")
    size = int(found[1]), int(found[2])
    if any(side % 2 or not 16 <= side <= 4096 for side in size):
        raise click.BadParameter(f"{text!r}: width and height must be even and between 16 and 4096 pixels")
    return size
