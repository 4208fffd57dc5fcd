"""Invalid preferences: each is refused with a message that names the key."""

from __future__ import annotations

import re

import pytest
from small_models import build

from prefplan import Deadline, Due, Expression, Function, Max, Order, PreferenceError, Sum, WeightedSum
from prefplan.preferences.kinds import Preference


@pytest.mark.parametrize(
    ("preference", "where"),
    [
        (Expression("abs(phi1 - phi2)", over="violation"), "expression"),
        (Expression("max(phi1, phi2) - min(phi1, phi2)", over="violation"), "expression"),
        (Expression("phi1 / (1 + phi2)"), "expression"),
        (Function(lambda costs, violations: 1 / (1 + costs[0])), "function"),
        (Sum(((Order(), 1), (Expression("max(0, 20 - phi1)"), 1))), "terms[1].expression"),
    ],
)
def test_a_preference_that_falls_along_a_trajectory_is_refused(preference: Preference, where: str) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(preference, skip=3)
    text = rf"preference.{re.escape(where)}: falls along a trajectory, from \S+ at \(phi1=.*\) to \S+ at \(phi1=.*\)"
    assert re.fullmatch(text, str(caught.value))


@pytest.mark.parametrize(
    "expression", ["phi1 - phi2", "phi1 - 5", "10 - phi1", "-phi1", "-1", "min(phi1, phi2) - 1 + 1e17 - 1e17"]
)
def test_a_preference_that_can_be_negative_is_refused(expression: str) -> None:
    with pytest.raises(PreferenceError, match=r"^preference.expression: must not be negative, but is -\d+ at \(phi1="):
        build(Expression(expression))


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("phi1 / phi2", "divides by 'phi2', which can be zero"),
        ("phi1 / (phi2 - phi2)", "divides by '(phi2 - phi2)', which can be zero"),
        ("1 / abs(phi1 - phi2)", "divides by 'abs((phi1 - phi2))', which can be zero"),
        ("__import__(1)", "function '__import__' is not allowed (valid: min, max, abs), at column 1"),
        ("pow(phi1, 2)", "function 'pow' is not allowed (valid: min, max, abs), at column 1"),
        ("mix(phi1, phi2)", "function 'mix' is not allowed (did you mean 'min'?), at column 1"),
        ("phi1.real", "'phi1.real' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 1"),
        (
            "2 + phi1 ** 2",
            "'phi1 ** 2' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 5",
        ),
        ("phi1 < phi2", "'<' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 6"),
        ("phi1 if phi2 else 3", "invalid syntax, at column 6"),
        ("phi1, phi2", "'phi1, phi2' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 1"),
        ("max(*phi1)", "'*phi1' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 5"),
        ("[phi1]", "'[' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 1"),
        ("phi4", "unknown task 'phi4' (did you mean 'phi3'?), at column 1"),
        ("min", "unknown task 'min' (valid: phi1, phi2, phi3), at column 1"),
        ("", "invalid syntax, at column 1"),
        ("phi1 +", "invalid syntax, at column 7"),
        ("(phi1", "'(' was never closed, at column 1"),
        ("phi1)", "unmatched ')', at column 5"),
        ("max()", "max takes at least one argument, not 0, at column 1"),
        ("abs(phi1, phi2)", "abs takes one argument, not 2, at column 1"),
        ("1_000 * phi1", "'1_000' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 1"),
        ("phi1" + " + phi1" * 200, "longer than 400 names, numbers and symbols, or 4000 letters"),
        ("phi1 + " + "9" * 5000, "longer than 400 names, numbers and symbols, or 4000 letters"),
    ],
)
def test_an_expression_that_cannot_be_read_is_refused(expression: str, message: str) -> None:
    with pytest.raises(PreferenceError) as caught:
        build(Expression(expression))
    told, *drawing = str(caught.value).split("\n")
    assert told == f"preference.expression: {message}"
    if column := re.search(r"at column (\d+)$", message):
        assert drawing == [f"    {expression}", f"    {' ' * (int(column[1]) - 1)}^"]


@pytest.mark.parametrize("text", ["1e400 * phi1", "1e999999999 * phi1", "1e-999999 * phi1", "*".join(["phi1"] * 190)])
def test_expressions_beyond_reason_are_refused(text: str) -> None:
    with pytest.raises(PreferenceError, match=r"preference.expression: (a number beyond|is inf at)"):
        build(Expression(text))


@pytest.mark.parametrize(
    ("preference", "message"),
    [
        (Order(("phi1", "phi2", "phi4")), "order: unknown task 'phi4' (did you mean 'phi3'?)"),
        (Order(("zzz", "phi1")), "order: unknown task 'zzz' (valid: phi1, phi2, phi3)"),
        (Order(()), "order: must name at least one task (valid: phi1, phi2, phi3)"),
        (Order(("phi1", ("phi2", "phi1"), "phi3")), "order: 'phi1' is named twice"),
        (Max({"phi": 1}), "weights: unknown task 'phi' (did you mean 'phi3'?)"),
        (Max({"phi1": -1}), "weights.phi1: must not be negative, but is -1"),
        (Max(over="time"), "over: 'time' is unknown (valid: cost, violation)"),
        (WeightedSum({"phi1": 1, "phi2": 1, "phi3": 1}, over="violations"), "over: 'violations' is unknown (did you "),
        (WeightedSum({"phi1": 1, "phi2": 1, "phi3": -1}), "weights.phi3: must not be negative, but is -1"),
        (Deadline({"phi": Due(3)}), "deadlines: unknown task 'phi' (did you mean 'phi3'?)"),
        (Deadline({"phi1": Due(-3)}), "deadlines.phi1.by: must not be negative, but is -3"),
        (Deadline({"phi1": Due(3, -0.5)}), "deadlines.phi1.weight: must not be negative, but is -0.5"),
        (Deadline({"phi1": Due(1)}, over="x"), "over: 'x' is unknown (valid: cost, violation)"),
        (Expression("phi1", contract="monotone"), "contract: 'monotone' is unknown (valid: additive, convex, "),
        (Expression("phi1", over="costs"), "over: 'costs' is unknown (did you mean 'cost'?)"),
        (Function(lambda c, v: c[0], contract="sum"), "contract: 'sum' is unknown (valid: additive, convex, "),
        (Sum(()), "terms: a sum needs at least one"),
        (Sum(((Order(), -2),)), "terms[0].weight: must not be negative, but is -2"),
        (Sum(((Order(), 1), (Max({"x": 1}), 1))), "terms[1].weights: unknown task 'x' (valid: phi1, phi2, phi3)"),
        (Sum(((Order(), 1), (Order(()), 1))), "terms[1].order: must name at least one task (valid: phi1, phi2, phi3)"),
    ],
)
def test_a_preference_that_does_not_fit_names_the_key(preference: Preference, message: str) -> None:
    with pytest.raises(PreferenceError, match="^" + re.escape(f"preference.{message}")):
        build(preference)
