"""Sweeps of every manipulation scenario that ships: without faults, by kind of fault, and by how much each key may be.

A rollout counts as completed if its certificate confirms the log. What is finished is not lost: the same command goes
on. Run it as `python -m experiments.sweep.results`; it writes `experiments/results/sweeps.md` and `sweeps.json`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from experiments import scenarios
from experiments.cli.arguments import add_quiet, positive
from experiments.cli.choice import choose
from experiments.cli.files import make_folder, write_bytes, write_json
from experiments.cli.journal import Journal
from experiments.cli.options import add_options
from experiments.cli.progress import Bars, Tell
from experiments.cli.status import BAD_INPUT, DONE, INTERRUPTED
from experiments.sweep.boundary import BoundarySearch, boundary_words
from experiments.sweep.job import Record, Sweep, pack
from experiments.sweep.recorded import RECORDS, Workload, define, work
from experiments.sweep.summary import failed_by_class, share, wilson
from prefplan.errors import PrefplanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from sim.execution.faults import SPELLINGS
from sim.robots.catalogue import DEFAULT
from sim.world.randomization import KEYS, Perturbation, read_perturbation

SEED = 1
"""Seed of every sweep."""

PLANS = ("cost", "preference")

USUAL = Perturbation()

MIXED = read_perturbation(
    "position=8,angle=10,friction=0.2,pads=0.2,table=0.2,force=0.2,mass=0.2,centre=3,latency=20,noise=1"
)
"""Everything differs, and by more."""

Results = dict[str, list[dict[str, Any]]]
"""What was found so far: rows of `plain` and `faults`, and `boundaries`."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry out what is missing, write the results, print them and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rollouts", type=positive, default=100, metavar="N", help="of each sweep (default: 100)")
    parser.add_argument("--scenario", action="append", choices=names(), help="only this one; may be repeated")
    parser.add_argument("--out", type=Path, default=Path("out/sweeps"), help="records (default: out/sweeps)")
    parser.add_argument("--into", type=Path, default=Path("experiments/results"), help="results (default: %(default)s)")
    add_options(parser, "--jobs", "--robot")
    add_quiet(parser)
    options = parser.parse_args(arguments)
    workload = Workload(options.rollouts, options.jobs)
    found: Results = {"plain": [], "faults": [], "boundaries": []}
    status = DONE
    try:
        with Bars(quiet=options.quiet) as bars:
            for name in options.scenario or names():
                measure(
                    name, options.robot, workload, options.out / (options.robot or DEFAULT) / name, found, tell=bars
                )
    except KeyboardInterrupt:
        print("interrupted; the same command goes on", file=sys.stderr)
        status = INTERRUPTED
    except PrefplanError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    page = markdown(found, options.rollouts, options.robot or DEFAULT)
    print(page)
    if status == DONE:
        make_folder(options.into)
        about = {"prefplan": version("prefplan"), "mujoco": version("mujoco")}
        header = {**about, "seed": SEED, "robot": options.robot or DEFAULT, "rollouts": options.rollouts}
        write_json(options.into / "sweeps.json", header | found)
        write_bytes(options.into / "sweeps.md", page.encode())
    return status


def names() -> list[str]:
    """Return the names of the scenarios that ship and can be carried out."""
    return [name for name in scenarios.names() if isinstance(scenarios.find(name).model, ManipulationModel)]


def measure(name: str, robot: str | None, workload: Workload, folder: Path, found: Results, *, tell: Tell) -> None:
    """Add what is found of one scenario, whose records are kept in a folder."""
    scenario = scenarios.find(name)
    planner = Planner(scenario.problem())
    packed = pack(scenario)

    def job(which: str, perturbation: Perturbation, faults: str | None, where: str) -> Sweep:
        plan = choose(planner, which)
        return Sweep(packed, name, which, plan, SEED, perturbation, faults, folder / where, robot=robot)

    def row(job: Sweep) -> dict[str, Any]:
        make_folder(job.folder)
        with Journal(job.folder / RECORDS, define(scenario, job), key="rollout") as records:
            work(job, records, workload, tell=tell, stage=f"{name} {job.folder.name}")
            return summary(name, job, [records.done[number] for number in range(workload.rollouts)])

    for which in PLANS:
        for kind, perturbation in (("usual", USUAL), ("mixed", MIXED)):
            found["plain"].append(row(job(which, perturbation, None, f"{kind}_{which}")))
    for kind in SPELLINGS:
        found["faults"].append(row(job("cost", USUAL, kind, kind)))
    for key in KEYS:
        search = BoundarySearch(scenario, job("cost", USUAL, None, f"boundary_{key}"), key, workload, tell=tell)
        search.run()
        found["boundaries"].append(search.result())


