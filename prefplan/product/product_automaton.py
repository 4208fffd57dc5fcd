"""Product automaton (Definition 7), never built: a state is one integer, and tables give its successors.

A product state p = (s, q_1, ..., q_N) has the code s + sum_i stride_i q_i. Labels on which every automaton has the same
transitions form a *class*.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import INT64_LIMIT, whole_numbers
from prefplan.logic.weighted_dfa import Reading, WeightedAutomaton
from prefplan.problem import Problem
from prefplan.product.moves import no_moves

CODE_LIMIT = 2**62

READINGS_LIMIT = 2**20
"""Most readings of one label (each task relaxed or not) that the search enumerates."""

TIE_BITS = 18
"""Actions are counted in products of fewer than 2**TIE_BITS states: no undominated path meets a state twice, so the
count cannot overflow. In larger products counting would cost speed."""


@dataclass(frozen=True)
class Start:
    """An initial product state of the search, with the violation costs paid before the first action.

    Attributes:
        code: product state after every automaton has read L(s0).
        violations: (N,) violation costs in units.
        bought: (N,) by task, the relaxations used on L(s0); None for a task that is skipped or a rule that is dropped.
    """

    code: int
    violations: tuple[int, ...]
    bought: tuple[tuple[int, ...] | None, ...]


class Product:
    """T x A_1 x ... x A_N as tables.

    Attributes:
        problem: what it is made from.
        automata: (N,) the weighted automata of the tasks, and of the rules that may be broken.
        units: the units in which costs, prices and mu are whole.
        shift: number of low bits of internal costs, which count actions to break ties; 0 if they are not counted.
        offsets: (S + 1,) int64, targets: (E,) int32, costs: (E,): the transition system; a cost is units times
            2**shift, plus 1 if actions are counted; int64, or Python's integers where one does not fit.
        classes: (S,) int32, label class of each state.
        class_sets: one label of each class.
        sizes: (N,) int64, states of each automaton.
        nodes: number of states of the transition system.
        start_node: the number of the state s0.
        moves: the model, where its states are generated.
        strides: (N,) int64.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, -1 for none.
        delta: (N, Q, C) int32, state after the free reading of a label class.
        extra_first: (N, Q, C + 1) int32: `extra_first[i, q, c] : extra_first[i, q, c + 1]` are the bought readings.
        extra_state: (X,) int32 and extra_price: (X,) units, int64 or Python's integers, of the bought readings.
    """

    def __init__(self, problem: Problem, *, counts_actions: bool = True) -> None:
        """Tabulate every automaton over the labels that occur.

        Args:
            problem: what it is made from.
            counts_actions: whether ties may be broken by counting actions.

        Raises:
            ModelError: if a product state does not fit an integer, or a label can be read in too many ways.
        """
        self.problem = problem
        system = problem.system
        self.automata: tuple[WeightedAutomaton, ...] = problem.weighted_automata
        self._tabulate()
        self.units = problem.units
        self.moves, self.start_node = no_moves(), system.start
        self.offsets = system.offsets
        self.targets = system.targets
        costs = system.costs // int(self.units.cost / system.unit)
        self.sizes = np.array([dfa.size for dfa in self.automata], dtype=np.int64)
        states = system.size * math.prod(int(q) for q in self.sizes)
        if states >= CODE_LIMIT:
            raise ModelError(
                f"{system.size} states and {len(self.automata)} automata of {', '.join(map(str, self.sizes))} states "
                "make more product states than can be numbered"
            )
        if costs.dtype == object and max(costs.tolist(), default=0) < INT64_LIMIT:
            costs = costs.astype(np.int64)
        # For each automaton and label class, in how many ways the class can be read in any state.
        each = np.diff(self.extra_first, axis=2).max(axis=1).astype(object) + 1
        readings = int(np.multiply.reduce(each, axis=0).max(initial=1))
        if readings > READINGS_LIMIT:
            raise ModelError(
                f"a label can be read in {readings:,} ways, each task relaxed or not; at most {READINGS_LIMIT:,} "
                "can be searched: let fewer tasks have relax"
            )
        self.shift = _tie_bits(costs, states) if counts_actions else 0
        self.costs = (costs << self.shift) + (self.shift > 0)
        self.nodes = system.size
        self._lay_out()

    def _lay_out(self) -> None:
        """Set the strides of codes, and the accepting and skipped states."""
        self.strides = np.cumprod(np.concatenate([[self.nodes], self.sizes[:-1]])).astype(np.int64)
        ends = [(dfa.automaton.accepting, dfa.skipped) for dfa in self.automata]
        self.ends = np.array([[-1 if q is None else q for q in pair] for pair in ends], dtype=np.int32)

    def _tabulate(self) -> None:
        system = self.problem.system
        relevant = [dfa.propositions for dfa in self.automata]
        mentioned = frozenset().union(*relevant)
        seen: dict[frozenset[str], int] = {}
        kept = [seen.setdefault(label & mentioned, len(seen)) for label in system.label_sets]
        columns: dict[tuple[tuple[Reading, ...], ...], int] = {}
        memo: dict[tuple[int, frozenset[str]], tuple[tuple[Reading, ...], ...]] = {}
        class_sets: list[frozenset[str]] = []
        class_of = []
        for label in seen:
            column: tuple[tuple[Reading, ...], ...] = ()
            for i, dfa in enumerate(self.automata):
                key = (i, label & relevant[i])
                if key not in memo:
                    memo[key] = tuple(tuple(dfa.readings(q, key[1])) for q in range(dfa.size))
                column += memo[key]
            if column not in columns:
                columns[column] = len(columns)
                class_sets.append(label)
            class_of.append(columns[column])
        self.class_sets = tuple(class_sets)
        self.classes = np.array(class_of, dtype=np.int32)[np.array(kept, dtype=np.int32)][system.labels]
        most = max(dfa.size for dfa in self.automata)
        shape = (len(self.automata), most, len(class_sets))
        self.delta = np.zeros(shape, dtype=np.int32)
        self.extra_first = np.zeros((*shape[:2], shape[2] + 1), dtype=np.int32)
        states: list[int] = []
        prices: list[int] = []
        rows = [dict(enumerate(column)) for column in columns]
        base = 0
        for i, dfa in enumerate(self.automata):
            for q in range(most):
                self.extra_first[i, q, 0] = len(states)
                for c in range(shape[2]):
                    if q < dfa.size:
                        free, *bought = rows[c][base + q]
                        self.delta[i, q, c] = free.state
                        states += [reading.state for reading in bought]
                        prices += [reading.price for reading in bought]
                    self.extra_first[i, q, c + 1] = len(states)
            base += dfa.size
        self.extra_state = np.array(states, dtype=np.int32)
        self.extra_price = whole_numbers(prices)

    @property
    def relaxed(self) -> bool:
        """Whether some label may be read in more than one way."""
        return len(self.extra_state) > 0

    @cached_property
    def rates(self) -> np.ndarray:
        """(2^N,) int64, units of mu for each unit of cost while a set of tasks is satisfied."""
        return self.problem.measure.rate_table(self.units.factor)

    @cached_property
    def starts(self) -> tuple[Start, ...]:
        """The starts of the search: one for each choice of skipped tasks and dropped rules, and each way to read L(s0).

        Raises:
            ModelError: if there are too many.
        """
        system = self.problem.system
        label = system.label(system.start)
        modes = [self._start_readings(mode, label) for mode in range(len(self.problem.modes))]
        count = sum(math.prod(map(len, readings)) for readings in modes)
        if count > READINGS_LIMIT:
            raise ModelError(
                f"the start can be read in {count:,} ways, each task skipped, relaxed or neither; "
                f"at most {READINGS_LIMIT:,} can be searched: let fewer tasks have skip or relax"
            )
        return tuple(
            Start(
                self.start_node
                + sum(int(stride) * state for stride, (state, _, _) in zip(self.strides, reading, strict=True)),
                tuple(price for _, price, _ in reading),
                tuple(bought for _, _, bought in reading),
            )
            for readings in modes
            for reading in product(*readings)
        )

    def _start_readings(self, mode: int, label: frozenset[str]) -> list[list[tuple[int, int, tuple[int, ...] | None]]]:
        """Return how each automaton may read L(s0) in one of `Problem.modes`: (state, price, relaxations) each."""
        if not self.problem.keeps_rules(mode, [label]):
            return [[] for _ in self.automata]
        readings: list[list[tuple[int, int, tuple[int, ...] | None]]] = []
        dropped = self.problem.modes[mode]
        for i, dfa in enumerate(self.automata):
            rule = i - len(self.problem.tasks)
            options: list[tuple[int, int, tuple[int, ...] | None]] = []
            if rule not in dropped:
                options += [(r.state, r.price, r.bought) for r in dfa.readings(dfa.initial[mode], label)]
            may_skip = rule in dropped or rule < 0
            if may_skip and dfa.skip is not None and (skipping := dfa.skipping(label)) is not None:
                options.append((skipping, dfa.skip, None))
            readings.append(options)
        return readings

    def decode(self, code: int) -> tuple[int, tuple[int, ...]]:
        """Return (s, (q_1, ..., q_N)) of a product state."""
        return code % self.nodes, tuple(code // int(d) % int(q) for d, q in zip(self.strides, self.sizes, strict=True))


def _tie_bits(costs: np.ndarray, states: int) -> int:
    """Return how many bits to count actions in; 0 where equal costs already do, or states or costs are too large."""
    uniform = len(costs) == 0 or (costs.min() == costs.max() > 0)
    bits = states.bit_length()
    wide = int(costs.max(initial=0)) << bits >= 2**24
    return 0 if uniform or bits > TIE_BITS or wide else bits
