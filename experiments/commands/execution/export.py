"""`prefplan export`: a run or a scenario's scene as files for other programs."""

from pathlib import Path

import click

import prefplan as pp
from experiments.cli import options
from experiments.cli.command import command
from experiments.cli.files import check_new, make_folder, write_bytes
from experiments.cli.status import DONE, say
from experiments.cli.values import PATH
from prefplan.errors import PrefplanError


@command
@click.argument(
    "source",
    metavar="RUN_OR_SCENARIO",
    type=click.Path(),
    help="glb: log that `prefplan run` wrote, an .npz file; mjcf: a scenario's name or file.",
)
@click.option("--to", type=click.Choice(["glb", "mjcf"]), required=True, help="Format to write.")
@click.option(
    "--out", type=PATH, metavar="PATH", help="File, or folder for mjcf (default: beside the log, out/NAME/mjcf)."
)
@options.robot
@click.option("--force", is_flag=True, help="Replace a file or folder that exists.")
def export(source: str, to: str, out: Path | None, robot: str | None, force: bool) -> int:
    """Write a run as an animated 3-D scene for Blender, or a scenario's scene for MuJoCo.

    Examples:
      prefplan run case_study_3 --no-video && prefplan export out/case_study_3/cost.npz --to glb
      prefplan export out/case_study_3/preference.npz --to glb --out arm.glb --force
      prefplan export case_study_3 --to mjcf --robot fetch

    glb: a run as binary glTF 2.0, y upwards, in metres; the animation's time is the simulated time, s.

    mjcf: the scene that is simulated, a folder with scene.xml and its meshes; keyframe `start` is its start. It opens
    with: python -m mujoco.viewer --mjcf=out/case_study_3/mjcf/scene.xml
    """
    run = Path(source)
    if to == "mjcf":
        if run.suffix == ".npz":
            raise PrefplanError(f"{source}: --to mjcf takes a scenario's name or file, not the log of a run")
        scenario = pp.load(source, measured=False)
        folder = out or Path("out", scenario.name, "mjcf")
        check_new(folder, force=force)
        from experiments.runs.run_plan import scene_of
        from sim.export.mjcf import encode_mjcf

        for name, data in encode_mjcf(scene_of(scenario, robot=robot, any_costs=True)).items():
            path = folder / name
            make_folder(path.parent)
            write_bytes(path, data)
    else:
        if robot is not None:
            raise PrefplanError("--robot: only with --to mjcf; the log of a run names its robot")
        if run.suffix != ".npz":
            raise PrefplanError(f"{run}: --to glb takes the log of a run, an .npz file that `prefplan run` wrote")
        path = out or run.with_suffix(".glb")
        if path.suffix.lower() != ".glb":
            raise PrefplanError(f"{path}: the file's name ends in .glb")
        check_new(path, force=force)
        from sim.evidence.log import read_log
        from sim.export.gltf import encode_glb

        data = encode_glb({run.stem: read_log(run)})
        make_folder(path.parent)
        write_bytes(path, data)
    say(path)
    return DONE
