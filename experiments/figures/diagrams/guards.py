"""Short labels for an automaton's edges: guards as irredundant sums of products.

S. Minato, "Fast Generation of Prime-Irredundant Covers from Binary Decision Diagrams", IEICE Trans. Fundamentals,
1993: no term can be left out, and no literal in a term.
"""

from collections.abc import Mapping

from prefplan.errors import PrefplanError
from prefplan.logic.dfa import Automaton
from prefplan.logic.mtbdd import Branch, Diagram, Diagrams, cofactors, leaves

Cube = dict[str, bool]
"""A term: the propositions that it fixes, and their values."""

LONG = 22
"""The longest guard of a state is written as `otherwise` if it has more letters than this."""

OTHERWISE = "otherwise"

MOST_PROPOSITIONS = 500
"""Guards of automata with more propositions are not written as terms: they would be illegible."""


class AutomatonSizeError(PrefplanError):
    """An automaton is too large to be shown legibly."""


def labels(automaton: Automaton, state: int) -> dict[int, str]:
    """Return the guard of each successor of a state, in their order of first appearance.

    The automaton is complete, so that one guard may be written as `otherwise`: that of the dead state, or the longest.
    """
    targets = leaves(automaton.transitions[state])
    found = {target: " | ".join(map(product, cover(automaton, state, target))) for target in targets}
    longest = max(found, key=lambda target: len(found[target]))
    if len(found) > 1 and automaton.dead in found:
        found[automaton.dead] = OTHERWISE
    elif len(found) > 1 and len(found[longest]) > LONG:
        found[longest] = OTHERWISE
    return found


def cover(automaton: Automaton, state: int, target: int) -> list[Cube]:
    """Return the guard from a state to a target as terms, none of them redundant.

    Raises:
        AutomatonSizeError: the automaton has more than `MOST_PROPOSITIONS`.
    """
    if len(automaton.propositions) > MOST_PROPOSITIONS:
        raise AutomatonSizeError(
            f"the automaton has {len(automaton.propositions)} propositions, and guards of only up to "
            f"{MOST_PROPOSITIONS} are written as terms; --format hoa writes it"
        )
    family = _Guards()
    when = family.map(automaton.transitions[state], lambda end: end == target)
    return family.cover(when, when)[0]


class _Guards(Diagrams):
    """Decision diagrams of Boolean functions."""

    def __init__(self) -> None:
        super().__init__()
        self._unless = self.lift(lambda a, b: a and not b)
        self._either = self.lift(lambda a, b: a or b)
        self._both = self.lift(lambda a, b: a and b)

    def cover(self, least: Diagram, most: Diagram) -> tuple[list[Cube], Diagram]:
        """Return terms whose sum lies between two Boolean functions, and that sum."""
        if least is False:
            return [], False
        if most is True:
            return [{}], True
        name = min(d.name for d in (least, most) if isinstance(d, Branch))
        least_high, least_low = cofactors(least, name)
        most_high, most_low = cofactors(most, name)
        high, high_sum = self.cover(self._unless(least_high, most_low), most_high)
        low, low_sum = self.cover(self._unless(least_low, most_high), most_low)
        rest = self._either(self._unless(least_high, high_sum), self._unless(least_low, low_sum))
        free, free_sum = self.cover(rest, self._both(most_high, most_low))
        cubes = [{name: True} | cube for cube in high] + [{name: False} | cube for cube in low] + free
        return cubes, self._either(free_sum, self.branch(name, high_sum, low_sum))


def product(cube: Mapping[str, bool]) -> str:
    """Return a term as text, in the syntax of formulas."""
    return " & ".join(name if holds else f"!{name}" for name, holds in cube.items()) or "true"
