"""Successors of a manipulation model's states, generated from packed integers in compiled code.

A state consists of digits: the hand's pose, each object's slot (the last value: in the hand), each mark. Where slots
are not told apart, a location is one slot, and its number is also that of the slot and of the hand's pose over it. One
canonical state stands for all that result from exchanging neutral locations and unseen objects (see
`prefplan.models.manipulation.quotient`, whose `Symmetry` does this for many states at once); where slots are told apart
no location is neutral.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.product.kernels import Integer, bare_kernel

TRANSIT, GRASP, TRANSPORT, RELEASE = range(4)
"""Kinds of actions."""

EXCHANGEABLE = 2**40
"""Stands for a neutral location while unseen objects are sorted; larger than any location."""


class Moves(NamedTuple):
    """A manipulation model of L locations, S slots, H poses of the hand, O objects and D digits, as N tasks see it.

    Attributes:
        radices: (D,) int64 and weights: (D,) int64: digit d of a state is state // weights[d] % radices[d].
        costs: (4 H H,) int64, by kind of action and pose of the hand before and after it: that of kind k from g to h is
            costs[(k H + g) H + h], negative if not measured.
        location: (S + 1,) int64, of each slot, L for the hand. first_slot: (L + 1,) int64, of each location, and S.
        over: (H,) int64, location below each pose, L for none. above: (S + 1,) int64, pose over each slot.
        far_apart: slots at least this far from the nearest object, in slots, are equally good.
        capacity: (L,) int64. closed: (L,) bool. fixed: (O,) bool.
        supports: (L, L) bool, [x, y]: y must hold an object before one is put at x. clear_of: (L, L) bool.
        mark: (L, O) int64, digit of the mark that an object gets at a location, 0 for none.
        neutral: (max(S + 1, H),) bool, by slot or pose. places: (n + 1,) int64, the neutral locations, and 0.
        told: (T,) int64, objects that some task sees, or that are fixed. unseen: (U,) int64, the others.
        unseen_marks: (M,) int64, digits of marks that no task sees.
        letters: (N + R, D, r) int64, what each value of a digit adds to the number of the letter that each automaton
            reads.
    """

    radices: np.ndarray
    weights: np.ndarray
    costs: np.ndarray
    location: np.ndarray
    first_slot: np.ndarray
    over: np.ndarray
    above: np.ndarray
    far_apart: int
    capacity: np.ndarray
    closed: np.ndarray
    fixed: np.ndarray
    supports: np.ndarray
    clear_of: np.ndarray
    mark: np.ndarray
    neutral: np.ndarray
    places: np.ndarray
    told: np.ndarray
    unseen: np.ndarray
    unseen_marks: np.ndarray
    letters: np.ndarray


def no_moves() -> Moves:
    """Return the empty arrays that are passed where states are listed."""
    numbers, flags = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_)
    table, grid = np.zeros((0, 0), dtype=np.bool_), np.zeros((0, 0), dtype=np.int64)
    return Moves(
        radices=numbers,
        weights=numbers,
        costs=numbers,
        location=numbers,
        first_slot=numbers,
        over=numbers,
        above=numbers,
        far_apart=0,
        capacity=numbers,
        closed=flags,
        fixed=flags,
        supports=table,
        clear_of=table,
        mark=grid,
        neutral=flags,
        places=numbers,
        told=numbers,
        unseen=numbers,
        unseen_marks=numbers,
        letters=np.zeros((0, 0, 0), dtype=np.int64),
    )


class Digits(NamedTuple):
    """Scratch for generating successors.

    Attributes:
        before: (D,) int64, digits of a state. after: (D,) int64, of its successor. seen: (D,) int64, of the state whose
            bounds are looked up. counts: (L,) int64, objects at each location.
        unmeasured: (1,) int64, output: a state with an action whose cost was not measured, -1 if none was met.
    """

    before: np.ndarray
    after: np.ndarray
    seen: np.ndarray
    counts: np.ndarray
    unmeasured: np.ndarray


def scratch_digits(moves: Moves) -> Digits:
    """Return scratch for the successors of a model's states."""
    d = len(moves.radices)
    before, after, seen = np.zeros((3, d), dtype=np.int64)
    return Digits(before, after, seen, np.zeros(len(moves.capacity), dtype=np.int64), np.full(1, -1, dtype=np.int64))


