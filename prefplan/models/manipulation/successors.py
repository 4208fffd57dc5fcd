"""Successors of a manipulation model's states, from packed integers in compiled code.

A state consists of digits: the hand's pose, each object's slot (the last value: in the hand), each mark, and where the
held object was grasped. Where slots are not told apart, a location is one slot, and its number is also that of the slot
and of the hand's pose over it. One canonical state stands for all that result from exchanging neutral locations and
alike objects of one class each (see `prefplan.models.manipulation.symmetry`); where slots are told apart no location is
neutral.

The operators in `prefplan.models.manipulation.operators` define the same successors, one state at a time.
"""

from typing import NamedTuple

import numpy as np

from prefplan.models.kernels import Integer, inner_kernel, kernel
from prefplan.models.manipulation.slots import free_slot as any_free_slot

TRANSIT, GRASP, TRANSPORT, RELEASE = range(4)
"""Kinds of actions."""

EXCHANGEABLE = 2**40
"""This plus its class stands for a neutral location while alike objects are sorted; larger than any location."""

free_slot = inner_kernel(any_free_slot)


class Moves(NamedTuple):
    """A manipulation model of L locations, S slots, H poses of the hand, O objects and D digits.

    Attributes:
        radices: (D,) int64, number of values of each digit of a state.
        location: (S + 1,) int64, location of each slot, L for the hand.
        first_slot: (L + 1,) int64, first slot of each location, and S.
        over: (H,) int64, location below each pose, L for none.
        above: (S + 1,) int64, pose over each slot.
        capacity: (L,) int64, capacity of each location, 0 where nothing can be put.
        movable: (O,) bool, whether each object can be grasped.
        needs: (L, L) int8, [x, y]: 1 if y must hold an object, -1 if it must hold none, before one is put at x.
        blocks: (L, L) bool, [x, y]: an object at x prevents grasping at y.
        mark: (L, O) int64, digit of the mark that an object gets at a location, 0 for none.
        origin: (L, O) int64, value of the last digit while the hand holds an object that it grasped at a location.
        neutral: (max(S + 1, H),) int64, by slot or pose, the class of a neutral location, from 1 to C, 0 for others.
        places: (C + 1, n + 1) int64, the neutral locations of each class, then zeros.
        ranks: (C + 1,) int64, scratch: how many neutral locations of each class are taken.
        alike: (N,) int64, the objects by class, within which they may be exchanged; first those that are alone, if
            there are neutral locations.
        alike_class: (N,) int64, the class of each of these, from 0.
        excluded: (A + 1,) int32, the first of the B exclusions of each action, and B.
        first_condition: (B + 1,) int32, the first of the K conditions of each exclusion, and K.
        conditions: (K, 3) int64, each (d, low, high): digit d is at least low and below high.
    """

    radices: np.ndarray
    location: np.ndarray
    first_slot: np.ndarray
    over: np.ndarray
    above: np.ndarray
    capacity: np.ndarray
    movable: np.ndarray
    needs: np.ndarray
    blocks: np.ndarray
    mark: np.ndarray
    origin: np.ndarray
    neutral: np.ndarray
    places: np.ndarray
    ranks: np.ndarray
    alike: np.ndarray
    alike_class: np.ndarray
    excluded: np.ndarray
    first_condition: np.ndarray
    conditions: np.ndarray


class Steps(NamedTuple):
    """The actions of one state, at most M, and scratch.

    Attributes:
        digits: (M, D) int64, of the canonical state that each action leads to.
        actions: (M,) int64, numbers of the actions: transits, grasps, transports and releases, in order.
        prices: (M,) int64, (kind H + before) H + after of each action, with the hand's poses before and after it.
        before: (D,) int64, digits of the state.
        counts: (L,) int64, number of objects at each location.
    """

    digits: np.ndarray
    actions: np.ndarray
    prices: np.ndarray
    before: np.ndarray
    counts: np.ndarray


def steps_of(moves: Moves) -> Steps:
    """Return buffers for the actions of any state of a model."""
    locations, objects, digits = len(moves.capacity), len(moves.movable), len(moves.radices)
    most = max(locations + objects, locations + 1)
    actions, prices = np.zeros((2, most), dtype=np.int64)
    before, counts = np.zeros(digits, dtype=np.int64), np.zeros(locations, dtype=np.int64)
    return Steps(np.zeros((most, digits), dtype=np.int64), actions, prices, before, counts)


