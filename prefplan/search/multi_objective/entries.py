"""The entries of labels as the kernel works on them (`ltmoa_star`); `entry_map` says which there are."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from prefplan.models.kernels import Integer, bare_kernel
from prefplan.search.labels import COLUMNS, END

# Columns of a product state's row after those of `labels`: where its truncated vectors begin, how many there are, how
# many there is memory for, and the bounds of how the objectives grow.
FIRST, SIZE, CAPACITY, BOUND = range(COLUMNS, COLUMNS + 4)

OPERATIONS = ("+", "-", "*", "/", "min", "max", "call")
"""What the instructions of a `Program` do."""

ADD, SUBTRACT, MULTIPLY, DIVIDE, MINIMUM, MAXIMUM, CALL = range(7)

LARGEST_WHOLE = 2.0**53
"""Larger whole numbers are not exact in floating point."""

HUGE = 1e200
"""A value beyond this, or below 0, ends the search."""


class Entries(NamedTuple):
    """The K entries of a label: [costs, mu of each preference, parts of mu, costs of satisfied tasks, violation costs].

    Attributes:
        edge_costs: (D, E) int64, costs of each edge, or of each price where states are generated;
            (1, 0) where successors come with their only cost.
        sums: (S, 2) int64, the place of each entry that grows at a rate, and the cost that it grows with.
        rate: (S, 2^N) int64, units of mu for each unit of it. violation: (S, P) int64, for each unit of violation cost.
        late: (L, 4) int64, sum, task, slope and offset: tardiness is max(0, slope * cost - offset).
        maxima: (M, 2) int64, place and cost of each maximum. maximum: (M, 2^N) int64, by satisfied set: the maximum is
            at least this times the cost.
        frozen: (C, 2) int64, the cost and the task of each entry for the cost of a satisfied task.
        paid: (V,) int64, the task of each entry for a violation cost.
        cost_limit: (D,) int64, from this cost on a product with it might not fit 64 bits.
        order: (O,) int64, the objectives, which are the first entries, in the order of comparison.
        compared: (W,) int64, the entries of the truncated vectors, by which labels of a product state are compared;
            ~e for less of entry e.
    """

    edge_costs: np.ndarray
    sums: np.ndarray
    rate: np.ndarray
    violation: np.ndarray
    late: np.ndarray
    maxima: np.ndarray
    maximum: np.ndarray
    frozen: np.ndarray
    paid: np.ndarray
    cost_limit: np.ndarray
    order: np.ndarray
    compared: np.ndarray


class Program(NamedTuple):
    """How entries are computed from others.

    Attributes:
        computed: (X, 3) int64, the place of each such entry, the end of its instructions, and how far it may fall by
            rounding, 0 if it must be whole.
        code: (J, 4) int64, instructions: operation, registers of its operands, and of its result.
        registers: (R,) float64, the entries of a label, with what is spent as the cost of tasks that are not satisfied;
            then constants and results. bits: the same memory as int64.
        function: (number) -> value of a Python function for the label in the registers, or NaN.
    """

    computed: np.ndarray
    code: np.ndarray
    registers: np.ndarray
    bits: np.ndarray
    function: Any


class KeyedLabels(NamedTuple):
    """Labels.

    Attributes:
        row: (L,) int32, of the product state. parent: (L,) int32, or -1.
        step: (L,) int32, the last edge, or the index of its costs; of a label without parent, its start.
        key: (L, K) int64, entries; costs of tasks that are not satisfied are entered as 0.
    """

    row: np.ndarray
    parent: np.ndarray
    step: np.ndarray
    key: np.ndarray


class Vector(NamedTuple):
    """Scratch for one label.

    Attributes:
        key: (K,) int64, its entries.
        bound: (O,) int64, lower bounds of the objectives at the end, in the order of comparison.
        truncated: (W,) int64, the entries by which labels of a product state are compared.
    """

    key: np.ndarray
    bound: np.ndarray
    truncated: np.ndarray


@bare_kernel
def follow(
    shift: Integer,
    entries: Entries,
    satisfied: Integer,
    step: Integer,
    violation: np.ndarray,
    pays: bool,
    key: np.ndarray,
) -> bool:
    """Replace a label's entries by those of a successor, except those that `freeze` and `compute` enter.

    Args:
        shift: number of low bits of the first cost.
        entries: the layout of a key.
        satisfied: the tasks that were satisfied before, as bits.
        step: cost of the step, or the number of its edge or action.
        violation: (P,) int64, violation costs that it pays.
        pays: whether it may pay any.
        key: (K,) entries of the parent, overwritten.

    Returns:
        whether they fit 64 bits for sure.
    """
    for s in range(entries.sums.shape[0]):
        key[entries.sums[s, 0]] += _growth(shift, entries, s, satisfied, key, step)
    for d in range(entries.cost_limit.shape[0]):
        key[d] += _step(entries, d, step)
        if spent(shift, key, d) >= entries.cost_limit[d]:
            return False
    for m in range(entries.maxima.shape[0]):
        place = entries.maxima[m, 0]
        key[place] = max(key[place], entries.maximum[m, satisfied] * spent(shift, key, entries.maxima[m, 1]))
    if pays:
        for s in range(entries.sums.shape[0]):
            for i in range(entries.violation.shape[1]):
                key[entries.sums[s, 0]] += entries.violation[s, i] * violation[i]
        first = key.shape[0] - entries.paid.shape[0]
        for v in range(entries.paid.shape[0]):
            key[first + v] += violation[entries.paid[v]]
    return True


@bare_kernel
def _growth(
    shift: Integer, entries: Entries, s: Integer, satisfied: Integer, key: np.ndarray, edge: Integer
) -> Integer:
    """Return what a step adds to a sum, given the parent's entries."""
    d = entries.sums[s, 1]
    before = spent(shift, key, d)
    after = key[d] + _step(entries, d, edge)
    if d == 0:
        after >>= shift
    added = entries.rate[s, satisfied] * (after - before)
    for t in range(entries.late.shape[0]):
        if entries.late[t, 0] == s and not satisfied >> entries.late[t, 1] & 1:
            slope, offset = entries.late[t, 2], entries.late[t, 3]
            added += max(0, slope * after - offset) - max(0, slope * before - offset)
    return added


