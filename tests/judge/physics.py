"""What `sim.capability` says that the arm cannot do, tried in physics: `PYTHONPATH=tests python -m judge.physics`.

The cheapest plans of random scenes are searched for. What they meet of what the arm can never do at a location is tried
from five starts: the hand comes from five places to grasp the object, or brings it from five locations, with the other
objects in their places and with all but its supports away. Each transfer that was refused is tried as it is, among the
same objects. One success refutes the exclusion.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from unittest.mock import patch

import mujoco

from judge.random_scenes.generator import scene_text
from prefplan import Planner, Scenario, load
from prefplan.errors import PrefplanError
from prefplan.limits import Limits
from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.model import ManipulationModel
from sim.capability.answers import Capability
from sim.capability.arrangement import Places, arranged, positions, staged
from sim.capability.place_check import PlaceCheck
from sim.capability.rehearsal import BROUGHT, TAKEN, Rehearsal, bringing, dispensable
from sim.execution.executor import Execution
from sim.world.scene import Scene, build_scene, initial_state

STARTS = 5
"""Number of places from which the hand or the object comes."""

MAX_BYTES, MAX_SECONDS = 1e9, 60.0
"""Limits of the search for the plans of a scene."""


@patch.dict(os.environ, XDG_CACHE_HOME=os.devnull)  # no answer is kept
def excluded(scenario: Scenario, scene: Scene) -> tuple[list[PlaceCheck], list[Transfer]]:
    """Return the checks of what plans do without, and the transfers that were refused."""
    assert isinstance(scenario.model, ManipulationModel)
    arm = Capability(scenario.model, scene=scene)
    if arm.check_start() is not None:
        return [], []
    planner = Planner(replace(scenario, feasible=arm).problem())
    with suppress(PrefplanError), Limits(bytes=MAX_BYTES, seconds=MAX_SECONDS):
        planner.cheapest()
    assert planner.geometry is not None
    refused = [transfer for transfer, answer in planner.geometry._rehearsed.items() if answer is not None]
    return [arm.check(*pair) for pair in planner.geometry.left_out], refused


def trials(model: ManipulationModel, found: PlaceCheck) -> Iterator[Rehearsal]:
    """Yield what refutes an exclusion if the arm can do it; nothing for one that holds only while something stands.

    What cannot be grasped where it starts is never put down there.
    """
    obj, location, start = found.obj, found.location, model.initial_state.place[found.obj]
    places = arranged(model, obj, location)
    assert places is not None
    taken = {location, *places.values()}
    free = [place.name for place in model.locations if place.name not in taken and not place.on]
    if not found.take:
        staying = Rehearsal((f"transit {location}", f"grasp {obj}"), places, obj, location)
        yield from (replace(staying, via=via) for via in islice(("", *free), STARTS))
    if not found.put and (found.take or location != start):
        origins = [place for place in (start, *free) if place != location]
        yield from (bringing(obj, origin, location, places).beginning(BROUGHT) for origin in origins[:STARTS])


def succeeds(scene: Scene, trial: Rehearsal, places: Places) -> bool:
    """Return whether the arm can do in physics what a rehearsal says, with objects in these places alone."""
    arrangement = staged(scene, places)
    data = initial_state(arrangement)
    data.qpos[:] = positions(scene, arrangement)
    mujoco.mj_forward(scene.mujoco, data)
    run = Execution(replace(arrangement, model=replace(arrangement.model, begin=None)), data)
    actions = [*([f"transit {trial.via}"] if trial.via else []), *trial.actions]
    return all(run.step(action, ahead=actions[k:]) for k, action in enumerate(actions, 1))


def rehearsal_of(transfer: Transfer) -> Rehearsal:
    """Return what a transfer is."""
    where = bringing(transfer.obj, transfer.source, transfer.target, dict(transfer.others))
    return where.beginning(BROUGHT if transfer.target else TAKEN)


def is_possible(scene: Scene, trial: Rehearsal) -> bool:
    """Return whether a trial succeeds with the other objects there or away."""
    others = dispensable(trial, scene.model)
    alone = {name: place for name, place in trial.places.items() if name not in others}
    for places in (trial.places, alone):
        with suppress(PrefplanError):
            if succeeds(scene, trial, places):
                return True
    return False


def main() -> int:
    """Try the exclusions of some scenes; the exit status is 1 if one is refuted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    options, count, refuted, transfers, possible = parser.parse_args(), 0, 0, 0, 0
    for number in range(options.scenes):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"scene_{number}.toml"
            path.write_text(scene_text(options.seed, number))
            try:
                scenario = load(path)
                assert isinstance(scenario.model, ManipulationModel)
                scene = build_scene(scenario.model)
            except PrefplanError:
                continue
            checks, refused = excluded(scenario, scene)
            for transfer in refused:
                transfers += 1
                trial = rehearsal_of(transfer)
                with suppress(PrefplanError):
                    if succeeds(scene, trial, trial.places):
                        possible += 1
                        print(f"scene {number}: possible: {transfer}", flush=True)
            for found in checks:
                for kind, length in (("grasp", TAKEN), ("put down", BROUGHT)):
                    tried = [one for one in trials(scenario.model, found) if len(one.actions) == length]
                    count += bool(tried)
                    if any(is_possible(scene, one) for one in tried):
                        refuted += 1
                        print(f"scene {number}: {kind} {found.obj} at {found.location} is possible: {found.reason}")
    print(f"{options.scenes} scenes from seed {options.seed}: {count} exclusions, {refuted} of them possible")
    print(f"{transfers} transfers refused, {possible} of them possible")
    return 1 if refuted or possible else 0


if __name__ == "__main__":
    sys.exit(main())
