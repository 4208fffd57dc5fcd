"""`prefplan export`: a run or a scenario's scene as files for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

import shtab

from experiments.cli.arguments import Commands, add_command
from experiments.cli.completion import complete
from experiments.cli.files import check_new, make_folder, write_bytes
from experiments.cli.options import add_options
from experiments.cli.start import loading
from experiments.cli.status import DONE
from prefplan.errors import PrefplanError
from prefplan.scenario.decode import load

FORMATS = ("glb", "mjcf")


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan run case_study_3 --no-video && prefplan export out/case_study_3/cost.npz --to glb",
        "prefplan export out/case_study_3/preference.npz --to glb --out arm.glb --force",
        "prefplan export case_study_3 --to mjcf --robot fetch",
    )
    more = (
        "glb: a run as binary glTF 2.0, y upwards, in metres; the animation's time is the simulated time, s.\n\n"
        "mjcf: the scene that is simulated, a folder with scene.xml and its meshes; keyframe `start` is its start. "
        "It opens with: python -m mujoco.viewer --mjcf=out/case_study_3/mjcf/scene.xml"
    )
    parser = add_command(commands, export, *examples, more=more)
    source = parser.add_argument(
        "source",
        metavar="RUN_OR_SCENARIO",
        help="glb: log that `prefplan run` wrote, an .npz file; mjcf: a scenario's name or file",
    )
    complete(source, shtab.FILE)
    parser.add_argument("--to", choices=FORMATS, required=True, help="format to write")
    out = parser.add_argument(
        "--out", type=Path, metavar="PATH", help="file, or folder for mjcf (default: beside the log, out/NAME/mjcf)"
    )
    complete(out, shtab.FILE)
    add_options(parser, "--robot")
    parser.add_argument("--force", action="store_true", help="replace a file or folder that exists")


def export(options: argparse.Namespace) -> int:
    """Write a run as an animated 3-D scene for Blender, or a scenario's scene for MuJoCo."""
    if options.to == "mjcf":
        return _export_scene(options)
    if options.robot is not None:
        raise PrefplanError("--robot: only with --to mjcf; the log of a run names its robot")
    run = Path(options.source)
    if run.suffix != ".npz":
        raise PrefplanError(f"{run}: --to glb takes the log of a run, an .npz file that `prefplan run` wrote")
    path: Path = options.out or run.with_suffix(".glb")
    if path.suffix.lower() != ".glb":
        raise PrefplanError(f"{path}: the file's name ends in .glb")
    check_new(path, force=options.force)
    with loading():
        from sim.evidence.log import read_log
        from sim.export.gltf import encode_glb

    data = encode_glb({run.stem: read_log(run)})
    make_folder(path.parent)
    write_bytes(path, data)
    print(path)
    return DONE


def _export_scene(options: argparse.Namespace) -> int:
    if Path(options.source).suffix == ".npz":
        raise PrefplanError(f"{options.source}: --to mjcf takes a scenario's name or file, not the log of a run")
    scenario = load(options.source)
    folder: Path = options.out or Path("out", scenario.name, "mjcf")
    check_new(folder, force=options.force)
    with loading():
        from experiments.cli.simulation_options import robot_of
        from experiments.runs.carry_out import scene_of
        from sim.export.mjcf import encode_mjcf

    files = encode_mjcf(scene_of(scenario, robot=robot_of(options.robot)))
    for name, data in files.items():
        make_folder((folder / name).parent)
        write_bytes(folder / name, data)
    print(folder / name)
    return DONE
