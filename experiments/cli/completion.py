"""Completion in shells: commands, options, scenarios that ship, and matching files."""

from __future__ import annotations

import argparse
from typing import Any

import shtab

from experiments import scenarios
from prefplan.models.costs import DEFAULT_COST
from prefplan.preferences.objective import DEFAULT_PREFERENCE

SHELLS = ("bash", "zsh", "fish", "tcsh")


class Suggestions(tuple[str, ...]):
    """Choices that completion offers; argparse accepts any other value as well."""

    def __contains__(self, value: object) -> bool:
        """Accept every value."""
        return True


OBJECTIVES = Suggestions((DEFAULT_COST, DEFAULT_PREFERENCE))
"""Names of objectives that every scenario accepts."""


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the script with which one of `SHELLS` completes the arguments of a program."""
    return shtab.complete(parser, shell=shell)


def complete(argument: argparse.Action, how: Any) -> None:
    """Set how an argument is completed.

    `how` is a value of this module, `shtab.FILE`, `shtab.DIRECTORY`, or for example `shtab.glob("*.npz")`.
    """
    argument.complete = how  # type: ignore[attr-defined]


def scenario_files() -> dict[str, Any]:
    """Return the completion of a scenario: names of those that ship, TOML files and folders."""
    names = " ".join(scenarios.names())
    bash = f"""
_prefplan_scenarios() {{
  compgen -W "{names}" -- "$1"
  compgen -f -X '!*.toml' -- "$1"
  compgen -d -S / -- "$1"
}}
"""
    zsh = f"""
_prefplan_scenarios() {{
  _alternative 'ships:scenario that ships:({names})' 'files:scenario file:_files -g "*.toml"'
}}
"""
    fish = f"""
function _prefplan_scenarios
  string split ' ' '{names}'
  set -l word (commandline -ct)
  set -l files $word*.toml $word*/
  printf '%s\n' $files
end
"""
    return {
        "bash": "_prefplan_scenarios",
        "zsh": "_prefplan_scenarios",
        "fish": "(_prefplan_scenarios)",
        "tcsh": f"({names})",
        "preamble": {"bash": bash, "zsh": zsh, "fish": fish},
    }
