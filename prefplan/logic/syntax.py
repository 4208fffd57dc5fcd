"""The parser of formulas: from text to a tree of the operators as written.

It accepts the spellings of Spot, Owl, SPIN and LTLf2DFA. Precedence and associativity are Spot's, from weak to strong:
`->` and `<->` (right), `|`, `^` and `&` (left), `U`, `W`, `R` and `M` (right), prefix operators. A name in quotes is
never taken for operators.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from prefplan.errors import FormulaError, choices, told
from prefplan.text.names import NAME, RESERVED

NESTING = 120
"""Deeper formulas are refused, since recursion might overflow the stack."""

MOST_STEPS = 1000
"""Greatest bound of a counting operator: the automaton has about as many states."""

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
_VISIBLE = re.compile(r"\S")
_TOKEN = re.compile(
    "|".join([r'"[^"]+"', r"'[^']+'", NAME.pattern, r"\d+", _BOUNDS.pattern, r"\[!\]", *map(re.escape, _SYMBOLS)]),
    re.ASCII,
)


@dataclass(frozen=True)
class Part:
    """A part of a formula as it was written.

    Attributes:
        sign: its operator, in one spelling; `name`, `true` or `false` for a leaf.
        parts: its operands.
        start: first column of its text, from 0.
        end: column after it.
        name: name of a proposition.
        low: least number of steps of a counting operator.
        high: greatest number of steps; None for no bound.
    """

    sign: str
    parts: tuple[Part, ...]
    start: int
    end: int
    name: str = ""
    low: int = 0
    high: int | None = None


def error_at(text: str, message: str, column: int) -> FormulaError:
    """Return an error that points at a column of a formula, from 0; the message counts from 1."""
    return FormulaError(f"{message}, at column {column + 1}\n    {text}\n    {' ' * column}^")


def one_line(text: str) -> str:
    """Return a formula with line breaks and tabs replaced by spaces, so that columns stay the same."""
    if not isinstance(text, str):
        raise FormulaError(f'a formula must be text, such as "F p", not {told(text)}')
    return re.sub(r"\s", " ", text)


def split(name: str, known: Collection[str] | None) -> tuple[str, str] | None:
    """Return a word such as `GFa` as (operators, name), with an empty name for `GF`; None if it is a name itself.

    Args:
        name: the word.
        known: the valid names; None if any name is valid.
    """
    if known is not None and name in known:
        return None
    letters = len(name) - len(name.lstrip("FGX"))
    for end in range(1, letters + 1) if known is not None else {letters} - {0}:
        rest = name[end:]
        if rest and (rest in _CONSTANTS or rest in known if known is not None else rest[0].isalpha()):
            return name[:end], rest
    return (name, "") if letters == len(name) > 1 else None


def read(text: str, *, propositions: Sequence[str] | None, temporal: bool = True) -> Part:
    """Return the tree of a formula.

    Arguments are those of `normal_form.parse`; the text is on one line, and the names are sorted.

    Raises:
        FormulaError: for a syntax error or an unknown name, with the column.
    """
    return _Parser(text, propositions, temporal).read()


@dataclass(frozen=True)
class _Token:
    text: str
    start: int
    end: int


class _Parser:
    """A precedence-climbing parser."""

    def __init__(self, text: str, propositions: Sequence[str] | None, temporal: bool) -> None:
        self.text, self.propositions, self.temporal = text, propositions, temporal
        self.tokens = [*self.scan(), _Token("", len(text.rstrip()), len(text))]
        self.position = self.depth = 0
        self.opened: list[_Token] = []

    def error(self, message: str, column: int) -> FormulaError:
        return error_at(self.text, message, column)

    def scan(self) -> Iterator[_Token]:
        at = 0
        while found := _VISIBLE.search(self.text, at):
            token = _TOKEN.match(self.text, found.start())
            if token is None:
                raise self.error(f"{found[0]!r} means nothing in a formula", found.start())
            at = token.end()
            yield _Token(token[0], token.start(), at)

    @property
    def token(self) -> _Token:
        return self.tokens[self.position]

    def advance(self) -> _Token:
        self.position += 1
        return self.tokens[self.position - 1]

    def nested(self, column: int, *, by: int = 1) -> None:
        self.depth += by
        if self.depth > NESTING:
            raise self.error(f"nested more than {NESTING} deep", column)

    def read(self) -> Part:
        part = self.binary()
        if self.token.text == ")":
            raise self.error("')' closes no bracket", self.token.start)
        if self.token.text:
            raise self.error(f"expected an operator, not {self.token.text!r}", self.token.start)
        return part

    def binary(self, weakest: int = 0) -> Part:
        """Read a formula whose binary operators have at least a precedence level."""
        start, part, joined, depth = self.token.start, self.unary(), "", self.depth
        while (sign := _INFIX.get(self.token.text)) and _LEVEL[sign] >= weakest:
            low, high = self.bounds(sign, self.advance())
            self.nested(start, by=sign not in _FLAT)
            last = self.binary(_LEVEL[sign] + (sign not in _TO_THE_RIGHT))
            self.depth -= sign in _TO_THE_RIGHT
            parts = (*part.parts, last) if joined == sign and sign in _FLAT else (part, last)
            part, joined = Part(sign, parts, start, self.tokens[self.position - 1].end, low=low, high=high), sign
        self.depth = depth
        return part

    def bounds(self, sign: str, token: _Token) -> tuple[int, int | None]:
        """Read the bounds of an operator, if there are any."""
        bounds, found = self.token, _BOUNDS.fullmatch(self.token.text)
        if sign == "X" and bounds.text == "[!]":
            self.advance()
        if found is None:
            return _bounds(sign)
        self.advance()
        low, comma, high = found.groups()
        if sign not in _COUNTING:
            raise self.error(f"{token.text!r} takes no bounds (X F G U R do)", bounds.start)
        if (sign == "X") != (comma is None):
            number = "one number: X[3]" if sign == "X" else f"two bounds: {token.text}[0,5]"
            raise self.error(f"{token.text!r} takes {number}", bounds.start)
        digits = 1 + len(str(MOST_STEPS))  # enough to exceed the limit; Python refuses to read thousands of digits
        low, high = low[:digits], high and high[:digits]
        least, most = int(low), int(high) if high else int(low) if sign == "X" else None
        if max(least, most or 0) > MOST_STEPS:
            raise self.error(f"more than {MOST_STEPS} steps", bounds.start)
        if most is not None and most < least:
            raise self.error(f"the bounds {bounds.text} are in the wrong order", bounds.start)
        return least, most

    def unary(self) -> Part:
        token = self.token
        if token.text in _PREFIX:
            self.advance()
            sign = _PREFIX[token.text]
            low, high = self.bounds(sign, token)
            return self.prefixed([(sign, token.start, low, high)])
        if token.text == "(":
            return self.bracketed()
        return self.atom()

    def begins_formula(self) -> bool:
        """Return whether the next token begins a formula."""
        text = self.token.text
        return (
            text in _PREFIX
            or text in _CONSTANTS
            or text[:1] in {"(", '"', "'"}
            or (bool(NAME.match(text)) and text not in _INFIX)
        )

    def prefixed(self, operators: Sequence[tuple[str, int, int, int | None]]) -> Part:
        """Read the operand of prefix operators, each given as (sign, column, low, high)."""
        self.nested(operators[0][1], by=len(operators))
        part = self.unary()
        self.depth -= len(operators)
        for sign, start, low, high in reversed(operators):
            part = Part(sign, (part,), start, self.tokens[self.position - 1].end, low=low, high=high)
        return part

    def bracketed(self) -> Part:
        self.nested(self.token.start)
        self.opened.append(self.advance())
        part = self.binary()
        if self.token.text != ")":
            if self.token.text:
                raise self.error(f"expected an operator or ')', not {self.token.text!r}", self.token.start)
            raise self.error("'(' is never closed", self.opened[-1].start)
        self.advance()
        self.opened.pop()
        self.depth -= 1
        return part

    def atom(self) -> Part:
        token = self.advance()
        name, quoted = token.text.strip("\"'"), token.text[:1] in {'"', "'"}
        known = self.propositions
        if not quoted and token.text in _CONSTANTS and not (known and name in known):
            return Part(_CONSTANTS[name], (), token.start, token.end)
        if not NAME.fullmatch(name) or (name in RESERVED and not quoted):
            what = f"not {token.text!r}" if token.text else "but the formula ends"
            if not token.text and self.opened:
                what += f" (the '(' at column {self.opened[-1].start + 1} is never closed)"
            raise self.error(f"expected a formula, {what}", token.start)
        operators, rest = (not quoted and self.temporal and split(name, known)) or ("", "")
        if rest:
            self.position -= 1
            self.tokens[self.position] = _Token(rest, token.end - len(rest), token.end)
        if operators and (rest or self.begins_formula()):
            return self.prefixed([(sign, token.start + k, *_bounds(sign)) for k, sign in enumerate(operators)])
        if known is not None and name not in known:
            hint = choices(name, known) if known else "(there are none; `labels` says which hold in a state)"
            raise self.error(f"unknown proposition {name!r} {hint}", token.start)
        return Part("name", (), token.start, token.end, name=name)


def _bounds(sign: str) -> tuple[int, int | None]:
    """Return the default bounds of an operator."""
    return (1, 1) if sign == "X" else (0, None)
