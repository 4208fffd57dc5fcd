"""Fault injection: faults in a running simulation, scheduled or triggered by a user; a seed determines them."""

from collections.abc import Iterator, MutableMapping, Sequence

import mujoco
import numpy as np

from sim.execution.faults.fault import Fault, Injection
from sim.simulation.plant import Observer, Plant
from sim.simulation.workcell import Workcell
from sim.skills.skill import Skill

STREAM = 2
"""Number of the random stream for faults, so that a seed gives the same start poses with and without faults."""

MAX_DELAY_S = 1.0
"""Greatest random delay of a fault that waits after the first moment at which it can happen, s."""


class FaultInjector(Observer):
    """Injects faults into a running simulation when they fall due, or at once.

    Attributes:
        happened: simulated time of each fault that has happened, s, by its index.
    """

    def __init__(
        self, cell: Workcell, skills: MutableMapping[str, Skill], faults: Sequence[Fault], *, seed: int | None
    ) -> None:
        """Prepare to inject faults into a simulation and its skills, which faults may wrap; a seed of None is 0."""
        self._cell, self._skills, self._seed, self._drawn = cell, skills, seed or 0, 0
        self._spares: Iterator[str] = iter(cell.scene.spares)
        self._faults = [(i, fault, self._injection(MAX_DELAY_S)) for i, fault in enumerate(faults)]
        self.happened: dict[int, float] = {}
        self._action = 0
        cell.observers.append(self)

    def begin(self, action: int) -> None:
        """Let the faults happen, if they can, that fall due with an executed action, numbered from 1."""
        self._action = action
        self.before_period(self._cell)

    def before_period(self, cell: Plant) -> None:
        """Let the faults that are due happen if they can."""
        for i, fault, injection in self._faults:
            if i not in self.happened and fault.action <= self._action and self._happens(fault, injection):
                self.happened[i] = float(cell.data.time)

    def end(self) -> None:
        """Log the faults that have not happened by the end of the run, and why."""
        for i, fault, _ in self._faults:
            if i in self.happened:
                continue
            ended = f"after action {self._action}" if self._action else "before its first action"
            late = fault.action > self._action
            reason = f"the run ended first, {ended}" if late else "it was never possible before the run ended"
            self._cell.log_event("not injected", fault=str(fault), reason=reason)

    def inject(self, fault: Fault) -> bool:
        """Let a fault happen now if it can, whenever it falls due; return whether it happens."""
        return self._happens(fault, self._injection(0.0))

    def _injection(self, max_delay: float) -> Injection:
        """Return what a fault acts on, with random numbers of its own."""
        rng = np.random.default_rng([self._seed, STREAM, self._drawn])
        self._drawn += 1
        delay = float(rng.uniform(0, max_delay)) if max_delay else 0.0
        return Injection(self._cell, self._skills, self._spares, rng, delay)

    def _happens(self, fault: Fault, injection: Injection) -> bool:
        """Let a fault happen if it can, and return whether it does."""
        detail = fault.inject(injection)
        if detail is None:
            return False
        self._cell.log_event("fault", fault=str(fault), **detail)
        mujoco.mj_forward(self._cell.scene.mujoco, self._cell.data)
        return True
