"""Co-safe formulas and safety rules in negation normal form; other formulas are refused."""

from collections.abc import Collection, Iterable, Iterator

from prefplan.errors import FormulaError
from prefplan.logic.formula import FALSE, TRUE, And, BoundedRelease, Formula, Literal, Or, Truth, Until, joined
from prefplan.logic.syntax import Part, error_at, one_line, read, split

MOST_PARTS = 20_000
"""Largest number of nodes of a normal form: each `<->` and `^` doubles its operands."""


def parse(text: str, *, propositions: Iterable[str] | None = None, temporal: bool = True) -> Formula:
    """Parse a co-safe formula (Definition 2) in the syntax of several tools; see `prefplan.logic.syntax`.

    Args:
        text: the formula; what is returned is its negation normal form.
        propositions: if given, the only names that may be used.
        temporal: read `Fa` as `F a` unless `Fa` is one of these names.

    Raises:
        FormulaError: for a syntax error (with the column, counted from 1), an unknown proposition (with the nearest
            valid one), or a part that is not co-safe (naming it, and what can be written instead).
    """
    text, names = one_line(text), None if propositions is None else sorted(propositions)
    tree = read(text, names=names, temporal=temporal)
    try:
        return _normal_form(tree, text, True)
    except _UnsafeError as error:
        message = f"not co-safe: {error.why}, which no finite plan shows{_instead(text, tree, error, names)}"
        raise error_at(text, message, error.part.start) from None


def parse_rule(text: str, *, propositions: Iterable[str] | None = None) -> Formula:
    """Parse a safety formula, such as `G !wet`, and return its negation, which its bad prefixes satisfy.

    Raises:
        FormulaError: as in `parse`, but for a part that makes the formula not a safety formula.
    """
    text, names = one_line(text), None if propositions is None else sorted(propositions)
    tree = read(text, names=names)
    try:
        return _normal_form(tree, text, False)
    except _UnsafeError as error:
        asks = f"{error.part.text!r} asks for something at any later time, and no finite plan shows that it never comes"
        hint = "; with `W` in place of `U` it need not come" if error.part.sign == "U" else ""
        raise error_at(text, f"no safety formula: {asks}{hint}", error.part.start) from None


class _UnsafeError(Exception):
    """A part makes a formula not co-safe, or a rule not a safety formula."""

    def __init__(self, part: Part, positive: bool) -> None:
        super().__init__()
        self.part, self.positive = part, positive

    @property
    def why(self) -> str:
        what = repr(self.part.text)
        if self.part.sign in ("F", "G"):
            return f"{what} must hold for ever" if self.positive else f"{what} is negated, so that it must never hold"
        return f"{what}{'' if self.positive else ' is negated, and'} may be met by what holds for ever"


def _normal_form(tree: Part, text: str, positive: bool) -> Formula:
    """Return the normal form of a formula, or of its negation if not `positive`.

    Raises:
        FormulaError: it is too large.
        _UnsafeError: it is not co-safe.
    """

    def size(part: Part) -> int:
        nodes = 1 + sum(map(size, part.parts)) * (2 if part.sign in ("<->", "^") else 1)
        if nodes > MOST_PARTS:
            raise error_at(text, f"more than {MOST_PARTS} parts without `<->` and `^`", part.start)
        return nodes

    size(tree)
    return _signed(tree, positive)


def _signed(part: Part, positive: bool) -> Formula:
    """Return a part, or its negation if not `positive`."""
    match part.sign, part.parts:
        case "name", _:
            return Literal(part.text.strip("\"'"), positive)
        case "true" | "false", _:
            return Truth((part.sign == "true") == positive)
        case "!", (operand,):
            return _signed(operand, not positive)
        case "&" | "|", operands:
            return joined(And if (part.sign == "&") == positive else Or, [_signed(one, positive) for one in operands])
        case "->", (left, right):
            return joined(Or if positive else And, [_signed(left, not positive), _signed(right, positive)])
        case "<->" | "^", (left, right):
            same = (part.sign == "<->") == positive
            pairs = [(_signed(left, sign), _signed(right, sign == same)) for sign in (True, False)]
            return joined(Or, [joined(And, pair) for pair in pairs])
    return _temporal(part, positive)


def _temporal(part: Part, positive: bool) -> Formula:
    low, high = part.low, part.high
    *before, right = [_signed(operand, positive) for operand in part.parts]
    left = before[0] if before else Truth((part.sign == "F") == positive)
    if part.sign in ("W", "M"):  # a W b is b R (a | b), and a M b is b U (a & b)
        left, right = right, joined(Or if (part.sign == "W") == positive else And, [left, right])
    if high == 0:
        return right
    if not before and low == high:
        return Until(TRUE, right, low, high)
    if (part.sign in ("F", "U", "M")) == positive:
        return Until(left, right, low, high)
    if right == TRUE or (low == 0 and (left == TRUE or right == FALSE)):
        return right
    if left == TRUE or right == FALSE:  # then left has to hold before the lower bound
        return left if isinstance(left, Truth) or low == 1 else Until(TRUE, left, 0, low - 1)
    if high is None:
        raise _UnsafeError(part, positive)
    return BoundedRelease(left, right, low, high)


def _instead(text: str, tree: Part, error: _UnsafeError, names: Collection[str] | None) -> str:
    """Return, in words, the task and the rule that are nearest to a formula that is not co-safe."""
    conjuncts = list(_conjuncts(tree))
    whole = next(one for one in conjuncts if one.start <= error.part.start and error.part.end <= one.end)
    others = [one for one in conjuncts if one is not whole]
    nearest = {"task": _task_instead(text, whole, others, error), "rule": whole.text}
    options = [f"the {kind} {new!r}" for kind, new in nearest.items() if _reads(new, names, kind == "task")]
    hint = f"; write {' or '.join(options)}" if options else ""
    word = error.part.text
    if parts := split(word, names):
        hint += f"; {word!r} is read as {' '.join(parts)!r}: put a name in quotes"
    return hint


def _reads(text: str, names: Collection[str] | None, positive: bool) -> bool:
    """Return whether a text is a valid task, or a valid rule if not `positive`."""
    try:
        _normal_form(read(text, names=names), text, positive)
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
        return f"({part.text})" if weak and part.parts and part.sign not in ("!", "X", "F", "G") else part.text

    part, operand = error.part, error.part.parts[-1]
    denied = part.sign == "F" and whole.sign == "!" and whole.parts[0] is part
    if part is whole and part.sign == "G" or denied:
        sign = "!" * denied
        if others:
            reached = others[0].parts[0] if len(others) == 1 and others[0].sign == "F" else None
            return f"{sign}{words(operand)} U {words(reached)}" if reached else " & ".join(map(words, others))
        return sign + words(operand, weak=denied) if any(one in ("X", "F", "U", "M") for one in _signs(operand)) else ""
    if not error.positive and part.sign != "F":
        return ""
    new = words(operand)
    if part.sign in ("W", "R"):
        new = f"{words(part.parts[0])} {'U' if part.sign == 'W' else 'M'} {new}"
    return text[: part.start] + new + text[part.end :]


def _signs(part: Part) -> Iterator[str]:
    yield part.sign
    for one in part.parts:
        yield from _signs(one)
