"""`prefplan init`: a scenario file to start from."""

from __future__ import annotations

import argparse
from pathlib import Path

from experiments.cli.arguments import Commands, add_command
from experiments.cli.files import check_new, make_folder, write_bytes
from experiments.cli.status import DONE
from experiments.starters import KINDS, starter


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    parser = add_command(commands, init, "prefplan init rooms", "prefplan init desk --kind manipulation")
    parser.add_argument("name", metavar="NAME", type=Path, help="name or path of the new file; .toml may be left out")
    parser.add_argument("--kind", choices=KINDS, default="grid", help="kind of model (default: grid)")


def init(options: argparse.Namespace) -> int:
    """Write a commented scenario to start from; it can be planned as it is."""
    file: Path = options.name
    if file.suffix != ".toml":
        file = file.with_name(f"{file.name}.toml")
    check_new(file, mend="choose another name, or remove it first")
    make_folder(file.parent)
    write_bytes(file, starter(options.kind, file=file.name).encode())
    print(f"Wrote {file}. Next: prefplan check {file}, then prefplan front {file}")
    return DONE
