"""The parser of formulas: from text to a tree of the operators as written.

It accepts the spellings of Spot, Owl, SPIN and LTLf2DFA. Precedence and associativity are Spot's, from weak to strong:
`->` and `<->` (right), `|`, `^` and `&` (left), `U`, `W`, `R` and `M` (right), prefix operators. A name in quotes is
never taken for operators.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from prefplan.errors import FormulaError, choices, describe
from prefplan.limits import clocked
from prefplan.text.names import NAME, RESERVED

NESTING = 120
"""Greatest depth of nested operators and brackets: the parser is recursive, and the stack might overflow."""

MOST_STEPS = 1000
"""Greatest bound of a counting operator: the automaton has about as many states."""

COLUMNS_BESIDE = 100
"""Most columns of a formula that an error message shows before, and after, the column that it points at."""

_PREFIX = {"!": "!", "~": "!", "not": "!", "X": "X", "()": "X", "F": "F", "<>": "F", "G": "G", "[]": "G"}
_INFIX = {
    **dict.fromkeys(("->", "=>", "-->", "implies"), "->"),
    **dict.fromkeys(("<->", "<=>", "<-->", "iff"), "<->"),
    **dict.fromkeys(("|", "||", "\\/", "or"), "|"),
    **dict.fromkeys(("^", "xor"), "^"),
    **dict.fromkeys(("&", "&&", "/\\", "and"), "&"),
    **{"U": "U", "W": "W", "R": "R", "V": "R", "M": "M"},
}
_CONSTANTS = {
    **dict.fromkeys(("true", "True", "TRUE", "tt", "1"), "true"),
    **dict.fromkeys(("false", "False", "FALSE", "ff", "0"), "false"),
}
_LEVEL = {"->": 0, "<->": 0, "|": 1, "^": 2, "&": 3, "U": 4, "W": 4, "R": 4, "M": 4}
_TO_THE_RIGHT = {"->", "<->", "U", "W", "R", "M"}
_FLAT = {"&", "|"}
_COUNTING = {"X", "F", "G", "U", "R"}

_SYMBOLS = sorted({text for text in (*_PREFIX, *_INFIX, "(", ")") if not NAME.fullmatch(text)}, key=len, reverse=True)
_BOUNDS = re.compile(r"\[\s*(\d+)\s*(?:(,|:|\.\.)\s*(\d*)\s*)?\]", re.ASCII)
_WORDS = [r'"[^"]+"', r"'[^']+'", NAME.pattern, r"\d+", _BOUNDS.pattern, r"\[!\]", *map(re.escape, _SYMBOLS)]
_TOKEN = re.compile("|".join([*_WORDS, r"(?P<foreign>\S)", r"(?=\s*\Z)"]), re.ASCII)
"""A token of the text, a character that begins no token, or the empty token at the end."""

Bounds = tuple[int, int | None]


@dataclass(frozen=True)
class Part:
    """A part of a formula as it was written.

    Attributes:
        sign: its operator, in one spelling; `name`, `true` or `false` for a leaf.
        parts: its operands; `a & b & c` has three.
        start: first column of its text, from 0.
        text: its text.
        low: least number of steps of a counting operator.
        high: greatest number of steps; None for no bound.
    """

    sign: str
    parts: tuple[Part, ...]
    start: int
    text: str
    low: int = 0
    high: int | None = None

    @property
    def end(self) -> int:
        """The column after its text."""
        return self.start + len(self.text)


def error_at(text: str, message: str, column: int) -> FormulaError:
    """Return an error that points at a column of a formula, from 0; the message counts from 1."""
    first, last = max(0, column - COLUMNS_BESIDE), column + COLUMNS_BESIDE
    before, after = "... " if first else "", " ..." if last < len(text) else ""
    pointer = " " * (len(before) + column - first) + "^"
    return FormulaError(f"{message}, at column {column + 1}\n    {before}{text[first:last]}{after}\n    {pointer}")


def one_line(text: str) -> str:
    """Return a formula with line breaks and tabs replaced by spaces, so that columns stay the same."""
    if not isinstance(text, str):
        raise FormulaError(f'a formula must be text, such as "F p", not {describe(text)}')
    return re.sub(r"\s", " ", text)


def split(word: str, names: Collection[str] | None) -> tuple[str, str] | None:
    """Return a word such as `GFa` as (operators, name), with an empty name for `GF`; None if it is a name itself.

    Without `names`, any name is valid.
    """
    if names is not None and word in names:
        return None
    letters = len(word) - len(word.lstrip("FGX"))
    for end in range(1, letters + 1) if names is not None else {letters} - {0}:
        rest = word[end:]
        if rest and (rest in _CONSTANTS or rest in names if names is not None else rest[0].isalpha()):
            return word[:end], rest
    return (word, "") if letters == len(word) > 1 else None


def read(text: str, *, names: Collection[str] | None, temporal: bool = True) -> Part:
    """Return the tree of a formula on one line; without `names`, any name is valid, and `temporal` is as in `parse`.

    Raises:
        FormulaError: for a syntax error or an unknown name, with the column.
    """
    parser = _Parser(text, names, temporal)
    part = parser.binary(0)
    if parser.token == ")":
        raise parser.error("')' closes no bracket", parser.column)
    if parser.token:
        raise parser.error(f"expected an operator, not {parser.token!r}", parser.column)
    return part


class _Parser:
    """A precedence-climbing parser; `depth` counts the operators and brackets around the part that is read.

    Attributes:
        token: the next token, empty at the end.
        column: where the next token begins.
        end: where the last token read ends.
        ahead: the tokens after the next one, with their columns, in reverse order.
    """

    def __init__(self, text: str, names: Collection[str] | None, temporal: bool) -> None:
        self.text, self.names, self.temporal = text, names, temporal
        matches = list(_TOKEN.finditer(text))
        for match in matches:
            if match["foreign"]:
                raise self.error(f"{match[0]!r} means nothing in a formula", match.start())
        self.ahead = [("", len(text)), *((match[0], match.start()) for match in reversed(matches))]
        self.token, self.column, self.end = *self.ahead.pop(), 0
        self.opened: list[int] = []

    def error(self, message: str, column: int) -> FormulaError:
        return error_at(self.text, message, column)

    def advance(self) -> str:
        """Return the next token, and go on to the one after it."""
        token, self.end = clocked(self.token), self.column + len(self.token)
        self.token, self.column = self.ahead.pop()
        return token

    def part(self, sign: str, parts: tuple[Part, ...], start: int, bounds: Bounds = (0, None)) -> Part:
        """Return a part that ends where the last token read does."""
        return Part(sign, parts, start, self.text[start : self.end], *bounds)

    def nested(self, depth: int, column: int) -> int:
        """Return a depth, or raise FormulaError if it is too large for recursion."""
        if depth > NESTING:
            raise self.error(f"nested more than {NESTING} deep", column)
        return depth

    def binary(self, depth: int, weakest: int = 0) -> Part:
        """Read a formula whose binary operators have at least the precedence level `weakest`."""
        start, part = self.column, self.unary(depth)
        while (sign := _INFIX.get(self.token)) and _LEVEL[sign] >= weakest:
            parts, to_the_right = [part], sign in _TO_THE_RIGHT
            while len(parts) == 1 or (sign in _FLAT and _INFIX.get(self.token) == sign):
                bounds = self.bounds(sign, self.advance())
                below = self.nested(depth + (sign not in _FLAT), start)
                parts.append(self.binary(below, _LEVEL[sign] + (not to_the_right)))
            part = self.part(sign, tuple(parts), start, bounds)
            depth = depth if to_the_right else below
        return part

    def bounds(self, sign: str, operator: str) -> Bounds:
        """Read the bounds of an operator, if there are any."""
        column, written = self.column, _BOUNDS.fullmatch(self.token)
        if sign == "X" and self.token == "[!]":
            self.advance()
        if written is None:
            return _bounds(sign)
        self.advance()
        low, comma, high = written.groups()
        if sign not in _COUNTING:
            raise self.error(f"{operator!r} takes no bounds (X F G U R do)", column)
        if (sign == "X") != (comma is None):
            number = "one number: X[3]" if sign == "X" else f"two bounds: {operator}[0,5]"
            raise self.error(f"{operator!r} takes {number}", column)
        digits = 1 + len(str(MOST_STEPS))  # enough to exceed the limit; Python refuses to read thousands of digits
        low, high = low[:digits], high and high[:digits]
        least, most = int(low), int(high) if high else int(low) if sign == "X" else None
        if max(least, most or 0) > MOST_STEPS:
            raise self.error(f"more than {MOST_STEPS} steps", column)
        if most is not None and most < least:
            raise self.error(f"the bounds {written[0]} are in the wrong order", column)
        return least, most

    def unary(self, depth: int) -> Part:
        start = self.column
        if self.token == "(":
            return self.bracketed(self.nested(depth + 1, start))
        operators = self.operators()
        if not operators:
            return self.atom()
        part = self.unary(self.nested(depth + len(operators), start))
        for sign, column, bounds in reversed(operators):
            part = self.part(sign, (part,), column, bounds)
        return part

    def operators(self) -> list[tuple[str, int, Bounds]]:
        """Read a prefix operator, or all of them at the start of a word such as `GFa`: (sign, column, bounds) each."""
        word, column = self.token, self.column
        if sign := _PREFIX.get(word):
            return [(sign, column, self.bounds(sign, self.advance()))]
        is_name = NAME.fullmatch(word) and word not in _CONSTANTS
        signs, rest = (is_name and self.temporal and split(word, self.names)) or ("", "")
        if rest:
            self.token, self.column = rest, column + len(signs)
        elif signs and _begins_formula(self.ahead[-1][0]):
            self.advance()
        else:
            return []
        return [(sign, column + k, _bounds(sign)) for k, sign in enumerate(signs)]

    def bracketed(self, depth: int) -> Part:
        self.opened.append(self.column)
        self.advance()
        part = self.binary(depth)
        if self.token not in (")", ""):
            raise self.error(f"expected an operator or ')', not {self.token!r}", self.column)
        column = self.opened.pop()
        if self.advance() != ")":
            raise self.error("'(' is never closed", column)
        return part

    def atom(self) -> Part:
        column, token, names = self.column, self.advance(), self.names
        name, quoted = token.strip("\"'"), token[:1] in ("'", '"')
        if not quoted and name in _CONSTANTS and not (names and name in names):
            return self.part(_CONSTANTS[name], (), column)
        if not NAME.fullmatch(name) or (name in RESERVED and not quoted):
            what = f"not {token!r}" if token else "but the formula ends"
            if not token and self.opened:
                what += f" (the '(' at column {self.opened[-1] + 1} is never closed)"
            raise self.error(f"expected a formula, {what}", column)
        if names is not None and name not in names:
            none = "(there are none: `labels` of a graph, `regions` of a grid, or the objects of an arm give them)"
            hint = choices(name, names) if names else none
            raise self.error(f"unknown proposition {name!r} {hint}", column)
        return self.part("name", (), column)


def _begins_formula(token: str) -> bool:
    """Return whether a token begins a formula."""
    if NAME.match(token):
        return token not in _INFIX
    return token in _PREFIX or token in _CONSTANTS or token[:1] in ("(", '"', "'")


def _bounds(sign: str) -> Bounds:
    """Return the default bounds of an operator."""
    return (1, 1) if sign == "X" else (0, None)
