"""Buffers for generating the successors of a manipulation model's states, and what is there where states are listed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.models.manipulation.successors import Moves, Steps, steps_of


def no_moves() -> Moves:
    """Return the empty arrays that are passed where states are listed."""
    numbers, flags = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_)
    table, grid = np.zeros((0, 0), dtype=np.bool_), np.zeros((0, 0), dtype=np.int64)
    return Moves(
        radices=numbers,
        location=numbers,
        first_slot=numbers,
        over=numbers,
        above=numbers,
        capacity=numbers,
        movable=flags,
        needs=table.astype(np.int8),
        blocks=table,
        mark=grid,
        neutral=flags,
        places=numbers,
        told=numbers,
        unseen=numbers,
    )


class Digits(NamedTuple):
    """Scratch for generating successors.

    Attributes:
        steps: the actions of a state.
        seen: (D,) int64, digits of the state whose bounds are looked up.
        unmeasured: (1,) int64, output: a state with an action whose cost was not measured, -1 if none was met.
    """

    steps: Steps
    seen: np.ndarray
    unmeasured: np.ndarray


def scratch_digits(moves: Moves) -> Digits:
    """Return scratch for the successors of a model's states."""
    return Digits(steps_of(moves), np.zeros(len(moves.radices), dtype=np.int64), np.full(1, -1, dtype=np.int64))