@bare_kernel
def _step(entries: Entries, d: Integer, edge: Integer) -> Integer:
    """Return one of the costs of a step."""
    return entries.edge_costs[d, edge] if entries.edge_costs.shape[1] else edge


@bare_kernel
def spent(shift: Integer, key: np.ndarray, d: Integer) -> Integer:
    """Return one of the total costs, in units."""
    return key[d] >> shift if d == 0 else key[d]


@bare_kernel
def freeze(shift: Integer, entries: Entries, before: Integer, after: Integer, key: np.ndarray) -> None:
    """Enter the costs of the tasks that become satisfied."""
    first = key.shape[0] - entries.paid.shape[0] - entries.frozen.shape[0]
    for c in range(entries.frozen.shape[0]):
        i = entries.frozen[c, 1]
        if after >> i & 1 and not before >> i & 1:
            key[first + c] = spent(shift, key, entries.frozen[c, 0])


@bare_kernel
def write_vectors(shift: Integer, entries: Entries, known: np.ndarray, scratch: Vector) -> None:
    """Write what a label is pruned by: bounds of its objectives, and its truncated vector; `known` is its state's row.

    Both are written from the entries in `scratch.key`.
    """
    key = scratch.key
    for o in range(entries.order.shape[0]):
        e = entries.order[o]
        scratch.bound[o] = key[e] + known[BOUND + e]
        if e == 0:
            # Other objectives come before the number of actions, which the low bits count.
            scratch.bound[o] = scratch.bound[o] >> shift << shift
    for t in range(entries.compared.shape[0]):
        e = entries.compared[t]
        scratch.truncated[t] = key[e] if e >= 0 else -spent(shift, key, ~e)


@bare_kernel
def compute(shift: Integer, entries: Entries, program: Program, satisfied: Integer, key: np.ndarray) -> Integer:
    """Enter the computed entries; return ENTERED, or why that is not possible (`END`).

    Before, they are those of the parent; one that falls by rounding remains so.
    """
    registers = program.registers
    for e in range(key.shape[0]):
        registers[e] = spent(shift, key, e)
    first = key.shape[0] - entries.paid.shape[0] - entries.frozen.shape[0]
    for c in range(entries.frozen.shape[0]):
        if not satisfied >> entries.frozen[c, 1] & 1:
            registers[first + c] = registers[entries.frozen[c, 0]]
    for e in range(first, key.shape[0]):
        if registers[e] > LARGEST_WHOLE:
            return END.TOO_LARGE
    begin = 0
    for x in range(program.computed.shape[0]):
        place, end, slack = program.computed[x, 0], program.computed[x, 1], program.computed[x, 2]
        if not _evaluate(program, begin, end, slack == 0):
            return END.TOO_LARGE
        result = program.code[end - 1, 3]
        if not 0 <= registers[result] <= HUGE:
            return END.TOO_LARGE
        value = program.bits[result] >> 3 if slack else np.int64(registers[result])
        if value + slack < key[place]:
            return END.FALLS
        key[place] = max(key[place], value)
        begin = end
    return END.ENTERED


@bare_kernel
def _evaluate(program: Program, begin: Integer, end: Integer, whole: bool) -> bool:
    """Follow some instructions; return False if some number must be whole, but is too large for that to be sure."""
    registers = program.registers
    for at in range(begin, end):
        operation, one = program.code[at, 0], program.code[at, 1]
        a, b = registers[one], registers[program.code[at, 2]]
        if operation == ADD:
            value = a + b
        elif operation == SUBTRACT:
            value = a - b
        elif operation == MULTIPLY:
            value = a * b
        elif operation == DIVIDE:
            value = a / b if b != 0 else np.nan
        elif operation == MINIMUM:
            value = min(a, b)
        elif operation == MAXIMUM:
            value = max(a, b)
        else:
            value = program.function(one)
        if whole and max(abs(a), abs(b), abs(value)) > LARGEST_WHOLE:
            return False
        registers[program.code[at, 3]] = value
    return True
