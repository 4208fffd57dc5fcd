"""Co-safe formulas and safety rules in negation normal form; other formulas are refused."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce

from prefplan.errors import FormulaError
from prefplan.logic.formula import FALSE, TRUE, And, BoundedRelease, Formula, Literal, Next, Or, Truth, Until
from prefplan.logic.syntax import NESTING, Part, error_at, one_line, read, split

_BEFORE, _TEMPORAL, _STRONG = ("!", "X", "F", "G"), ("X", "F", "U", "M"), {"W": "U", "R": "M"}

MOST_PARTS = 20_000
"""Largest number of nodes of a normal form: each `<->` and `^` doubles its operands."""

MOST_HEIGHT = 350
"""Largest height of a normal form, where `a & b & c` is `(a & b) & c`, so that recursion does not overflow."""


def parse(text: str, *, propositions: Iterable[str] | None = None, temporal: bool = True) -> Formula:
    """Parse a co-safe formula (Definition 2) in the syntax of several tools; see `prefplan.logic.syntax`.

    Args:
        text: the formula.
        propositions: if given, the only names that may be used.
        temporal: read `Fa` as `F a` unless `Fa` is one of these names.

    Returns:
        The syntax tree in negation normal form.

    Raises:
        FormulaError: for a syntax error (with the column, counted from 1), an unknown proposition (with the nearest
            valid one), or a part that is not co-safe (naming it, and what can be written instead).
    """
    text, known = one_line(text), None if propositions is None else sorted(propositions)
    tree = read(text, propositions=known, temporal=temporal)
    try:
        return _NormalForm(text)(tree, True)
    except _UnsafeError as error:
        message = f"not co-safe: {error.why(text)}, which no finite plan shows{_instead(text, tree, error, known)}"
        raise error_at(text, message, error.part.start) from None


def parse_rule(text: str, *, propositions: Iterable[str] | None = None) -> Formula:
    """Parse a safety formula, such as `G !wet`, and return its negation, which its bad prefixes satisfy.

    Raises:
        FormulaError: as in `parse`, but for a part that makes the formula not a safety formula.
    """
    text, known = one_line(text), None if propositions is None else sorted(propositions)
    tree = read(text, propositions=known)
    try:
        return _NormalForm(text)(tree, False)
    except _UnsafeError as error:
        what = text[error.part.start : error.part.end]
        message = f"no safety formula: no finite plan breaks {what!r}, which asks for something at any later time"
        raise error_at(text, message, error.part.start) from None


class _UnsafeError(Exception):
    """A part makes a formula not co-safe, or a rule not a safety formula."""

    def __init__(self, part: Part, positive: bool) -> None:
        super().__init__()
        self.part, self.positive = part, positive

    def why(self, text: str) -> str:
        what = repr(text[self.part.start : self.part.end])
        if self.part.sign in ("F", "G"):
            return f"{what} must hold for ever" if self.positive else f"{what} is negated, so that it must never hold"
        return f"{what}{'' if self.positive else ' is negated, and'} may be met by what holds for ever"


class _NormalForm:
    """Converts the parts of a formula, or their negations, to negation normal form."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._sizes: dict[tuple[int, bool], int] = {}
        self._heights: dict[tuple[int, bool], int] = {}
        self._found: dict[tuple[int, bool], Formula] = {}

    def __call__(self, part: Part, positive: bool) -> Formula:
        """Return a part, or its negation if not `positive`.

        Raises:
            _UnsafeError: it is not co-safe.
        """
        key = id(part), positive
        if key not in self._found:
            found = self._formula(part, positive)
            below = [(id(one), sign) for one in part.parts for sign in (True, False)]
            self._sizes[key] = size = 1 + sum(self._sizes.get(one, 0) for one in below)
            if size > MOST_PARTS:
                raise error_at(self._text, f"more than {MOST_PARTS} parts without `<->` and `^`", part.start)
            own = len(part.parts) if len(part.parts) <= NESTING else MOST_PARTS.bit_length()
            self._heights[key] = height = own + max((self._heights.get(one, 0) for one in below), default=0)
            if height > MOST_HEIGHT:
                raise error_at(self._text, f"nested more than {MOST_HEIGHT} deep", part.start)
            self._found[key] = found
        return self._found[key]

    def _formula(self, part: Part, positive: bool) -> Formula:
        match part.sign:
            case "name":
                return Literal(part.name, positive)
            case "true" | "false":
                return Truth((part.sign == "true") == positive)
            case "!":
                return self(part.parts[0], not positive)
            case "&" | "|":
                return _joined(
                    And if (part.sign == "&") == positive else Or, [self(one, positive) for one in part.parts]
                )
            case "->":
                return (Or if positive else And)(self(part.parts[0], not positive), self(part.parts[1], positive))
            case "<->" | "^":
                first, second = part.parts
                same = (part.sign == "<->") == positive
                return Or(And(self(first, True), self(second, same)), And(self(first, False), self(second, not same)))
        return self._temporal(part, positive)

    def _temporal(self, part: Part, positive: bool) -> Formula:
        low, high = part.low, part.high
        if part.sign in ("X", "F", "G") and low == high:
            operand = self(part.parts[0], positive)
            return operand if not low else Next(operand) if low == 1 else Until(TRUE, operand, low, high)
        left: Formula = Truth((part.sign == "F") == positive)
        if len(part.parts) > 1:
            left = self(part.parts[0], positive)
        right = self(part.parts[-1], positive)
        if part.sign in ("W", "M"):  # a W b is b R (a | b), and a M b is b U (a & b)
            left, right = right, (Or if (part.sign == "W") == positive else And)(left, right)
        if high == 0:
            return right
        if (part.sign in ("F", "U", "M")) == positive:
            return Until(left, right, low, high)
        if right == TRUE or (low == 0 and (left == TRUE or right == FALSE)):
            return right
        if left == TRUE or right == FALSE:  # then left has to hold before the lower bound
            return left if isinstance(left, Truth) or low == 1 else Until(TRUE, left, 0, low - 1)
        if high is None:
            raise _UnsafeError(part, positive)
        return BoundedRelease(left, right, low, high)


