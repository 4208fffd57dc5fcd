"""Preference functions straight from their definitions, over exact numbers (Definition 5).

A preference is the `[preference]` table of a scenario file; `reference` turns it into `mu(costs, violations)`, both in
the order of the tasks and in the user's units. Numbers are integers or fractions, so equal values compare equal.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import permutations, product
from typing import Any

Number = int | Fraction
Values = tuple[Number, ...]
Mu = Callable[[Values, Values], Number]

#: Expressions over tasks x, y, z that never fall along a trajectory, with the strongest contract each satisfies.
EXPRESSIONS = {
    "x + 2 * y + z": "additive",
    "abs(x - y) + z": "additive",
    "max(x, y, z) - min(x, y, z)": "additive",
    "max(2 * x, y, z)": "convex",
    "x * x + 2 * y * y + z": "convex",
    "x * y * z": "componentwise",
    "x * y + z": "componentwise",
    "x + min(y, 6) + min(z, 9)": "componentwise",
    "max(3 * x, z) + 2 * y": "componentwise",
    "(x - y) * (x - y) + (y - z) * (y - z)": "general",
    "max(0, y - x) / (1 + x)": "general",
    "abs(x - y) * z": "general",
}


def exact(value: float | Decimal | Fraction) -> Number:
    """Return a number as written: 0.1 is one tenth; of a float's digits the first 15 count."""
    text = str(value)
    if isinstance(value, float) and not value.is_integer():
        text = f"{value:.15g}"
    fraction = Fraction(text)
    return fraction.numerator if fraction.denominator == 1 else fraction


def reference(preference: Mapping[str, Any], names: Sequence[str]) -> Mu:
    """Return mu for a `[preference]` table over tasks of the given names."""
    index = {name: k for k, name in enumerate(names)}
    function = _over_one(preference, names, index)
    if preference["kind"] == "sum":
        terms = [(exact(term.get("weight", 1)), reference(term, names)) for term in preference["terms"]]
        return lambda costs, violations: sum(weight * term(costs, violations) for weight, term in terms)
    if preference.get("over", "cost") == "violation":
        return lambda costs, violations: function(violations)
    return lambda costs, violations: function(costs)


def _over_one(
    preference: Mapping[str, Any], names: Sequence[str], index: Mapping[str, int]
) -> Callable[[Values], Number]:
    kind = preference["kind"]
    if kind == "order":
        groups = [[entry] if isinstance(entry, str) else entry for entry in preference.get("order", names)]
        delay, named = order_delay(groups), sum(groups, [])
        return lambda values: delay({name: values[index[name]] for name in named})
    if kind == "weighted-sum":
        weights = [exact(preference["weights"].get(name, 0)) for name in names]
        return lambda values: sum(w * x for w, x in zip(weights, values, strict=True))
    if kind == "max":
        weights = [exact(preference.get("weights", {}).get(name, 1)) for name in names]
        return lambda values: max(w * x for w, x in zip(weights, values, strict=True))
    if kind == "deadline":
        rows = [
            (index[name], exact(row["by"]), exact(row.get("weight", 1)))
            for name, row in preference["deadlines"].items()
        ]
        return lambda values: sum(weight * max(0, values[k] - by) for k, by, weight in rows)
    if kind == "expression":
        return _expression(preference["expression"], names)
    return lambda values: 0


def order_delay(groups: Sequence[Sequence[str]]) -> Callable[[Mapping[str, Number]], Number]:
    """Return the order-of-satisfaction preference: the least delay over all orders that permute within groups."""
    orders = [sum(chosen, ()) for chosen in product(*(permutations(group) for group in groups))]

    def delay(values: Mapping[str, Number]) -> Number:
        ranked = sorted(values.values())
        return min(sum(max(0, values[task] - ranked[k]) for k, task in enumerate(order)) for order in orders)

    return delay


def _expression(text: str, names: Sequence[str]) -> Callable[[Values], Number]:
    convert: Callable[[Any], Number] = Fraction if "/" in text else exact
    code = compile(re.sub(r"(?<![\w.])\d+(?:\.\d+)?", lambda match: f"number('{match.group()}')", text), text, "eval")
    known = {"__builtins__": {}, "min": min, "max": max, "abs": abs, "number": convert}
    return lambda values: eval(code, known, {name: convert(x) for name, x in zip(names, values, strict=True)})


def random_preference(rng: random.Random, names: Sequence[str], kind: str, over: str = "cost") -> dict[str, Any]:
    """Draw a `[preference]` table of one kind; those over violations are weighted sums, maxima and sums of terms.

    Args:
        rng: source of randomness.
        names: the tasks.
        kind: `order`, `weighted-sum`, `max`, `deadline`, `expression` or `sum`.
        over: `cost` or `violation`; with `sum` at least one term is over violations when so asked.
    """
    table: dict[str, Any] = {"kind": kind}
    if over == "violation" and kind in {"weighted-sum", "max"}:
        table["over"] = over
    if kind == "order":
        table["order"] = _random_groups(rng, _some(rng, names))
    elif kind in {"weighted-sum", "max"}:
        table["weights"] = {name: rng.choice((0, 1, 1, 2, 3)) for name in _some(rng, names)}
    elif kind == "deadline":
        late = [name for name in names if rng.random() < 0.8] or [names[0]]
        table["deadlines"] = {name: {"by": rng.randrange(8), "weight": rng.choice((1, 1, 2))} for name in late}
    elif kind == "expression":
        table["expression"] = named(rng.choice(list(EXPRESSIONS)), rng.sample(list(names), len(names)))
    else:
        kinds = [rng.choice(("order", "weighted-sum", "max", "deadline")) for _ in range(rng.choice((1, 2)))]
        terms = [random_preference(rng, names, kind) for kind in kinds]
        if over == "violation":
            terms.append(random_preference(rng, names, rng.choice(("weighted-sum", "max")), over))
        table["terms"] = [{**term, "weight": rng.choice((1, 2, 3))} for term in terms]
    return table


def named(expression: str, names: Sequence[str]) -> str:
    """Replace x, y, z by names of tasks; with two tasks, z is also the second."""
    places = {place: names[min(k, len(names) - 1)] for k, place in enumerate("xyz")}
    return re.sub(r"\b[xyz]\b", lambda match: places[match.group()], expression)


def _some(rng: random.Random, names: Sequence[str]) -> list[str]:
    """Return all tasks, or sometimes only some: those not named have weight 0, or 1 in a maximum."""
    left_out = rng.randrange(len(names)) if rng.random() < 0.2 else 0
    return rng.sample(list(names), len(names) - left_out)


def _random_groups(rng: random.Random, names: Sequence[str]) -> list[Any]:
    pool = rng.sample(list(names), len(names))
    groups: list[Any] = []
    while pool:
        size = rng.choice((1, 1, 1, 2)) if len(pool) > 1 else 1
        groups.append(pool[0] if size == 1 else pool[:2])
        pool = pool[size:]
    return groups
