"""Product automaton (Definition 7), never built: its starts, and tables of successors; a state is one integer.

A product state p = (s, q_1, ..., q_N, r_1, ..., r_R), of N tasks and R rules, has the code s + sum_i stride_i q_i + ...
Labels on which every automaton has the same transitions form a *class*.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate, product

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import INT64_LIMIT, exact, whole_numbers
from prefplan.limits import check_limits
from prefplan.logic.weighted_dfa import Reading, WeightedAutomaton
from prefplan.models.kernels import INTERPRETED_STATES, compile_kernels
from prefplan.models.system import System
from prefplan.problem import Problem
from prefplan.product.space import BARRED, Automata, Generated, Graph, strides_of

TIE_BITS = 18
"""Actions are counted, to break ties of cost, in products of fewer than 2**TIE_BITS states. No undominated path meets
a state twice, so the count cannot overflow. In larger products counting would cost speed."""

NO_STEP = "the search made a step that the model does not have"

READINGS_LIMIT = 2**20
"""Most readings of one label (each task relaxed or not) that the search enumerates."""


@dataclass(frozen=True)
class Start:
    """An initial state of the automata, with the costs and violation costs before the first action.

    Attributes:
        automata: (N + R,) states of the automata of N tasks and R rules, after the labels of the past and L(s0).
        spent: the first cost of the past, in units.
        finished: (N,) by task, the part of `spent` until the task was satisfied; None if it is not.
        violations: (P,) violation costs in units, of tasks and of rules that may be broken.
        relaxed: (N,) by task, pairs (label, relaxation used to read it), by number; None for a task that is skipped.
    """

    automata: tuple[int, ...]
    spent: int
    finished: tuple[int | None, ...]
    violations: tuple[int, ...]
    relaxed: tuple[tuple[tuple[int, int], ...] | None, ...]

    def task_costs(self, cost: int) -> list[int]:
        """Return (N,) the tasks' costs in the past, in units; a past has the first cost only, so that others are 0."""
        return [0 if cost else self.spent if c is None else c for c in self.finished]


@dataclass(frozen=True)
class History:
    """One way in which an automaton may have read the past and L(s0); label `finished` satisfied its task."""

    state: int = 0
    finished: int | None = None
    price: int = 0
    relaxed: tuple[tuple[int, int], ...] | None = ()