def summary(name: str, job: Sweep, records: Sequence[Record]) -> dict[str, Any]:
    """Return how many rollouts were completed; with a fault, of those in which it happened."""
    counted = [record for record in records if job.faults is None or record.get("happened")]
    completed = sum(record["completed"] for record in counted)
    failed = failed_by_class(counted)
    return {
        "scenario": name,
        "plan": job.which,
        "perturb": str(job.perturbation),
        "faults": job.faults,
        "rollouts": len(counted),
        "completed": completed,
        "interval": wilson(completed, len(counted)),
        "failures": [{"class": why, "count": len(of), "replay": of[0]["replay"]} for why, of in failed.items()],
    }


def markdown(found: Results, rollouts: int, robot: str) -> str:
    """Return the results as a page."""
    by_fault = {(row["scenario"], row["faults"]): row for row in found["faults"]}
    by_key = {(result["scenario"], result["key"]): result for result in found["boundaries"]}
    lines = [
        "# The manipulation scenarios, carried out many times",
        "",
        f"`python -m experiments.sweep.results --rollouts {rollouts}`, robot `{robot}`, seed {SEED}, MuJoCo "
        f"{version('mujoco')}. A rollout is completed if its certificate, derived from the log alone, confirms all "
        "that is said of it. Brackets: 95 % interval (Wilson). `prefplan sweep` explains the keys; the amounts are "
        "the greatest ones.",
        "",
        "## Without faults",
        "",
        *_table(
            ("scenario", "plan", "what differs", "completed", "failures"),
            [(r["scenario"], r["plan"], r["perturb"], _share(r), _failures(r)) for r in found["plain"]],
        ),
        "",
        "## By kind of fault",
        "",
        f"One fault at a random action of the cheapest plan, {USUAL}; of the rollouts in which it happened.",
        "",
        *_table(
            ("scenario", *SPELLINGS),
            [
                (name, *(_share(by_fault[name, kind]) if (name, kind) in by_fault else "" for kind in SPELLINGS))
                for name in dict.fromkeys(row["scenario"] for row in found["faults"])
            ],
        ),
        "",
        *[
            f"- {row['scenario']}, {row['faults']}: {_failures(row)}"
            for row in found["faults"]
            if row["completed"] < row["rollouts"]
        ],
        "",
        "## Boundaries",
        "",
        f"By how much one key may differ, with {USUAL} of the others, until fewer than 95 % of the rollouts of the "
        "cheapest plan are completed. Bisection takes the share to fall with the amount.",
        "",
        *_table(
            ("scenario", "key", "boundary", "failures beyond it"),
            [
                (name, f"{key}, {KEYS[key].unit}", boundary_words(result), _beyond(result))
                for (name, key), result in by_key.items()
            ],
        ),
    ]
    return "\n".join(lines) + "\n"


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (header, ["---"] * len(header), *rows)]


def _share(row: dict[str, Any]) -> str:
    if not row["rollouts"]:
        return "never happened"
    low, high = row["interval"]
    return f"{share(row['completed'], row['rollouts'])} [{low:.1%}, {high:.1%}]"


def _failures(row: dict[str, Any]) -> str:
    """Return the two most frequent reasons of failures in words."""
    told = [f"{failure['count']} x {failure['class']}" for failure in row["failures"][:2]]
    return "; ".join(told).replace("|", "\\|")


def _beyond(result: dict[str, Any]) -> str:
    """Return why rollouts fail at the least amount that is too great."""
    failing = [trial for trial in result["trials"] if trial["holds"] is False]
    return _failures(failing[0]) if failing else ""


if __name__ == "__main__":
    sys.exit(main())
