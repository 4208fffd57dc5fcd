"""The operators of other tools' temporal logic, defined by those of `judge.syntax`.

Beyond those, a formula is `("iff", f, g)`, `("xor", f, g)`, `("G", f)`, `("W", f, g)`, `("R", f, g)`, `("M", f, g)` or
counts: `("F", f, low, high)`, the same for `G`, `U` and `R` (whose bounds come last), and `("X", f, n)`.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from judge.syntax import Formula

SPELLINGS = {
    "not": ("!", "~", "not "),
    "X": ("X ", "() "),
    "F": ("F ", "<>"),
    "G": ("G ", "[]"),
    "and": ("&", "&&", "and", "/\\"),
    "or": ("|", "||", "or", "\\/"),
    "xor": ("^", "xor"),
    "implies": ("->", "=>", "-->"),
    "iff": ("<->", "<=>"),
    "U": ("U",),
    "W": ("W",),
    "R": ("R", "V"),
    "M": ("M",),
}
STRENGTH = {"implies": 0, "iff": 0, "or": 1, "xor": 2, "and": 3, "U": 4, "W": 4, "R": 4, "M": 4}
TO_THE_RIGHT = {"implies", "iff", "U", "W", "R", "M"}
UNARY = ("not", "X", "F", "G")


def core(formula: Formula) -> Formula:
    """Return an equivalent formula with only `not`, `and`, `or`, `X`, `F` and `U`."""
    kind, *rest = formula
    if kind in ("ap", "true", "false"):
        return formula
    parts = [core(part) for part in rest if isinstance(part, tuple)]
    bounds = [part for part in rest if not isinstance(part, tuple)]
    if kind == "X":
        return _repeated(parts[0], bounds[0] if bounds else 1)
    if kind in ("F", "G"):
        left: Formula = ("true",) if kind == "F" else ("false",)
        return core(({"F": "U", "G": "R"}[kind], left, parts[0], *bounds))
    if kind == "R":
        return ("not", core(("U", ("not", parts[0]), ("not", parts[1]), *bounds)))
    if kind == "U" and bounds:
        # At some position in between, with all the others before it.
        low, high = bounds
        ends = [
            _all([*(_repeated(parts[0], k) for k in range(end)), _repeated(parts[1], end)])
            for end in range(low, high + 1)
        ]
        return ("not", _all([("not", end) for end in ends]))
    first, *second = parts
    other = second[0] if second else first
    return {
        "not": ("not", first),
        "U": ("U", first, other),
        "and": ("and", first, other),
        "or": ("or", first, other),
        "implies": ("or", ("not", first), other),
        "iff": ("or", ("and", first, other), ("and", ("not", first), ("not", other))),
        "xor": ("or", ("and", first, ("not", other)), ("and", ("not", first), other)),
        "W": ("or", ("U", first, other), ("not", ("F", ("not", first)))),
        "M": ("U", other, ("and", first, other)),
    }[kind]


def co_safe(formula: Formula, *, positive: bool = True) -> bool:
    """Return whether no unbounded operator requires something for ever, with negations taken into account."""
    kind, *rest = formula
    if kind in ("ap", "true", "false"):
        return True
    parts = [part for part in rest if isinstance(part, tuple)]
    if kind == "not":
        return co_safe(parts[0], positive=not positive)
    if kind == "implies":
        return co_safe(parts[0], positive=not positive) and co_safe(parts[1], positive=positive)
    if kind in ("iff", "xor"):
        return all(co_safe(part, positive=sign) for part in parts for sign in (True, False))
    lasting = kind in ("G", "W", "R") if positive else kind in ("F", "U", "M")
    counts = len(parts) < len(rest)
    return (counts or not lasting) and all(co_safe(part, positive=positive) for part in parts)


def draw(rng: random.Random, names: Sequence[str], depth: int) -> Formula:
    """Draw a formula with any operators, of at most the given depth."""
    if depth == 0 or rng.random() < 0.1:
        return ("ap", rng.choice(names))
    kind = rng.choice([*STRENGTH, *UNARY, "not", "F", "U"])
    formula = (kind, *(draw(rng, names, depth - 1) for _ in range(1 if kind in UNARY else 2)))
    if kind == "X" and rng.random() < 0.3:
        return (*formula, rng.randrange(4))
    if kind in ("F", "G", "U", "R") and rng.random() < 0.4:
        low = rng.randrange(3)
        return (*formula, low, low + rng.randrange(3))
    return formula


def spelled(formula: Formula, rng: random.Random, needed: int = 0) -> str:
    """Write a formula in spellings drawn at random, with few brackets that it does not need."""
    kind, *rest = formula
    if kind == "ap":
        return str(rest[0])
    bounds = [part for part in rest if not isinstance(part, tuple)]
    separator = rng.choice((",", ":", ".."))
    count = f"[{separator.join(map(str, bounds))}]" if bounds else ""
    if kind in UNARY:
        strength = 5
        sign = rng.choice(SPELLINGS[kind])
        text = f"{sign.strip() + count + ' ' if count else sign}{spelled(rest[0], rng, 5)}"
    else:
        strength = STRENGTH[kind]
        left = spelled(rest[0], rng, strength + (kind in TO_THE_RIGHT))
        right = spelled(rest[1], rng, strength + (kind not in TO_THE_RIGHT))
        text = f"{left} {rng.choice(SPELLINGS[kind])}{count} {right}"
    return f"({text})" if strength < needed or rng.random() < 0.1 else text


def _repeated(formula: Formula, count: int) -> Formula:
    for _ in range(count):
        formula = ("X", formula)
    return formula


def _all(parts: list[Formula]) -> Formula:
    whole = parts[0]
    for part in parts[1:]:
        whole = ("and", whole, part)
    return whole
