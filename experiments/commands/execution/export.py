"""`prefplan export`: a run as a file for other programs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import shtab

from experiments.cli.arguments import Commands, add_command
from experiments.cli.completion import complete
from experiments.cli.files import make_folder, write_bytes
from experiments.cli.start import loading
from experiments.cli.status import DONE
from prefplan.errors import PrefplanError


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Write a run as an animated 3-D scene for Blender and other programs."
    examples = (
        "prefplan run case_study_3 --no-video && prefplan export out/case_study_3/cost.npz --to glb",
        "prefplan export out/case_study_3/preference.npz --to glb --out arm.glb --force",
    )
    more = "glb: binary glTF 2.0, y upwards, in metres; the animation's time is the simulated time in seconds."
    parser = add_command(commands, export, summary, *examples, more=more)
    run = parser.add_argument("run", type=Path, metavar="RUN", help="log that `prefplan run` wrote, an .npz file")
    complete(run, shtab.glob("*.npz"))
    parser.add_argument("--to", choices=FORMATS, required=True, help="format of the file")
    out = parser.add_argument("--out", type=Path, metavar="FILE", help="file to write (default: beside the log)")
    complete(out, shtab.FILE)
    parser.add_argument("--force", action="store_true", help="replace FILE if it exists")


def export(options: argparse.Namespace) -> int:
    """Carry out `prefplan export`."""
    path: Path = options.out or options.run.with_suffix(f".{options.to}")
    if path.suffix.lower() != f".{options.to}":
        raise PrefplanError(f"{path}: the file's name ends in .{options.to}")
    if path.exists() and not options.force:
        raise PrefplanError(f"{path}: already exists; --force replaces it")
    data = FORMATS[options.to](options.run)
    make_folder(path.parent)
    write_bytes(path, data)
    print(path)
    return DONE


def _glb(run: Path) -> bytes:
    with loading():
        from sim.evidence.log import read_log
        from sim.export.gltf import encode_glb

    return encode_glb({run.stem: read_log(run)})


FORMATS: dict[str, Callable[[Path], bytes]] = {"glb": _glb}
"""Each returns the contents of a file in the format that it is named after."""
