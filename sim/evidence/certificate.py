"""The certificate of a run: every claim about it, derived again from its log.

The log's commands are simulated again, in the scenario that the verifier gives (`sim.evidence.resimulation`): what
follows from them needs no other check. The propositions after each action are read from the recorded frames
(`sim.evidence.replay`). On that trace `prefplan.claims` derives tasks, costs and mu from their definitions. On purpose,
this uses neither the run's observations, nor the planner's automata, nor `prefplan.ledger`.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco

from prefplan.claims import Check as Check
from prefplan.claims import judge
from prefplan.errors import FormulaError
from prefplan.exact_costs import exact
from prefplan.scenario.decode import Scenario
from sim.errors import LogError
from sim.evidence.action_checks import check_actions
from sim.evidence.fault_checks import check_faults
from sim.evidence.log import Log
from sim.evidence.motion_checks import check_events, check_limits, check_rest
from sim.evidence.replay import RecordedWorld
from sim.evidence.resimulation import resimulate
from sim.evidence.scenario_checks import check_scenario
from sim.evidence.touch_checks import Touches, check_contacts

VERDICTS = ("refuted", "consistent", "proved")
"""What a certificate says about the claims, from the weakest to the strongest."""

EXPLAINED_BY = ("mismatch", "ended", "contact")
"""Kinds of events that say why a run is not completed although every task is satisfied."""


@dataclass(frozen=True)
class Certificate:
    """The result of checking a log.

    Attributes:
        claims: checks of the claims about the run: whether it was completed, its costs, the effect of each action.
        motions: checks of its motions: joint limits, forces, faults, contacts.
        completed: whether the recorded states satisfy every task, relaxations allowed for.
        task_costs: c_i by task name, derived.
        preference: mu, derived.
        equal: whether a simulation in an equal environment, in the verifier's scenario, reproduced every digit.
    """

    claims: tuple[Check, ...]
    motions: tuple[Check, ...]
    completed: bool
    task_costs: Mapping[str, int | float]
    preference: int | float
    equal: bool

    @property
    def verdict(self) -> str:
        """One of `VERDICTS`."""
        if not self.confirmed:
            return "refuted"
        return "proved" if self.equal else "consistent"

    @property
    def checks(self) -> tuple[Check, ...]:
        """All checks."""
        return self.claims + self.motions

    @property
    def agrees(self) -> bool:
        """Whether every claim about the run holds."""
        return all(check.holds for check in self.claims)

    @property
    def confirmed(self) -> bool:
        """Whether every check holds."""
        return all(check.holds for check in self.checks)

    @property
    def refuted(self) -> tuple[Check, ...]:
        """The checks that do not hold."""
        return tuple(check for check in self.checks if not check.holds)

    @property
    def findings(self) -> tuple[Check, ...]:
        """What the run did that no completed run does: a limit exceeded, an unwanted contact, a rule broken."""
        return tuple(check for check in self.checks if check.finding)

    def check(self, name: str) -> Check:
        """Return a check by its name."""
        return next(check for check in self.checks if check.name == name)


@contextmanager
def _checking() -> Iterator[None]:
    """Raise `LogError` for unreadable formulas; keep MuJoCo's warnings about impossible, forged states out of files."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    except FormulaError as error:  # formulas are read where they are used
        raise LogError(f"the scenario in the log cannot be used: {error}") from None
    finally:
        mujoco.set_mju_user_warning(before)


@_checking()
def certify(log: Log, *, scenario: Scenario | None = None) -> Certificate:
    """Check every claim about a run against its recorded frames, and these against a simulation of its commands.

    Args:
        log: of the run.
        scenario: in which it is simulated again; None for the one in the log, which proves nothing about another.

    Raises:
        LogError: the scenario in the log cannot be used, so that nothing can be checked.
    """
    given = [check_scenario(log, scenario)] if scenario else []
    # A log of another scenario is checked in its own scenario.
    world = RecordedWorld(log, scenario if all(check.holds for check in given) else None)
    about, own = log.about, world.scenario
    motions, equal = _physics(log, world)
    trace, actions = check_actions(log, world)
    costs = [exact(action.cost) for action in about.actions]
    verdict = judge(about.claims, own.tasks, own.preference, trace, costs, rules=own.rules)
    claims = (*given, *actions, check_rest(log, world), check_events(log), *verdict.checks)
    if verdict.completed and not about.claims.completed and not _is_explained(log, (*claims, *motions)):
        told = "every task is satisfied, and nothing in the log says why the run is called not completed"
        claims += (Check("not completed", False, told),)
    equal = equal and scenario is not None
    return Certificate(claims, motions, verdict.completed, verdict.task_costs, verdict.preference, equal)


def _physics(log: Log, world: RecordedWorld) -> tuple[tuple[Check, ...], bool]:
    """Simulate the commands again; return the checks of that simulation, and whether every digit is equal."""
    touches = Touches(log, world)
    again = resimulate(log, world, touches)
    forces = again.arrays["pad_forces"]
    world.pad_forces[: len(forces)] = forces
    limits = check_limits(log, world, again.arrays)
    faults, moved = check_faults(log, world, again.changes)
    return (*limits, again.check, faults, check_contacts(log, touches, moved)), again.equal


def _is_explained(log: Log, checks: Sequence[Check]) -> bool:
    """Return whether a log says why its run is not completed."""
    told = any(event.kind in EXPLAINED_BY for event in log.about.events)
    return told or bool(log.about.setting.get("interrupted")) or any(check.finding for check in checks)
