"""What kernels need of a manipulation model whose states are generated as a search meets them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.models.manipulation.successors import Moves, Steps, steps_of


class Generated(NamedTuple):
    """A model whose states are generated, as the automata of N tasks and R rules see it.

    Attributes:
        moves: the model, of H poses of the hand and D digits of a state.
        costs: (4 H H,) int64, by price, as in `Steps`; negative where an action was not measured.
        letters: (N + R, D, r) int64, what each value of a digit adds to the number of the letter that each automaton
            reads.
        steps: scratch, the actions of a state.
        unmeasured: (1,) int64, output: a state with an action whose cost was not measured, -1 if none was met.
    """

    moves: Moves
    costs: np.ndarray
    letters: np.ndarray
    steps: Steps
    unmeasured: np.ndarray


def generated(moves: Moves, costs: np.ndarray, letters: np.ndarray) -> Generated:
    """Return a model with its scratch; arguments as in `Generated`."""
    return Generated(moves, costs.astype(np.int64), letters, steps_of(moves), np.full(1, -1, dtype=np.int64))
