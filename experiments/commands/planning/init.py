"""`prefplan init`: a scenario file to start from."""

import shlex
from pathlib import Path

import click

from experiments.cli.command import command
from experiments.cli.files import check_new, make_folder, write_bytes
from experiments.cli.status import DONE, say
from experiments.cli.values import PATH
from experiments.starters import KINDS, starter
from prefplan.errors import PrefplanError


@command
@click.argument("file", metavar="NAME", type=PATH, help="Name or path of the new file; .toml may be left out.")
@click.option("--kind", type=click.Choice(KINDS), default="grid", help="Kind of model (default: grid).")
def init(file: Path, kind: str) -> int:
    """Write a commented scenario to start from; it can be planned as it is.

    Examples:
      prefplan init rooms
      prefplan init desk --kind manipulation
    """
    if file.name in ("", ".."):
        raise PrefplanError(f"{file}: is a folder; name a file")
    if file.suffix != ".toml":
        file = file.with_name(f"{file.name}.toml")
    check_new(file, fix="choose another name, or remove it first")
    make_folder(file.parent)
    write_bytes(file, starter(kind, file=file.name).encode())
    quoted = shlex.quote(str(file))
    say(f"Wrote {file}. Next: prefplan check {quoted}, then prefplan front {quoted}")
    return DONE
