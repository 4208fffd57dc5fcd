"""Whether an automaton tells a label that is read twice from one that is read once."""

from __future__ import annotations

from itertools import chain, combinations

from prefplan.logic.dfa import Automaton

READINGS_TRIED = 2**14
"""Number of readings, of every label in every state, up to which it is found out."""


def is_idempotent(dfa: Automaton) -> bool:
    """Return whether reading any label twice is the same as once; False also if there are too many to try.

    If it is, the automaton's language is closed under stuttering: so are all formulas without X.
    """
    if dfa.size << len(dfa.propositions) > READINGS_TRIED:
        return False
    sizes = range(len(dfa.propositions) + 1)
    labels = map(frozenset, chain.from_iterable(combinations(dfa.propositions, k) for k in sizes))
    return all(
        dfa.step(after, label) == after
        for label in labels
        for after in {dfa.step(state, label) for state in range(dfa.size)}
    )
