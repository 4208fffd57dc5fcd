"""The judges' own scLTL: formulas as plain tuples, written, read and drawn at random.

A formula is one of `("true",)`, `("false",)`, `("ap", name)`, `("not", f)`, `("and", f, g)`, `("or", f, g)`,
`("implies", f, g)`, `("X", f)`, `("F", f)`, `("U", f, g)`. `!`, `X`, `F` bind tightest, then `U`, `&`, `|`, `->`;
`U` and `->` associate to the right.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence
from typing import Any

Formula = tuple[Any, ...]

UNARY = {"not": "!", "X": "X", "F": "F"}
BINARY = {"implies": "->", "or": "|", "and": "&", "U": "U"}
RIGHT_ASSOCIATIVE = frozenset({"implies", "U"})
STRENGTH = {"implies": 0, "or": 1, "and": 2, "U": 3, "not": 4, "X": 4, "F": 4, "ap": 5, "true": 5, "false": 5}

_TOKEN = re.compile(r"\s*(?:([A-Za-z_][A-Za-z0-9_]*)|(->|[!&|()]))")


def propositions_of(formula: Formula) -> frozenset[str]:
    """Return AP(f): the names of the atoms of a formula."""
    if formula[0] == "ap":
        return frozenset({formula[1]})
    return frozenset().union(*(propositions_of(part) for part in formula[1:]))


def is_boolean(formula: Formula) -> bool:
    """Say whether a formula has no temporal operator."""
    if formula[0] == "ap":
        return True
    return formula[0] not in {"X", "F", "U"} and all(is_boolean(part) for part in formula[1:])


def is_co_safe(formula: Formula) -> bool:
    """Say whether a formula is scLTL: no temporal operator under `!` or on the left of `->`."""
    if formula[0] == "ap":
        return True
    if formula[0] == "not" or formula[0] == "implies":
        return is_boolean(formula[1]) and all(is_co_safe(part) for part in formula[2:])
    return all(is_co_safe(part) for part in formula[1:])


def to_text(formula: Formula) -> str:
    """Write a formula with only the brackets it needs; `parse` gives the same tuple back."""
    return " ".join(_tokens(formula, 0, lambda: False))


def bracketed(formula: Formula) -> str:
    """Write a formula with brackets around every part."""
    return " ".join(_tokens(formula, 0, lambda: True))


def random_text(formula: Formula, rng: random.Random) -> str:
    """Write a formula with redundant brackets and spaces inserted; `parse` gives the same tuple back."""
    words: list[str] = []
    for token in _tokens(formula, 0, lambda: rng.random() < 0.2):
        would_merge = bool(words) and _is_word(words[-1]) and _is_word(token)
        words += [" " * rng.choice((1, 2) if would_merge else (0, 0, 1)), token]
    return "".join(words)


def _is_word(token: str) -> bool:
    return token[0].isalpha() or token[0] == "_"


def _tokens(formula: Formula, needed: int, also: Callable[[], bool]) -> list[str]:
    """Return the tokens of a formula in a place that takes strength `needed`; `also` asks for extra brackets."""
    kind, strength = formula[0], STRENGTH[formula[0]]
    if kind == "ap":
        tokens = [formula[1]]
    elif kind in UNARY:
        tokens = [UNARY[kind], *_tokens(formula[1], strength, also)]
    elif kind in BINARY:
        right = kind in RIGHT_ASSOCIATIVE
        tokens = [
            *_tokens(formula[1], strength + right, also),
            BINARY[kind],
            *_tokens(formula[2], strength + (not right), also),
        ]
    else:
        tokens = [kind]
    return ["(", *tokens, ")"] if strength < needed or also() else tokens


def parse(text: str) -> Formula:
    """Read a formula.

    Raises:
        ValueError: the text is not a formula of the grammar above.
    """
    tokens, at = [], 0
    text = text.rstrip()
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ValueError(f"cannot read {text!r} at position {at}")
        tokens.append(match.group(1) or match.group(2))
        at = match.end()
    tokens.append("")
    formula, end = _parse_binary(tokens, 0, 0)
    if end != len(tokens) - 1:
        raise ValueError(f"{text!r}: {tokens[end]!r} is out of place")
    return formula


_LEVELS = ("implies", "or", "and", "U")


def _parse_binary(tokens: Sequence[str], at: int, level: int) -> tuple[Formula, int]:
    if level == len(_LEVELS):
        return _parse_unary(tokens, at)
    kind = _LEVELS[level]
    left, at = _parse_binary(tokens, at, level + 1)
    while tokens[at] == BINARY[kind]:
        right, at = _parse_binary(tokens, at + 1, level if kind in RIGHT_ASSOCIATIVE else level + 1)
        left = (kind, left, right)
    return left, at


def _parse_unary(tokens: Sequence[str], at: int) -> tuple[Formula, int]:
    token = tokens[at]
    for kind, sign in UNARY.items():
        if token == sign:
            part, at = _parse_unary(tokens, at + 1)
            return (kind, part), at
    if token == "(":
        formula, at = _parse_binary(tokens, at + 1, 0)
        if tokens[at] != ")":
            raise ValueError("a bracket is never closed")
        return formula, at + 1
    if token in {"true", "false"}:
        return (token,), at + 1
    if not token or not _is_word(token) or token in {"U", "G", "R", "W"}:
        raise ValueError(f"a formula should stand where {token!r} does")
    return ("ap", token), at + 1


def random_boolean(rng: random.Random, propositions: Sequence[str], depth: int) -> Formula:
    """Draw a formula without temporal operators, of at most the given depth."""
    if depth == 0 or rng.random() < 0.3:
        if rng.random() < 0.05:
            return (rng.choice(("true", "false")),)
        return ("ap", rng.choice(propositions))
    kind = rng.choice(("not", "not", "and", "or", "implies"))
    return (kind, *(random_boolean(rng, propositions, depth - 1) for _ in range(1 if kind == "not" else 2)))


def random_formula(rng: random.Random, propositions: Sequence[str], depth: int) -> Formula:
    """Draw a co-safe formula over the propositions, of at most the given depth.

    Every operator occurs, `X` and useless parts (`true`, `F` of something already true) among them; it need not be
    satisfiable.
    """
    if depth == 0:
        return random_boolean(rng, propositions, rng.choice((0, 0, 0, 1)))
    kinds = ("F", "U", "X", "and", "or", "implies", "boolean")
    kind = rng.choices(kinds, weights=(28, 26, 12, 16, 9, 4, 5))[0]
    if kind == "boolean":
        return random_boolean(rng, propositions, min(depth, 2))
    if kind == "implies":
        return ("implies", random_boolean(rng, propositions, 1), random_formula(rng, propositions, depth - 1))
    return (
        kind,
        *(random_formula(rng, propositions, depth - 1) for _ in range(1 if kind in {"F", "X"} else 2)),
    )
