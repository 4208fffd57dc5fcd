"""The search with keys of several entries (`multi_objective`), for measures for which (g, mu) is not sufficient."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from prefplan.errors import PreferenceError
from prefplan.heuristics.preprocessing import Prepared
from prefplan.preferences.contracts import text_of_costs, value_at
from prefplan.product.formula_programs import compile_programs
from prefplan.product.starts import Start
from prefplan.search import multi_objective
from prefplan.search.driver import Search, in_units
from prefplan.search.labels import END


class VectorSearch(Search):
    """Best-first search with keys of several entries."""

    pops = 2_000

    def __init__(self, prepared: Prepared, *, max_mu: Fraction | None, max_cost: float, single: bool) -> None:
        """Make the search ready; arguments are those of `BiObjectiveSearch`."""
        problem = prepared.product.problem
        measure = problem.measure
        self._max_mu, self.single = max_mu, single
        self._programs = compile_programs(list(measure.formulas), prepared.product.units, len(problem.priced))
        general = measure.contract == "general"
        costs = range(measure.tasks) if general else sorted({i for formula in measure.formulas for i in formula.costs})
        paid = (
            range(len(problem.priced))
            if general
            else sorted({i for formula in measure.formulas for i in formula.violations})
        )
        values = [k for k, f in enumerate(measure.formulas) if f.contract in ("additive", "convex")]
        by_value = len(values) == len(measure.formulas)
        named = {i for f in measure.formulas if f.contract == "componentwise" for i in f.costs}
        priced = {i for f in measure.formulas if f.contract == "componentwise" for i in f.violations}
        ordered, carried, equal = multi_objective.ORDERED, multi_objective.CARRIED, multi_objective.EQUAL
        compare = [ordered] * (1 + len(measure.maxima) + len(values))
        compare += [equal if general else carried if by_value or i not in named else ordered for i in costs]
        compare += [carried if not general and (by_value or i not in priced) else ordered for i in paid]
        self._key = multi_objective.Key(
            compare=np.array(compare, dtype=np.int8),
            same_cost=general,
            maxima=len(measure.maxima),
            values=np.array(values, dtype=np.int64),
            costs=np.array(costs, dtype=np.int64),
            violations=np.array(paid, dtype=np.int64),
        )
        self._best = np.empty(2, dtype=np.float64)
        self._least: Fraction | float | None = None
        self._scratch = multi_objective.Scratch(
            np.zeros(len(compare)), np.zeros(len(problem.priced)), np.zeros(len(problem.priced))
        )
        super().__init__(prepared, max_cost)

    def reset(self) -> None:
        """Forget everything but the bounds."""
        self._least = None
        self._best[:] = math.inf, 1e300
        if self._max_mu is not None:
            self._best[1] = float_above(in_units(self.prepared.product, self._max_mu))
        super().reset()

    def _begin(self, start: Start) -> list[int]:
        measure, units = self.product.problem.measure, self.product.units
        amounts = start.amounts(self.product.problem.objectives[0])
        key = [int(measure.summed(*amounts) / units.mu)]
        key += [int(term.value(*amounts) / units.mu) for term in measure.maxima]
        key += [0] * len(self._key.values)
        key += [start.finished[i] or 0 for i in self._key.costs]
        return key + [start.violations[i] for i in self._key.violations]

    def _new_labels(self, count: int) -> multi_objective.VectorLabels:
        return multi_objective.VectorLabels(
            np.empty(count, np.int32),
            np.empty(count, np.int64),
            np.empty(count, np.int32),
            np.empty(count, np.int32),
            np.empty((count, len(self._key.compare))),
            np.empty(count),
        )

    def _run(self, pops: int) -> int:
        space, bounds, own = self.prepared.space, self.prepared.bounds, (self._key, self._programs)
        memory = self.states, self.labels, self.queue, self.counters, self.limits, self.begin, self.buffer
        end = multi_objective.run_vector(space, self.growth, bounds, *memory, *own, self._best, self._scratch, pops)
        if end == END.FALLS:
            at = text_of_costs(self._vector(), self.product.problem.priced)
            raise PreferenceError(f"preference: mu falls along a trajectory, on the last action to {at}")
        return int(end)

    def _objectives(self, label: int) -> tuple[Any, ...]:
        return self._paths([label]).objectives()[0]

    def _accept(self, label: int, objectives: tuple[Any, ...]) -> bool:
        mu = objectives[1]
        if (self._least is not None and mu >= self._least) or (self._max_mu is not None and mu > self._max_mu):
            return False
        self._least = mu
        self._best[0] = float_above(in_units(self.product, Fraction(mu)))
        return True

    def _start_of(self, label: int, automata: tuple[int, ...]) -> Start:
        first = 1 + self._key.maxima
        values = range(first, first + len(self._key.values))
        keys = np.delete(self.begin, values, axis=1) == np.delete(self.labels.key[label], values)
        same = zip(self._starts, keys.all(axis=1), strict=True)
        return next(start for start, alike in same if alike and start.automata == automata)

    def _too_large(self) -> None:
        """Raise an error that names the user's function if that is the cause."""
        error = self._programs.callback.error
        if isinstance(error, KeyboardInterrupt):
            raise error
        measure, names = self.product.problem.measure, self.product.problem.priced
        for formula in measure.formulas:
            value_at(self._vector(), formula, names, "preference")

    def _vector(self) -> tuple[list[Fraction], list[Fraction]]:
        """Return task costs and violation costs of the successor evaluated last, in the user's units."""
        units = self.product.units
        costs = [Fraction(float(c)) * units.cost for c in self._scratch.costs]
        return costs, [Fraction(float(v)) * units.price for v in self._scratch.violations]


def float_above(value: Fraction) -> float:
    """Return the least float that is no less than a number."""
    try:
        nearest = float(value)
    except OverflowError:
        return math.inf
    return nearest if nearest >= value else math.nextafter(nearest, math.inf)