@inner_kernel
def unpack(radices: np.ndarray, state: Integer, digits: np.ndarray) -> None:
    """Write the digits of a state."""
    for d in range(radices.shape[0]):
        digits[d] = state % radices[d]
        state //= radices[d]


@inner_kernel
def pack(moves: Moves, digits: np.ndarray) -> Integer:
    """Return the state of some digits."""
    state = np.int64(0)
    for d in range(digits.shape[0] - 1, -1, -1):
        state = state * moves.radices[d] + digits[d]
    return state


@inner_kernel
def standardize(moves: Moves, digits: np.ndarray) -> None:
    """Replace a state's digits by those of its canonical state.

    Each class of alike objects is sorted by location. Objects at neutral locations are moved to the first ones of the
    same class of locations, in order; a hand over an empty neutral location is moved over the next one.
    """
    hand = digits[0]
    moved, over = hand, moves.neutral[hand]
    moves.ranks[:] = 0
    first, count = np.int64(0), moves.alike.shape[0]
    while first < count:
        end = first + 1
        while end < count and moves.alike_class[end] == moves.alike_class[first]:
            end += 1
        is_under = _sort_alike(moves, digits, first, end, hand)
        for o in moves.alike[first:end]:
            if digits[1 + o] >= EXCHANGEABLE:
                kind = digits[1 + o] - EXCHANGEABLE
                digits[1 + o] = _next_place(moves, kind)
                if is_under and kind == over:
                    moved, over, is_under = digits[1 + o], 0, False
        first = end
    if over:
        moved = _next_place(moves, over)
    digits[0] = moved


@inner_kernel
def _next_place(moves: Moves, kind: Integer) -> Integer:
    """Take the next neutral location of a class and return it."""
    moves.ranks[kind] += 1
    return moves.places[kind, moves.ranks[kind] - 1]


@inner_kernel
def _sort_alike(moves: Moves, digits: np.ndarray, first: Integer, end: Integer, hand: Integer) -> bool:
    """Sort alike objects of one class by location, and return whether the hand is over one at a neutral location.

    Neutral locations are replaced by `EXCHANGEABLE` and their class.
    """
    is_under = False
    for k in range(first, end):
        location = digits[1 + moves.alike[k]]
        if moves.neutral[location]:
            is_under |= location == hand
            location = EXCHANGEABLE + moves.neutral[location]
        at = k
        while at > first and digits[1 + moves.alike[at - 1]] > location:
            digits[1 + moves.alike[at]] = digits[1 + moves.alike[at - 1]]
            at -= 1
        digits[1 + moves.alike[at]] = location
    return is_under


@inner_kernel
def _accepts(moves: Moves, counts: np.ndarray, location: Integer) -> bool:
    """Return whether an object can be put at a location."""
    if counts[location] >= moves.capacity[location]:
        return False
    for other in range(counts.shape[0]):
        need = moves.needs[location, other]
        if (need > 0 and counts[other] == 0) or (need < 0 and counts[other] > 0):
            return False
    return True


@inner_kernel
def _is_clear(moves: Moves, counts: np.ndarray, location: Integer) -> bool:
    """Return whether nothing prevents grasping an object at a location."""
    for other in range(counts.shape[0]):
        if counts[other] > 0 and moves.blocks[other, location]:
            return False
    return True


@inner_kernel
def _count_objects(moves: Moves, digits: np.ndarray, counts: np.ndarray) -> Integer:
    """Write how many objects each location holds, and return the one in the hand, or -1."""
    held = -1
    counts[:] = 0
    for o in range(moves.movable.shape[0]):
        location = moves.location[digits[1 + o]]
        if location < counts.shape[0]:
            counts[location] += 1
        else:
            held = o
    return held


@inner_kernel
def _is_excluded(moves: Moves, digits: np.ndarray, action: Integer) -> bool:
    """Return whether an action does not exist in a state."""
    for b in range(moves.excluded[action], moves.excluded[action + 1]):
        holds = True
        for c in range(moves.first_condition[b], moves.first_condition[b + 1]):
            value = digits[moves.conditions[c, 0]]
            if value < moves.conditions[c, 1] or value >= moves.conditions[c, 2]:
                holds = False
                break
        if holds:
            return True
    return False


