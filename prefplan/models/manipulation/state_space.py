"""The reachable states of a manipulation model, generated a whole breadth-first layer at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.action_costs import UNMEASURED
from prefplan.models.manipulation.codes import StateCodes, StateLayer
from prefplan.models.manipulation.cost_matrix import cost_matrix, unmeasured
from prefplan.models.manipulation.description import Description, ManipulationState
from prefplan.models.manipulation.numbering import Numbering
from prefplan.models.manipulation.operators import Operator
from prefplan.models.on_demand import OnDemand
from prefplan.models.transition_system import TransitionSystem


def reachable(model: Description, operators: Sequence[Operator], start: ManipulationState) -> TransitionSystem:
    """Return every state of a manipulation model that operators reach from one of them, as a transition system.

    Raises:
        ModelError: the start, or an operator's outcome, is not a state of the model; or an action was not measured.
    """
    space = StateCodes(model, start)
    matrix, unit = cost_matrix(model, [operator.kind for operator in operators], space.hands)
    layer = np.array([space.encode(start, where="start")], dtype=np.int64)
    codes = Numbering(space.bound)
    codes.add(layer)
    index: dict[Action, int] = {}
    empty = np.empty(0, dtype=np.int64)
    sources, targets, actions, costs = [empty], [empty], [empty.astype(np.int32)], [matrix.ravel()[:0]]
    while len(layer):
        states, found = StateLayer(space, layer), [empty]
        for k, operator in enumerate(operators):
            for action, having, target in operator.successors(states):
                before = states.hand[having]
                cost = matrix[k, before, space.digit(target, 0)]
                for hand in before[cost == UNMEASURED]:
                    raise unmeasured(str(action), space.hands[hand])
                found.append(target)
                sources.append(layer[having])
                actions.append(np.full(len(target), index.setdefault(action, len(index)), dtype=np.int32))
                costs.append(cost)
        targets += found
        layer = codes.add(np.concatenate(found))
    source = codes.number(np.concatenate(sources))
    order = np.argsort(source, kind="stable")
    found_codes = codes.all
    labels, label_sets = _labels(space, found_codes)
    return TransitionSystem(
        states=OnDemand(len(found_codes), lambda i: space.decode(int(found_codes[i]))),
        start=0,
        offsets=np.searchsorted(source[order], np.arange(len(codes.all) + 1)).astype(np.int64),
        targets=codes.number(np.concatenate(targets))[order].astype(np.int32),
        actions=np.concatenate(actions)[order],
        costs=np.concatenate(costs)[order],
        unit=unit,
        labels=labels,
        action_names=tuple(map(str, index)),
        label_sets=label_sets,
        propositions=model.own_propositions | model.propositions,
    )


def _labels(space: StateCodes, codes: np.ndarray) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
    """Return each state's label as an index, and the distinct labels: all but the hand's pose matters."""
    hands = len(space.hands)
    keys, labels = np.unique(codes // hands, return_inverse=True)
    # Objects in other slots of the same locations give the same label.
    numbers: dict[frozenset[str], int] = {}
    merged = [numbers.setdefault(space.decode(int(key) * hands).label, len(numbers)) for key in keys]
    return np.array(merged, dtype=np.int32)[labels], tuple(numbers)
