"""A front beside the expected one, point by point."""

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from prefplan.exact_costs import Number, exact, prints_as, to_number
from prefplan.front import Front
from prefplan.plan import Plan, point_of
from prefplan.text.layout import condense, number

FrontPoint = tuple[Number, ...]
"""(cost, preference), or all costs and then all preferences, in the user's units."""

TOLERANCE = Fraction(1, 10**9)
"""Relative tolerance for preference penalties that are doubles, such as thirds. Other values are exact."""


class Row(NamedTuple):
    """A point that is expected, found or both; if it is not expected, `plan` tells its plan."""

    expected: FrontPoint | None
    found: FrontPoint | None
    plan: str = ""

    @property
    def same(self) -> bool:
        """Whether the point is expected and found."""
        return self.expected is not None and self.found is not None


def compare(expected: Sequence[FrontPoint], front: Front) -> list[Row]:
    """Return every point that is expected or found, in order of rising cost."""
    missing = list(expected)
    rows = []
    for index, plan in enumerate(front):
        match = next((point for point in missing if _equal(point, plan)), None)
        if match is None:
            rows.append(Row(None, point_of(plan), f"plan {index}: {condense(plan.actions) or 'no action'}"))
        else:
            missing.remove(match)
            rows.append(Row(match, point_of(plan)))
    return sorted([*rows, *(Row(point, None) for point in missing)], key=_place)


def side_by_side(rows: Sequence[Row]) -> str:
    """Return a comparison as text: `-` marks missing points, `+` unexpected ones, followed by their plans."""
    cells = [("", "expected", "found", "")]
    for row in rows:
        mark = " " if row.same else "-" if row.found is None else "+"
        cells.append((mark, _word(row.expected), _word(row.found), row.plan))
    wide, wider = (max(len(line[k]) for line in cells) for k in (1, 2))
    return "\n".join(f"{mark:1} {one:{wide}}  {other:{wider}}  {plan}".rstrip() for mark, one, other, plan in cells)


def _equal(point: FrontPoint, plan: Plan) -> bool:
    found, costs = point_of(plan), len(plan.costs) or 1
    same_costs = len(point) == len(found) and all(map(prints_as, point[:costs], found))
    return same_costs and all(map(_alike, point[costs:], found[costs:]))


def _alike(penalty: Number, found: Number) -> bool:
    one, other = exact(penalty), exact(found)
    return abs(one - other) <= (TOLERANCE if isinstance(found, float) else 0) * max(abs(one), abs(other))


def _place(row: Row) -> tuple[Fraction, ...]:
    first, *others = row.found or row.expected or (0,)
    return exact(first), *(-exact(value) for value in others)


def _word(point: FrontPoint | None) -> str:
    return "" if point is None else f"({', '.join(number(to_number(exact(value))) for value in point)})"
