"""Measured costs: each action is simulated in states in which it is applicable, after the actions that lead there."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import cast

import numpy as np
from joblib import delayed

from prefplan.models.manipulation.action_costs import MeasuredCosts, Pair
from prefplan.models.manipulation.measured_costs import Measurement
from prefplan.models.manipulation.model import ManipulationModel, ManipulationState
from prefplan.models.manipulation.slots import hand_poses, location_of
from prefplan.models.manipulation.symbolic import Action, at, holding
from sim.capability.arrangement import beginning
from sim.errors import SimulationError
from sim.perception.grounding import observe
from sim.perception.sensors import true_poses
from sim.processes import in_processes
from sim.simulation.run import Effort
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import SKILLS, perform
from sim.skills.skill import Skill, SkillError
from sim.world.scene import Scene, initial_state

SAMPLES = 4
"""Number of simulations of a pair, spread over its states; at least one for each object that the action can have."""

BATCH = 8
"""Number of actions that a process measures before it reports them: a few seconds of work."""


@dataclass(frozen=True)
class Trial:
    """An action to simulate, e.g. `transport blue san`, and the state of the model before it.

    `put` is the object that the hand has just released and is still above; None if the hand came from elsewhere.
    """

    state: ManipulationState
    action: str
    put: str | None = None


@dataclass(frozen=True)
class Failure:
    """An action that failed in every simulation, with the reason of the first failure."""

    pair: Pair
    reason: str


def trials(model: ManipulationModel) -> dict[Pair, tuple[Trial, ...]]:
    """Return the simulations for every kind of action and pair of hand poses that occurs in the model.

    The samples cover every object that the action can have, and spread evenly over the states from the start to the
    remotest. In a large model, states that differ only by exchanged objects count as one; there the samples cover all
    movable objects.
    """
    hands = hand_poses({place.name: place.capacity for place in model.locations}, model.start)
    pairs = [
        (operator.kind, before, after)
        for operator, before, after in product(model.operators, hands, hands)
        if (location_of(before) != location_of(after)) == operator.travels
    ]
    # The cost of an edge is the number of its pair.
    numbered = MeasuredCosts("time", {pair: number for number, pair in enumerate(pairs)})
    whole = replace(model, costs=numbered).transition_system()
    system, alike = whole.small, list[str]()
    if system is None:
        system = whole.reduced((), stutter_invariant=False).listed
        alike = [obj.name for obj in model.objects if not obj.fixed]
    number = system.costs[0].counts(Fraction(1))
    order = np.argsort(number, kind="stable")
    bounds = np.searchsorted(number[order], np.arange(len(pairs) + 1))
    edges = {pair: order[low:high] for pair, low, high in zip(pairs, bounds, bounds[1:], strict=False) if low < high}
    sources = np.repeat(np.arange(system.size), np.diff(system.offsets))
    actions = [model.action(name) for name in system.action_names]
    placing = np.array([at(action.obj, action.location) in model.effect(action) for action in actions])
    placed = np.zeros(system.size, dtype=bool)
    placed[system.targets[placing[system.actions]]] = True

    def trial(edge: int, obj: str) -> Trial:
        state, action = cast(ManipulationState, system.states[int(sources[edge])]), actions[system.actions[edge]]
        if obj != action.obj:
            state, action = _exchanged(model, state, obj, action.obj), replace(action, obj=obj)
        working = state.hand_slot is not None or not action.obj
        put = _put(state) if working and placed[sources[edge]] and state.held is None else None
        return Trial(state, str(action), put)

    chosen = {}
    for pair, all_edges in edges.items():
        # In plans a transit nearly always follows a release.
        likely = all_edges[placed[sources[all_edges]]] if pair[0] == "transit" else all_edges
        taken = likely if len(likely) else all_edges
        turns = {actions[a].obj: taken[system.actions[taken] == a] for a in np.unique(system.actions[taken])}
        if alike and "" not in turns:
            turns = dict.fromkeys(alike, taken)
        chosen[pair] = tuple(trial(edge, obj) for edge, obj in _sample(turns))
    return chosen


def measure(
    scene: Scene, pair: Pair, samples: Sequence[Trial], skills: Mapping[str, Skill] = SKILLS
) -> Measurement | Failure:
    """Simulate an action in every sample and return the mean effort of those in which it succeeded."""
    efforts, failures = [], []
    for trial in samples:
        try:
            efforts.append(simulate(scene, trial, skills))
        except SimulationError as error:
            failures.append(f"`{trial.action}` with {trial.state}: {error}")
    if not efforts:
        return Failure(pair, failures[0])
    total = sum(efforts, start=Effort())
    return Measurement(pair, {name: value / len(efforts) for name, value in vars(total).items()}, len(efforts))


def measure_all(
    scene: Scene, wanted: Mapping[Pair, Sequence[Trial]], *, jobs: int = 1, skills: Mapping[str, Skill] = SKILLS
) -> Iterator[Measurement | Failure]:
    """Measure the actions of `trials` in `jobs` processes (1: this process), and yield results as they are finished."""
    if jobs == 1:
        yield from (measure(scene, pair, samples, skills) for pair, samples in wanted.items())
    else:
        calls = (delayed(measure)(scene, pair, samples, skills) for pair, samples in wanted.items())
        yield from in_processes(calls, jobs=jobs, batch=BATCH)


def simulate(scene: Scene, trial: Trial, skills: Mapping[str, Skill] = SKILLS) -> Effort:
    """Return the effort of an action from rest to rest; the actions that lead to its state do not count.

    In a run, movements begin before the previous ones end, which saves 1 to 2 % of the energy. An object that the hand
    holds or has just released is first grasped at the hand's location, so that it lies in the hand as in an execution.

    Raises:
        SimulationError: the action, or one of those that lead to its state, fails.
    """
    state, model = trial.state, scene.model
    resting, slots = state.place, dict(state.slots)
    if state.held:
        resting[state.held] = state.hand
        if state.hand_slot is not None:
            slots[state.held] = state.hand_slot
    scene = beginning(scene, resting, slots)
    cell = Workcell(scene, initial_state(scene))
    taken, action = state.held or trial.put, model.action(trial.action)
    before = [
        *([Action("transit", location=state.hand)] if state.hand in scene.slots else ()),
        *([Action("grasp", taken)] if taken else ()),
        *([Action("release", trial.put, state.hand)] if trial.put else ()),
    ]
    # An object is grasped so that it can be put down where it goes.
    after = [Action("release", state.held, action.location)] if state.held and action.location else []
    for done, earlier in enumerate(before, start=1):
        perform(cell, earlier, skills, ahead=[*before[done:], action, *after])
    spent = cell.effort
    perform(cell, action, skills, ahead=after)
    _check_effect(cell, action)
    return cell.effort - spent


def _exchanged(model: ManipulationModel, state: ManipulationState, one: str, other: str) -> ManipulationState:
    """Return the state with two objects exchanged."""
    name = {obj.name: obj.name for obj in model.objects} | {one: other, other: one}
    return replace(
        state,
        held=None if state.held is None else name[state.held],
        places=tuple((name[obj], place) for obj, place in state.places),
        marks=frozenset((name[obj], mark) for obj, mark in state.marks),
        slots=tuple((name[obj], slot) for obj, slot in state.slots),
    )


def _put(state: ManipulationState) -> str | None:
    """Return the object in the slot where the empty hand is, or None."""
    slots = dict(state.slots)
    here = (obj for obj, place in state.places if place == state.hand and slots.get(obj) == state.hand_slot)
    return next(here, None)


def _check_effect(cell: Workcell, action: Action) -> None:
    """Raise SkillError unless an action is observed to have its effect: of a transit, the hand at its location."""
    scene, poses, held = cell.scene, true_poses(cell.scene, cell.data), cell.held()
    effect = scene.model.effect(action) & {holding(action.obj), at(action.obj, action.location)}
    seen = observe(scene, cell.data, poses, hand=action.location, held=held)
    if not effect <= seen.label or (not effect and seen.hand != action.location):
        raise SkillError("it had no effect")


def _sample(turns: Mapping[str, np.ndarray]) -> list[tuple[int, str]]:
    """Return a pair's edges, sampled from the first to the last, each with its object; `turns` has them by object."""
    count = len(turns) * max(1, round(SAMPLES / len(turns)))
    chosen = []
    for turn, share in enumerate(np.linspace(0, 1, count)):
        obj = list(turns)[turn % len(turns)]
        chosen.append((int(turns[obj][round(share * (len(turns[obj]) - 1))]), obj))
    return list(dict.fromkeys(chosen))