@inner_kernel
def write_steps(moves: Moves, state: Integer, steps: Steps) -> Integer:
    """Write the actions of a state, in the order of the model, and return how many there are.

    Of the actions that move the hand over empty neutral locations of one class, only the first is written.
    """
    before, counts = steps.before, steps.counts
    unpack(moves.radices, state, before)
    held = _count_objects(moves, before, counts)
    here, locations, objects = moves.over[before[0]], counts.shape[0], moves.movable.shape[0]
    loaded = locations + objects
    count: Integer = np.int64(0)
    moves.ranks[:] = 0
    for x in range(locations):
        action = x if held < 0 else loaded + held * locations + x
        if x == here or (held >= 0 and not _accepts(moves, counts, x)) or _is_excluded(moves, before, action):
            continue
        if moves.neutral[x] and counts[x] == 0:
            if moves.ranks[moves.neutral[x]]:
                continue
            moves.ranks[moves.neutral[x]] = 1
        after = steps.digits[count]
        _copy(before, after)
        after[0] = x if held < 0 else moves.above[_slot_at(moves, before, x)]
        steps.actions[count] = action
        count += 1
    for k in range(count):
        _end_step(moves, steps, np.int64(k), np.int64(TRANSIT if held < 0 else TRANSPORT))
    if here == locations:
        return count
    if held >= 0:
        action = loaded + (objects + held) * locations + here
        if _accepts(moves, counts, here) and not _is_excluded(moves, before, action):
            slot = _slot_at(moves, before, here)
            after = steps.digits[count]
            _copy(before, after)
            after[0], after[1 + held], after[-1] = moves.above[slot], slot, 0
            if moves.mark[here, held]:
                after[moves.mark[here, held]] = 1
            steps.actions[count] = action
            count = _end_step(moves, steps, count, np.int64(RELEASE))
    elif _is_clear(moves, counts, here):
        for o in range(objects):
            slot = before[1 + o]
            if moves.location[slot] == here and moves.movable[o] and not _is_excluded(moves, before, locations + o):
                after = steps.digits[count]
                _copy(before, after)
                after[0], after[1 + o] = moves.above[slot], moves.location.shape[0] - 1
                after[-1] = moves.origin[here, o]
                steps.actions[count] = locations + o
                count = _end_step(moves, steps, count, np.int64(GRASP))
    return count


@inner_kernel
def _slot_at(moves: Moves, digits: np.ndarray, location: Integer) -> Integer:
    """Return the slot of a location into which an object is put."""
    slots, bounds = digits[1 : 1 + moves.movable.shape[0]], moves.first_slot[location : location + 2]
    return free_slot(slots, bounds[0], bounds[1])


@inner_kernel
def _copy(source: np.ndarray, target: np.ndarray) -> None:
    for d in range(source.shape[0]):
        target[d] = source[d]


@inner_kernel
def _end_step(moves: Moves, steps: Steps, k: Integer, kind: Integer) -> Integer:
    """Write an action's price, replace its state by the canonical one, and return k + 1."""
    hands = moves.over.shape[0]
    steps.prices[k] = (kind * hands + steps.before[0]) * hands + steps.digits[k, 0]
    standardize(moves, steps.digits[k])
    return k + 1


@kernel
def canonical(moves: Moves, state: Integer) -> Integer:
    """Return the canonical state of a state."""
    digits = np.empty(moves.radices.shape[0], dtype=np.int64)
    unpack(moves.radices, state, digits)
    standardize(moves, digits)
    return pack(moves, digits)


@kernel
def expand(
    moves: Moves, states: np.ndarray, exists: np.ndarray, steps: Steps
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the E actions of (N,) int64 states, without those whose price does not exist; `exists` is (P,) bool.

    Return (N,) int64, the number of actions of each state; (E,) int64, the states that they lead to; (E,) int32, their
    numbers; and (E,) int32, their prices, as in `Steps`.
    """
    most = states.shape[0] * steps.actions.shape[0]
    counts, targets = np.empty(states.shape[0], dtype=np.int64), np.empty(most, dtype=np.int64)
    actions, prices = np.empty(most, dtype=np.int32), np.empty(most, dtype=np.int32)
    end = 0
    for n in range(states.shape[0]):
        first = end
        for k in range(write_steps(moves, states[n], steps)):
            if exists[steps.prices[k]]:
                targets[end] = pack(moves, steps.digits[k])
                actions[end], prices[end] = steps.actions[k], steps.prices[k]
                end += 1
        counts[n] = end - first
    return counts, targets[:end].copy(), actions[:end].copy(), prices[:end].copy()
