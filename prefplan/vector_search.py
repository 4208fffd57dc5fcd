"""The search with keys of several entries (`multiobjective`), for measures that need more than (g, mu)."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from prefplan import multiobjective
from prefplan.contracts import value_at
from prefplan.extraction import Waypoint
from prefplan.prepared import Prepared
from prefplan.product import Start
from prefplan.programs import callback, compile_programs, no_callback
from prefplan.search import Search


class VectorSearch(Search):
    """Search with keys of several entries."""

    def __init__(self, prepared: Prepared, *, max_mu: float = math.inf, max_cost: float = math.inf) -> None:
        """Make the search ready; bounds as in `BiObjectiveSearch`, mu's may be a fraction of a quantum."""
        problem = prepared.product.problem
        measure = problem.measure
        self._max_mu = max_mu
        functions = [formula.function for formula in measure.formulas if formula.function is not None]
        self._callback = callback(functions[0], measure.tasks) if functions else no_callback()
        self._programs = compile_programs(measure.formulas)
        scale = 10**problem.decimals
        general = measure.contract == "general"
        every = tuple(range(measure.tasks))
        costs = every if general else sorted({i for formula in measure.formulas for i in formula.costs})
        paid = every if general else sorted({i for formula in measure.formulas for i in formula.violations})
        values = [k for k, f in enumerate(measure.formulas) if f.contract in ("additive", "convex")]
        by_value = len(values) == len(measure.formulas)
        named = {i for f in measure.formulas if f.contract == "componentwise" for i in f.costs}
        priced = {i for f in measure.formulas if f.contract == "componentwise" for i in f.violations}
        ordered, carried, equal = multiobjective.ORDERED, multiobjective.CARRIED, multiobjective.EQUAL
        compare = [ordered] * (1 + len(measure.maxima) + len(values))
        compare += [equal if general else carried if by_value or i not in named else ordered for i in costs]
        compare += [equal if general else carried if by_value or i not in priced else ordered for i in paid]
        exact = measure.integral and problem.decimals == 0
        self._key = multiobjective.Key(
            compare=np.array(compare, dtype=np.int8),
            same_cost=general,
            maxima=len(measure.maxima),
            values=np.array(values, dtype=np.int64),
            costs=np.array(costs, dtype=np.int64),
            violations=np.array(paid, dtype=np.int64),
            unit=prepared.product.unit / scale,
            price=1 / scale,
            weight=float(measure.scale * scale),
            tolerance=0.0 if exact or not measure.formulas else 1e-9,
        )
        self._best = np.empty(2, dtype=np.float64)
        self._scratch = multiobjective.Scratch(np.zeros(len(compare)), np.zeros(measure.tasks), np.zeros(measure.tasks))
        super().__init__(prepared, max_cost)

    def reset(self) -> None:
        """Forget everything but the bounds."""
        self._best[:] = math.inf, self._max_mu if self._max_mu < math.inf else 1e300
        super().reset()

    def _new_labels(self, count: int) -> multiobjective.VectorLabels:
        return multiobjective.VectorLabels(
            np.empty(count, np.int32),
            np.empty(count, self.dtype),
            np.empty(count, np.int32),
            np.empty(count, np.int32),
            np.empty((count, len(self._key.compare))),
            np.empty(count),
        )

    def _run(self, pops: int) -> int:
        end = multiobjective.run_vector(
            self.prepared.view,
            self.growth,
            self._key,
            self._programs,
            self._callback,
            self.prepared.patterns,
            self.states,
            self.labels,
            self.queue,
            self.counters,
            self._best,
            self.bounds,
            self.room,
            self._scratch,
            self.infinite,
            pops,
        )
        return int(end)

    def _mu(self, label: int) -> float:
        return float(self.labels.mu[label])

    def _start_of(self, label: int, at: Waypoint) -> Start:
        first = len(self._key.compare) - len(self._key.violations)
        entered = dict(zip(self._key.violations.tolist(), self.labels.key[label, first:].tolist(), strict=True))
        for start in self._starts:
            same = all(start.violations[i] == paid for i, paid in entered.items())
            if same and self.product.decode(start.code)[1] == at.automata:
                return start
        return super()._start_of(label, at)

    def _widen(self) -> None:
        error = getattr(self._callback, "error", None)
        if isinstance(error, KeyboardInterrupt):
            raise error
        measure, names = self.product.problem.measure, self.product.problem.names
        for formula in measure.formulas:
            costs = [Fraction(float(c)) for c in self._scratch.costs]
            violations = [Fraction(float(v)) for v in self._scratch.violations]
            value_at((costs, violations), formula, names, "preference")
        super()._widen()
