"""What a shell offers when Tab is pressed: commands, options, scenarios that ship, and the files that fit."""

from __future__ import annotations

import argparse
from typing import Any

import shtab

from experiments import scenarios

SHELLS = ("bash", "zsh", "fish", "tcsh")


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the script that makes one of `SHELLS` complete a program's arguments."""
    return shtab.complete(parser, shell=shell)


def complete(argument: argparse.Action, how: Any) -> None:
    """Say how an argument is completed.

    Args:
        argument: what `add_argument` returned.
        how: from this module or `shtab`: `shtab.FILE`, `shtab.DIRECTORY`, `shtab.glob("*.npz")`.
    """
    argument.complete = how  # type: ignore[attr-defined]


def scenario_files() -> dict[str, Any]:
    """Return how a scenario is completed: by the names of those that ship, TOML files and folders."""
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
