"""`prefplan measure`: time, travel and energy of each action in simulation, for measured costs."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

import prefplan as pp
from experiments.cli import options, output
from experiments.cli.command import command
from experiments.cli.console import Console, table
from experiments.cli.files import make_folder, write_json
from experiments.cli.progress import Bars
from experiments.cli.start import loading_simulation
from experiments.cli.status import DONE, FAILED, INTERRUPTED, tell
from experiments.cli.values import PATH
from prefplan.errors import ModelError

if TYPE_CHECKING:
    from prefplan.models.manipulation.action_costs import Pair
    from prefplan.models.manipulation.measured_costs import Measurement


@command
@options.scenario
@options.as_json
@click.option(
    "--out",
    type=PATH,
    metavar="FILE",
    help="File to write (default: SCENARIO.measured.json beside the scenario, where planning reads it).",
)
@options.jobs
def measure(scenario: str, as_json: bool, out: Path | None, jobs: int | None) -> int:
    """Measure time, travel and energy of each action in simulation, for scenarios with measured costs.

    Examples:
      prefplan measure case_study_3_energy --jobs 4
      prefplan measure case_study_3_energy --out measured.json

    Earlier measurements of the same model, robot and files by the same sources are kept.
    """
    with loading_simulation():
        from joblib import cpu_count
        from joblib.externals.loky.process_executor import TerminatedWorkerError

        from experiments.runs.run_plan import scene_of
        from prefplan.models.manipulation.measured_costs import Measurement, Measurements, measurements_file, to_json
        from sim.capability.sources import digest_of_sources
        from sim.execution.cost_measurement import measure_all, trials
        from sim.external.bundle import digests

    loaded = pp.load(scenario, measured=False)
    failures: dict[Pair, str] = {}
    ended, why = DONE, ""
    with Bars() as bars:
        scene = scene_of(loaded, any_costs=True)
        # The scene's model may have been completed from the user's MJCF.
        model = loaded.model
        assert isinstance(model, pp.ManipulationModel)
        file = out or measurements_file(loaded.path)
        make_folder(file.parent)
        wanted = trials(scene.model)
        digest, files = digest_of_sources(), digests(model)
        done = _earlier(file, model, digest)
        for one in done:
            wanted.pop(one.pair, None)
        before, total = len(done), len(done) + len(wanted)
        try:
            bars("measuring", before, total, "")
            for result in measure_all(scene, wanted, jobs=jobs or cpu_count()):
                if isinstance(result, Measurement):
                    done.append(result)
                else:
                    failures[result.pair] = result.reason
                bars("measuring", len(done) + len(failures), total, " ".join(result.pair))
        except KeyboardInterrupt:
            ended, why = INTERRUPTED, "interrupted"
        except TerminatedWorkerError:
            ended, why = FAILED, "a process that measured was killed"
        finally:
            left = total - len(done) - len(failures)
            contents = to_json(model, Measurements(tuple(done), digest, files, failures, left > 0))
            write_json(file, contents)
    if as_json:
        told = {"scenario": loaded.name, "file": str(file), "complete": len(done) == total}
        output.print_json(told | {"actions": contents["actions"], "failed": contents["failed"]})
    else:
        _show(Console(), loaded.name, file, done, kinds=scene.model.kinds, before=before)
    for reason in failures.values():
        tell(f"not measured: {reason}")
    if ended:
        tell(f"{why}; the same command measures the other {left} actions")
    return ended or (FAILED if failures else DONE)


def _earlier(file: Path, model: pp.ManipulationModel, sources: str) -> list[Measurement]:
    """Return the measurements in a file of the same model by the same sources; none if it is damaged.

    Raises:
        PrefplanError: it is a folder; without this check, the error would come after everything was measured.
    """
    from prefplan.models.manipulation.measured_costs import read_measurements

    if file.is_dir():
        raise pp.PrefplanError(f"{file}: is a folder; name a file")
    with suppress(ModelError):
        earlier = read_measurements(file, model)
        if earlier.sources == sources:
            return list(earlier.actions)
    return []


def _show(
    console: Console, name: str, file: Path, done: Sequence[Measurement], *, kinds: Sequence[str], before: int
) -> None:
    """Print the number of measurements, and the range of each quantity."""
    from prefplan.models.manipulation.action_costs import QUANTITIES

    rows = []
    for kind in kinds:
        measured = [one.quantities for one in done if one.pair[0] == kind]
        if measured:
            columns = [[float(cast(float, quantities[name])) for quantities in measured] for name in QUANTITIES]
            ranges = (f"{min(values):.2f} .. {max(values):.2f}" for values in columns)
            rows.append((kind, str(len(measured)), *ranges))
    heads = ["action", "pairs", *(f"{name} ({unit})" for name, unit in QUANTITIES.items())]
    if done:
        console.print(table(f"{name}: least and greatest cost of an action", heads, rows, right=range(1, len(heads))))
    again = f"; {before} of them before, delete the file to measure them again" if before else ""
    console.print(f"{len(done)} actions are in {file}{again}")