def _joined(operator: type[And] | type[Or], operands: list[Formula]) -> Formula:
    """Join operands from the left, or into a balanced tree if there are many."""
    if len(operands) <= NESTING:
        return reduce(operator, operands)
    while len(operands) > 1:
        pairs = zip(operands[::2], operands[1::2], strict=False)
        joined: list[Formula] = [operator(left, right) for left, right in pairs]
        operands = joined + operands[len(joined) * 2 :]
    return operands[0]


def _instead(text: str, tree: Part, error: _UnsafeError, known: Sequence[str] | None) -> str:
    """Return, in words, the task and the rule that are nearest to a formula that is not co-safe."""
    conjuncts = list(_conjuncts(tree))
    whole = next(one for one in conjuncts if one.start <= error.part.start and error.part.end <= one.end)
    others = [one for one in conjuncts if one is not whole]
    task, rule = _task_instead(text, whole, others, error), text[whole.start : whole.end]
    choices = (("task", task), ("rule", rule))
    options = [f"the {kind} {new!r}" for kind, new in choices if _reads(new, known, kind == "task")]
    found = f"; write {' or '.join(options)}" if options else ""
    word = text[error.part.start : error.part.end]
    if parts := split(word, known):
        found += f"; {word!r} is read as {' '.join(parts)!r}: put a name in quotes"
    return found


def _reads(text: str, known: Sequence[str] | None, positive: bool) -> bool:
    """Return whether a text is a valid task, or a valid rule if not `positive`."""
    try:
        _NormalForm(text)(read(text, propositions=known), positive)
    except (FormulaError, _UnsafeError):
        return False
    return True


def _conjuncts(tree: Part) -> Iterator[Part]:
    if tree.sign != "&":
        yield tree
        return
    for part in tree.parts:
        yield from _conjuncts(part)


def _task_instead(text: str, whole: Part, others: list[Part], error: _UnsafeError) -> str:
    """Return a formula near to one that is not co-safe; it need not be valid, and may be empty."""

    def words(part: Part, *, weak: bool = True) -> str:
        own = text[part.start : part.end]
        return f"({own})" if weak and part.parts and part.sign not in _BEFORE else own

    part, operand = error.part, error.part.parts[-1]
    denied = part.sign == "F" and whole.sign == "!" and whole.parts[0] is part
    if part is whole and part.sign == "G" or denied:
        sign = "!" * denied
        if others:
            reached = others[0].parts[0] if len(others) == 1 and others[0].sign == "F" else None
            return f"{sign}{words(operand)} U {words(reached)}" if reached else " & ".join(map(words, others))
        return sign + words(operand, weak=denied) if any(one in _TEMPORAL for one in _signs(operand)) else ""
    if not error.positive and part.sign != "F":
        return ""
    new = words(operand)
    if part.sign in _STRONG:
        new = f"{words(part.parts[0])} {_STRONG[part.sign]} {new}"
    return text[: part.start] + new + text[part.end :]


def _signs(part: Part) -> Iterator[str]:
    yield part.sign
    for one in part.parts:
        yield from _signs(one)
