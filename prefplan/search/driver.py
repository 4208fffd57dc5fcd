"""The loop around the compiled search, which runs in slices so that it can be limited and interrupted."""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache, partial
from operator import attrgetter, le
from typing import TYPE_CHECKING, Any

import numpy as np

from prefplan.errors import LimitError
from prefplan.front import Stats
from prefplan.heuristics.prepare import Prepared
from prefplan.limits import check_limits, left
from prefplan.models.kernels import UNBOUNDED, compile_kernels, is_interpreted
from prefplan.plan import Plan
from prefplan.product.contraction import edges_between
from prefplan.product.successors import successor_buffer
from prefplan.search.keys import FALL, KeyMap, ordered_number
from prefplan.search.label_search import run
from prefplan.search.labels import AT, BOUND, CODE, END, NONE, PRODUCT_LIMIT, Labels, Memory, Queue, States, enlarged
from prefplan.search.paths import Goal, Result, ended_by, plan_of

if TYPE_CHECKING:
    from prefplan.search.values import Values

ROWS_AT_FIRST, LABELS_AT_FIRST = 2**14, 2**15

GOALS_AT_ONCE = 2**8
"""Most goals that one run of a kernel finds; starting a run takes 0.7 ms."""

INTERPRETED_POPS = 100
"""Labels popped in one run of a kernel in Python, some tens of milliseconds; the next run may be compiled."""