@bare_kernel
def unpack(moves: Moves, state: Integer, digits: np.ndarray) -> None:
    """Write the digits of a state."""
    for d in range(moves.radices.shape[0]):
        digits[d] = state % moves.radices[d]
        state //= moves.radices[d]


@bare_kernel
def pack(moves: Moves, digits: np.ndarray) -> Integer:
    """Return the state of some digits."""
    state = np.int64(0)
    for d in range(digits.shape[0]):
        state += moves.weights[d] * digits[d]
    return state


@bare_kernel
def standardize(moves: Moves, digits: np.ndarray) -> None:
    """Replace a state's digits by those of its canonical state."""
    hand = digits[0]
    moved, rank = hand, 0
    over_empty = moves.neutral[hand]
    for o in moves.told:
        location = digits[1 + o]
        if moves.neutral[location]:
            digits[1 + o] = moves.places[rank]
            if location == hand:
                moved, over_empty = moves.places[rank], False
            rank += 1
    under = False
    for k in range(moves.unseen.shape[0]):
        location = digits[1 + moves.unseen[k]]
        if moves.neutral[location]:
            under |= location == hand
            location = np.int64(EXCHANGEABLE)
        at = k
        while at > 0 and digits[1 + moves.unseen[at - 1]] > location:
            digits[1 + moves.unseen[at]] = digits[1 + moves.unseen[at - 1]]
            at -= 1
        digits[1 + moves.unseen[at]] = location
    if under:
        moved, over_empty = moves.places[rank], False
    for o in moves.unseen:
        if digits[1 + o] == EXCHANGEABLE:
            digits[1 + o] = moves.places[rank]
            rank += 1
    if over_empty:
        moved = moves.places[rank]
    digits[0] = moved
    for d in moves.unseen_marks:
        digits[d] = 0


@bare_kernel
def accepts(moves: Moves, counts: np.ndarray, location: Integer) -> bool:
    """Return whether an object can be put at a location."""
    if moves.closed[location] or counts[location] >= moves.capacity[location]:
        return False
    for other in range(counts.shape[0]):
        if moves.supports[location, other] and counts[other] == 0:
            return False
        if moves.clear_of[location, other] and counts[other] > 0:
            return False
    return True


@bare_kernel
def is_clear(moves: Moves, counts: np.ndarray, location: Integer) -> bool:
    """Return whether an object can be grasped at a location."""
    for other in range(counts.shape[0]):
        if counts[other] > 0:
            if moves.supports[other, location]:
                return False
            if moves.closed[location] and moves.clear_of[location, other]:
                return False
    return True


@bare_kernel
def count_objects(moves: Moves, digits: np.ndarray, counts: np.ndarray) -> Integer:
    """Write how many objects each location holds, and return the one in the hand, or -1."""
    held = -1
    for x in range(counts.shape[0]):
        counts[x] = 0
    for o in range(moves.fixed.shape[0]):
        location = moves.location[digits[1 + o]]
        if location < counts.shape[0]:
            counts[location] += 1
        else:
            held = o
    return held


@bare_kernel
def free_slot(moves: Moves, digits: np.ndarray, location: Integer) -> Integer:
    """Return the slot of a location into which an object is put, as `prefplan.models.manipulation.slots` says."""
    best, end = moves.first_slot[location], moves.first_slot[location + 1]
    if end - best == 1:
        return best
    first, farthest = best, np.int64(0)
    for slot in range(first, end):
        nearest = np.int64(moves.far_apart)
        for o in range(moves.fixed.shape[0]):
            if first <= digits[1 + o] < end:
                nearest = min(nearest, abs(slot - digits[1 + o]))
        if nearest > farthest:
            best, farthest = slot, nearest
    return best
