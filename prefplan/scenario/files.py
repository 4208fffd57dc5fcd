"""Scenario files: where they are, and their contents as TOML."""

import os
import re
import tomllib
from decimal import Decimal
from pathlib import Path
from typing import Any

from prefplan.errors import ScenarioError, choices, describe

FOLDER = Path(__file__).parents[2] / "experiments" / "scenarios"
"""The scenarios that ship: data beside this package, found without importing the package that holds them."""

MOST_LETTERS = 4_000_000
"""Most letters of a scenario: parsing them takes one to three seconds, in which no limit is checked."""

NEEDED = ("model", "tasks")
"""Top-level keys of every scenario."""


def names() -> list[str]:
    """Return the names of the scenarios that ship."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def path_of(scenario: str | Path) -> Path:
    """Return the path of a scenario that is given by the name of one that ships, or by a path.

    Names of scenarios that ship take precedence over files; the `.toml` of a file's name may be left out.

    Raises:
        ScenarioError: it is a name, and there is no such scenario.
    """
    if isinstance(scenario, Path):
        return scenario
    if not isinstance(scenario, str):
        raise ScenarioError(f"a scenario is loaded by its name or path, not {describe(scenario)}")
    if scenario in names():
        return FOLDER / f"{scenario}.toml"
    path, named = Path(scenario), Path(f"{scenario}.toml")
    # The functions of `os.path` also return False if a folder may not be read or a name is too long.
    if os.path.isfile(named) and not os.path.isfile(path):
        return named
    if path.suffix or os.path.exists(path) or len(path.parts) > 1:
        return path
    valid = sorted({*names(), *(file.stem for file in Path().glob("*.toml") if is_scenario(file))})
    raise ScenarioError(f"no scenario named {scenario!r} ships or is in this folder {choices(scenario, valid)}")


def is_scenario(path: Path) -> bool:
    """Return whether a path is that of a regular file in TOML with the top-level keys that every scenario needs."""
    try:
        return os.path.isfile(path) and contents(text_of(path), path).keys() >= set(NEEDED)
    except ScenarioError:
        return False


def text_of(path: Path) -> str:
    """Return the text of a file.

    Raises:
        ScenarioError: it cannot be read, or is too large.
    """
    try:
        with path.open(encoding="utf-8-sig") as file:
            text = file.read(MOST_LETTERS + 1)
        if len(text) > MOST_LETTERS:
            own = 'a large graph has a file of its own, such as file = "graph.csv" in [model]'
            raise ScenarioError(f"{path}: has more than {MOST_LETTERS} letters; {own}")
        return text
    except FileNotFoundError:
        import difflib  # for messages only

        near = difflib.get_close_matches(path.name, [file.name for file in path.parent.glob("*.toml")], n=1)
        other = f" (did you mean {str(path.with_name(near[0]))!r}?)" if near else ""
        if path.stem in names():
            other = f" (one of this name ships: {path.stem!r})"
        raise ScenarioError(f"{path}: no such file{other}") from None
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}") from None


def contents(text: str, path: Path) -> dict[str, Any]:
    """Return the values in the text of a TOML file.

    Raises:
        ScenarioError: it is not TOML; the message begins with the path.
    """
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {_explained(str(error), text)}") from None
    except RecursionError:
        raise ScenarioError(f"{path}: lists or tables are nested too deep") from None
    except ValueError as error:
        # Python refuses to parse integers of thousands of digits.
        raise ScenarioError(f"{path}: a number is too long: {str(error).partition(';')[0]}") from None


def _explained(message: str, text: str) -> str:
    """Return what a TOML parser says, with the line of the text, and what is probably wrong with it."""
    single = re.search(r"^\[(tasks|rules|preferences)\]", text, re.MULTILINE)
    place = re.search(r"\(at line (\d+), column (\d+)\)", message)
    line, column = (text.splitlines()[int(place[1]) - 1], int(place[2]) - 1) if place else ("", 0)
    if single and message.startswith("Cannot"):
        message += f"; write [[{single[1]}]] above each of its tables"
    elif re.match(r"[+-]?\.\d", line[column:]):
        message += "; a number has a digit before its point, such as 0.5"
    elif message.startswith("Invalid value"):
        message += '; text is written in "quotes"'
    return f"{message}\n    {line}\n    {' ' * column}^" if place else message