class LabelSearch:
    """Search for all non-dominated vectors of costs and preferences, or for one that is least in one of them.

    Attributes:
        pops: labels popped between two checks of the limits, a few tens of milliseconds.
    """

    pops = 2_000

    def __init__(
        self, prepared: Prepared, *, bounds: Mapping[str, Fraction], first: str | None = None, hasty: bool = False
    ) -> None:
        """Make the search ready.

        Args:
            prepared: what is searched.
            bounds: inclusive bounds of objectives by name, in the user's units.
            first: the objective whose least value is wanted; None for the whole front.
            hasty: whether to stop at the first goal, even if it is not the best.

        Raises:
            OverflowError: 64 bits may not be enough.
        """
        self.prepared, self.product, self.problem = prepared, prepared.product, prepared.product.problem
        self.bounds, self.single, self._hasty, names = bounds, first is not None, hasty, self.problem.objective_names
        self._first = names.index(first or names[0])
        self._layout = KeyMap.of(self.product)
        self._values: Values | None = None
        is_lexicographic = self.single and self._keeps_order and not hasty
        compared = [o for o, name in enumerate(names) if name in bounds] if is_lexicographic else self._layout.compared
        if is_lexicographic or len(names) > 2:
            compared = [e for e in compared if e != self._first]
        elif hasty and self._keeps_order:
            compared = [self._first]
        self.keys = self._layout.arrays(
            [] if prepared.graph.contracted else prepared.costs,
            first=self._first,
            compared=compared,
            lexicographic=is_lexicographic,
        )
        if self.keys.computed:
            compile_kernels()
        begins = sorted((self._layout.begin(start), k) for k, start in enumerate(self.product.starts))
        self._starts = [self.product.starts[k] for _, k in begins]
        self._begin = np.array([key for key, _ in begins], dtype=np.int64).reshape(-1, len(self._layout.entries))
        if self._begin.max(initial=0) >= PRODUCT_LIMIT:
            raise OverflowError
        _, self._free = left()
        self.reset()

    @property
    def _keeps_order(self) -> bool:
        """Whether, of two labels of a product state, the lexicographically smaller stays so in every continuation."""
        measures = self.problem.objectives
        if all(measure.bi_objective and measure.contract == "additive" for measure in measures):
            return True
        return self.problem.is_bi_objective and measures[0].bi_objective and self._first == 0

    def reset(self) -> None:
        """Start the search again: the start states are entered as successors of no label."""
        space, count, width = self.prepared.space, len(self._starts), len(self._layout.entries)
        # `_found` has the labels of goals, with their exact objectives.
        self._lowest, self._found = 0.0, dict[int, tuple[Any, ...]]()
        counters = np.zeros(len(AT), dtype=np.int64)
        counters[[AT.PARENT, AT.COUNT]] = NONE, count
        rows, parents, steps, siblings, goals = np.empty((5, LABELS_AT_FIRST), np.int32)
        self.memory = Memory(
            States(
                np.empty((ROWS_AT_FIRST, BOUND + self.keys.objectives), np.int64),
                np.full(2 * ROWS_AT_FIRST, NONE, np.int32),
            ),
            Labels(rows, parents, steps, siblings, np.empty((LABELS_AT_FIRST, width), np.int64)),
            Queue(*np.empty((2, LABELS_AT_FIRST), np.int64)),
            np.empty(1 if self.single else GOALS_AT_ONCE, np.int32),
            goals,
            counters,
            np.array([self._limit(name, o) for o, name in enumerate(self.problem.objective_names)], dtype=np.int64),
            self._begin,
            successor_buffer(space, count),
        )
        strides = space.automata.strides
        states = np.array([start.automata for start in self._starts], dtype=np.int64).reshape(count, len(strides))
        self.memory.buffer.code[:count] = self.prepared.graph.start + states @ strides

    def _limit(self, name: str, o: int) -> int:
        """Return the inclusive limit of an objective, in units; a rounded value is checked when a goal is found."""
        if name not in self.bounds:
            return UNBOUNDED
        bound = self.bounds[name]
        if o < len(self.problem.cost_names):
            most = math.floor(bound / self.problem.cost_units[o])
            return self._up_to(most) if o == 0 else min(most, UNBOUNDED)
        objective = self.problem.objectives[o - len(self.problem.cost_names)]
        rest = bound - objective.constant
        if objective.is_whole:
            return max(-1, min(math.floor(rest / objective.unit), UNBOUNDED))
        return ordered_number(float(rest)) + FALL if rest >= 0 else -1

    def _up_to(self, cost: int) -> int:
        """Return the largest cost of a label, with low bits, that is at most `cost` units."""
        shift = self._layout.shift
        return (min(cost, (UNBOUNDED >> shift) - 1) + 1 << shift) - 1

    def run(self, *, most_expanded: float = math.inf) -> Result:
        """Search until all goals are found, `most_expanded` labels are expanded, or a limit or Ctrl-C ends the search.

        Another call continues the search.
        """
        ended = None
        try:
            while not self.is_done and (self._is_pending or self.memory.counters[AT.EXPANDED] < most_expanded):
                pops = INTERPRETED_POPS if is_interpreted() else self.pops
                pops = max(1, min(pops, most_expanded - self.memory.counters[AT.EXPANDED]))
                self._advance(int(pops))
                if not self.is_done:
                    check_limits()
        except (LimitError, KeyboardInterrupt) as error:
            ended = ended_by(error)
        settled = [label for label in self._found if self._rank(label) < self._lowest]
        kept = settled or (list(self._found)[-1:] if self.single else [])
        below = self._lowest if not self._first or self._lowest == math.inf else 0
        return Result(tuple(self._points(self._goals(kept))), ended, below, self.work)

    def _run(self, pops: int) -> int:
        """Run the kernel until `pops` labels are popped, or it ends for another reason; return the reason (`END`)."""
        prepared = self.prepared
        wait = prepared.improved_after - self.memory.counters[AT.EXPANDED]
        if wait <= 0:
            prepared.improve(self._in_units(int(self.memory.counters[AT.LOWEST])))
            if self.single:
                self.reset()
        elif wait < pops:
            pops = math.ceil(wait)
        if self._values is None and not is_interpreted():
            # Importing this loads numba. Compiled kernels are given `Values` even if no entry is a value.
            from prefplan.search.values import Values

            self._values = Values(self._layout, lambda label: self.memory.labels.key[label])
            self.keys = self.keys._replace(evaluate=self._values)
        return int(run(prepared.space, self.keys, prepared.bounds, self.memory, pops))

    def _advance(self, pops: int) -> None:
        """Run the kernel once.

        Raises:
            LimitError: the search needs more memory than there is.
        """
        end = self._run(pops)
        for label in self.memory.found[: self.memory.counters[AT.FOUND]].tolist():
            self._accept(label)
        self.memory.counters[AT.FOUND] = 0
        if end == END.EXHAUSTED:
            self._lowest = math.inf
            return
        self._lowest = self._in_units(int(self.memory.counters[AT.LOWEST]))
        if end == END.TOO_LARGE:
            raise (self._values and self._values.error) or OverflowError
        if end in (END.MORE_ROWS, END.MORE_LABELS):
            free = min(left()[1], self._free - self.work.bytes)
            self.memory = enlarged(self.memory, end, free)

    def _accept(self, label: int) -> None:
        """Keep a goal, unless its exact objectives exceed a bound: the search may have compared rounded ones."""
        objectives = self._layout.objectives(self.memory.labels.key[label].tolist())
        values = dict(zip(self.problem.objective_names, objectives, strict=True))
        if any(values[name] > bound for name, bound in self.bounds.items()):
            return
        self._found[label] = objectives
        if self.single:
            rank = self._rank(label)
            self.memory.limits[self._first] = rank if self._first else self._up_to(rank)

    def _rank(self, label: int) -> int:
        """Return a label's first objective, in units."""
        return self._in_units(int(self.memory.labels.key[label, self._first]))

    def _in_units(self, first: int) -> int:
        """Return the first objective without the low bits of a cost."""
        return first if self._first else first >> self._layout.shift

    @property
    def is_done(self) -> bool:
        """Whether all goals are found."""
        return self._lowest == math.inf or (self.single and bool(self._found) and not self._is_pending)

    @property
    def _is_pending(self) -> bool:
        """Whether the last goal may still prove to be dominated by another one of the same first objective."""
        return bool(self._found) and self._rank(next(reversed(self._found))) >= self._lowest and not self._hasty

    def _points(self, goals: list[Goal]) -> list[Goal]:
        """Return the goals that no other one dominates: only one of equal first cost can, unless values are rounded."""
        whole, points, begin = all(o.is_whole for o in self.problem.objectives), list[Goal](), 0
        for goal in sorted(goals, key=attrgetter("objectives")):
            if whole and points and points[-1].objectives[0] < goal.objectives[0]:
                begin = len(points)
            if not any(all(map(le, other.objectives, goal.objectives)) for other in points[begin:]):
                points.append(goal)
        return points

    def _goals(self, labels: Sequence[int]) -> list[Goal]:
        """Return the goals of some labels, with copies of what their plans need of the labels on their paths."""
        last = np.array(labels, dtype=np.int64)
        generations = [last]
        while len(generations[-1]):
            ahead = np.unique(self.memory.labels.parent[generations[-1]])
            generations.append(ahead[ahead != NONE])
        kept = np.unique(np.concatenate(generations))
        parents, costs = self.memory.labels.parent[kept], self.memory.labels.key[kept, 0]
        before = np.searchsorted(kept, np.where(parents == NONE, kept, parents))
        codes, space = self.memory.states.table[self.memory.labels.row[kept], CODE], self.prepared.space
        automata = codes[:, None] // space.automata.strides % space.automata.sizes
        nodes, steps = codes % space.automata.strides[0], self.memory.labels.step[kept].astype(np.int64)
        product, graph, starts = self.product, self.prepared.graph, self._starts
        taken = (nodes if space.edges is None else steps).tolist()

        @cache
        def edges(k: int) -> list[int]:
            if not graph.contracted:
                return [taken[k]]
            at = before[k]
            return edges_between(product, graph, nodes[at], nodes[k], automata[at], int(costs[k] - costs[at]))

        def plan(end: int) -> Plan:
            path = [end]
            while before[path[-1]] != path[-1]:
                path.append(int(before[path[-1]]))
            path.reverse()
            return plan_of(product, starts[steps[path[0]]], [*map(edges, path[1:])], automata[path])

        ends = np.searchsorted(kept, last).tolist()
        return [Goal(self._found[label], partial(plan, end)) for label, end in zip(labels, ends, strict=True)]

    @property
    def work(self) -> Stats:
        """The work so far."""
        c, memory = self.memory.counters, self.memory
        held = sum(map(attrgetter("nbytes"), (*memory.states, *memory.labels, *memory.queue, memory.goals)))
        return Stats(int(c[AT.ROWS]), int(c[AT.EXPANDED]), int(c[AT.LABELS]), held)