class Product:
    """T x A_1 x ... x A_N, with R rules, as tables.

    Attributes:
        problem: the problem that the product is made from.
        listed: the transition system T of `problem`, with all its states.
        system: the transition system of the plans: T, or the system that T was reduced from.
        automata: (N,) the weighted automata of the tasks.
        followers: (N + R,) `automata`, then those of the rules, first of the P - N rules that may be broken.
        graph: T as a graph; a cost is units times 2**shift, plus 1 if actions are counted to break ties; int64, or
            Python's integers where one does not fit.
        more_costs: the further costs, (E,) each, in units.
        class_sets: one label of each class.
        sizes: (N,) int64, states of each automaton.
        nodes: number of states of the transition system.
        generated: the model for the kernels, where its states are generated; else None.
        tables: the automata of all followers.
    """

    system: System
    generated: Generated | None = None

    def __init__(self, problem: Problem) -> None:
        """Tabulate every automaton over the labels that occur.

        Raises:
            ModelError: if a product state does not fit an integer, or a label can be read in too many ways.
        """
        self.problem = problem
        self.system = self.listed = listed = problem.system.listed
        self.automata, self.followers = problem.weighted_automata, problem.followers
        self.nodes = len(listed.labels)
        classes = self._tabulate()
        # A projection has one cost only.
        tables = zip(listed.costs, problem.cost_units, strict=False)
        costs, *self.more_costs = (table.counts(unit) for table, unit in tables)
        sizes = self.tables.sizes.tolist()
        states = self.nodes * math.prod(sizes)
        if states >= INT64_LIMIT:
            raise ModelError(
                f"{self.nodes} states and {len(sizes)} automata of {', '.join(map(str, sizes))} states "
                "make more product states than can be numbered"
            )
        # For each automaton and label class, the largest number of ways to read the class in one state.
        each = np.diff(self.tables.first_relaxed, axis=2).max(axis=1).astype(object) + 1
        readings = int(np.multiply.reduce(each, axis=0).max(initial=1))
        if readings > READINGS_LIMIT:
            raise ModelError(
                f"a label can be read in {readings:,} ways, each task relaxed or not; at most {READINGS_LIMIT:,} "
                "can be searched: let fewer tasks have relax"
            )
        # Where a detour may be worth its cost, paths have any number of actions.
        live = self.nodes * math.prod(dfa.live for dfa in self.followers)
        shift = 0 if problem.is_general else _tie_bits(costs, live)
        edges = listed.offsets, listed.targets, (costs << shift) + 1 if shift else costs
        self.graph = Graph(*edges, classes, np.arange(self.nodes), listed.start, False, shift)
        if states > INTERPRETED_STATES:
            compile_kernels()

    def _tabulate(self) -> np.ndarray:
        """Fill the tables, set one label of each class, and return the class of each state."""
        relevant = [dfa.propositions for dfa in self.followers]

        @cache
        def read(i: int, label: frozenset[str]) -> tuple[tuple[Reading, ...], ...]:
            check_limits()
            dfa = self.followers[i]
            return tuple(tuple(dfa.readings(q, label)) for q in range(dfa.size))

        mentioned = frozenset[str]().union(*relevant)
        letters: dict[frozenset[str], int] = {}
        kept = [letters.setdefault(label & mentioned, len(letters)) for label in self.listed.label_sets]
        columns: dict[tuple[tuple[tuple[Reading, ...], ...], ...], int] = {}
        class_of, class_sets = list[int](), list[frozenset[str]]()
        for label in letters:
            check_limits()
            column = tuple(read(i, label & names) for i, names in enumerate(relevant))
            if column not in columns:
                class_sets.append(label)
            class_of.append(columns.setdefault(column, len(columns)))
        self.class_sets = tuple(class_sets)
        self._enter(list(zip(*columns, strict=True)))
        classes: np.ndarray = np.array(class_of, dtype=np.int32)[np.array(kept, dtype=np.int32)][self.listed.labels]
        return classes

    def _enter(self, readings: Sequence[Sequence[tuple[tuple[Reading, ...], ...]]]) -> None:
        """Fill the tables, given each automaton's readings by label class and state."""
        sizes = np.array([dfa.size for dfa in self.followers], dtype=np.int64)
        self.sizes, most, labels = sizes[: len(self.automata)], int(sizes.max()), max(map(len, readings))
        delta = np.zeros((len(readings), most, labels), dtype=np.int32)
        first_relaxed = np.zeros((len(readings), most, labels + 1), dtype=np.int32)
        extra, tolls = list[Reading](), dict[tuple[int, int, int], int]()
        for i, column in enumerate(readings):
            for q in range(most):
                check_limits()
                first_relaxed[i, q, 0] = len(extra)
                for c in range(labels):
                    if c < len(column) and q < len(column[c]):
                        free, *relaxed = column[c][q] or [Reading(BARRED)]
                        delta[i, q, c] = free.state
                        extra += relaxed
                        if free.price:
                            tolls[i, q, c] = free.price
                    first_relaxed[i, q, c + 1] = len(extra)
        prices = np.zeros((len(self.problem.priced) if extra or tolls else 0, most, labels), dtype=object)
        for place, price in tolls.items():
            prices[place] = price
        read = whole_numbers([number for reading in extra for number in (reading.state, reading.price)])
        ends = [(dfa.automaton.accepting, dfa.skipped) for dfa in self.automata]
        self.tables = Automata(
            sizes,
            strides_of(self.nodes, sizes),
            np.array([[-1 if q is None else q for q in pair] for pair in ends], dtype=np.int32),
            delta,
            whole_numbers(prices.ravel().tolist()).reshape(prices.shape),
            read.reshape(-1, 2),
            first_relaxed,
        )

    @cached_property
    def starts(self) -> tuple[Start, ...]:
        """The starts: one for each choice of skipped tasks and each way to read the past and L(s0).

        Raises:
            ModelError: there are too many.
        """
        problem = self.problem
        labels = [*problem.past.labels, problem.system.label(problem.system.start)]
        read = [histories(dfa, labels, any_price=problem.is_general) for dfa in self.followers]
        count = math.prod(map(len, read))
        if count > READINGS_LIMIT:
            raise ModelError(
                f"the start can be read in {count:,} ways, each task skipped, relaxed or neither; "
                f"at most {READINGS_LIMIT:,} can be searched: let fewer tasks have skip or relax"
            )
        unit, tasks = problem.cost_units[0], len(self.automata)
        spent = list(accumulate((int(exact(cost) / unit) for cost in problem.past.costs), initial=0))
        return tuple(
            Start(
                tuple(history.state for history in each),
                spent[-1],
                tuple(None if history.finished is None else spent[history.finished] for history in each[:tasks]),
                tuple(history.price for history in each[: len(problem.priced)]),
                tuple(history.relaxed for history in each[:tasks]),
            )
            for each in product(*read)
        )

    def actions(self, steps: np.ndarray) -> Sequence[str]:
        """Return the actions in `system` of a path of (K,) edges from the start; AssertionError if they are no path."""
        listed = self.listed
        before = np.array([listed.start, *listed.targets[steps[:-1]]])[: len(steps)]
        assert ((listed.offsets[before] <= steps) & (steps < listed.offsets[before + 1])).all(), NO_STEP
        return [listed.action_names[action] for action in listed.actions[steps].tolist()]


def _tie_bits(costs: np.ndarray, states: int) -> int:
    """Return the number of bits that count actions; 0 if all edges cost the same, or states or costs are too large."""
    uniform = len(costs) == 0 or (costs.min() == costs.max() > 0)
    bits = states.bit_length()
    wide = int(costs.max(initial=0)) << bits >= 2**24
    return 0 if uniform or bits > TIE_BITS or wide else bits


def histories(dfa: WeightedAutomaton, labels: Sequence[frozenset[str]], *, any_price: bool = False) -> list[History]:
    """Return how an automaton may have read some labels: the cheapest way to each result, or one of each price.

    A result is a state and `finished`. There is no way if the labels break a rule that no plan may break.
    """
    # A rule that every trace breaks has an accepting initial state: its price is paid at once, not by a step.
    price = dfa.price if dfa.automaton.accepting == 0 else 0
    found = [] if price is None else [History(price=price)]
    for k, label in enumerate(labels):
        best: dict[tuple[int, int | None, int], History] = {}
        for before in found:
            for reading in dfa.readings(before.state, label):
                ends = before.finished is None and reading.state == dfa.automaton.accepting
                finished, price = k if ends else before.finished, before.price + reading.price
                relaxed = (*(before.relaxed or ()), *((k, relaxation) for relaxation in reading.relaxations))
                key = (reading.state, finished, price if any_price else 0)
                if key not in best or price < best[key].price:
                    best[key] = History(reading.state, finished, price, relaxed)
        found = list(best.values())
    if dfa.skip is not None and dfa.skipped is not None:
        found.append(History(dfa.skipped, None, dfa.skip, None))
    return found
