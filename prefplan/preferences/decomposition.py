"""Decomposition of an expression over task costs into a sum of terms."""

from __future__ import annotations

from fractions import Fraction

from prefplan.preferences.expression import Constant, Operation, Tree, Variable
from prefplan.preferences.terms import Maximum, SpreadRate, Tardiness, Term, Violation, WeightedRate

_ONE = Constant(Fraction(1))


def decompose(tree: Tree, tasks: int) -> tuple[Fraction, list[Term]] | None:
    """Return an expression as a constant plus additive and convex terms, or None if it has another form.

    Recognised are sums, with factors >= 0, of costs, violation costs, |c_i - c_j|, max - min of the same costs,
    max(0, c_i - d) and weighted maxima of costs.
    """
    parts = _flatten(tree)
    if parts is None:
        return None
    constant, terms = parts.pop(_ONE, Fraction(0)), list[Term]()
    linear, violation = [Fraction(0)] * tasks, [Fraction(0)] * tasks
    for part in list(parts):
        if isinstance(part, Operation) and part.name == "max" and parts.get(part, 0) > 0:
            spread = _common_cost_set(part)
            least = Operation("min", part.operands)
            if spread and parts.get(least, Fraction(0)) == -parts[part]:
                factor, members = spread
                terms.append(SpreadRate(parts.pop(part) * factor, members))
                del parts[least]
    for part, factor in parts.items():
        if factor == 0:
            continue
        if factor < 0:
            return None
        if isinstance(part, Variable):
            (violation if part.violation else linear)[part.task] += factor
            continue
        term = _convex(part, factor, tasks)
        if term is None:
            return None
        terms.append(term)
    if any(linear):
        terms.append(WeightedRate(tuple(linear)))
    if any(violation):
        terms.append(Violation(tuple(violation)))
    return constant, terms


def _flatten(tree: Tree) -> dict[Tree, Fraction] | None:
    """Return a sum as {summand: factor}; constants have the summand 1."""
    result: dict[Tree, Fraction] = {}

    def add(node: Tree, by: Fraction) -> bool:
        match node:
            case Constant(value):
                node, by = _ONE, by * value
            case Operation("+", (a, b)):
                return add(a, by) and add(b, by)
            case Operation("-", (a, b)):
                return add(a, by) and add(b, -by)
            case Operation("*", (Constant(value), other)) | Operation("*", (other, Constant(value))):
                return add(other, by * value)
            case Operation("/", (a, Constant(value))):
                return add(a, by / value)
            case Operation("*" | "/", _):
                return False
        result[node] = result.get(node, Fraction(0)) + by
        return True

    return result if add(tree, Fraction(1)) else None


def _linear(tree: Tree) -> tuple[dict[int, Fraction], Fraction] | None:
    """Return an expression as ({task: factor}, constant), or None if it is not linear in the costs."""
    parts = _flatten(tree)
    if parts is None:
        return None
    constant = parts.pop(_ONE, Fraction(0))
    form: dict[int, Fraction] = {}
    for part, factor in parts.items():
        if not isinstance(part, Variable) or part.violation:
            return None
        if factor:
            form[part.task] = factor
    return form, constant


def _common_cost_set(tree: Operation) -> tuple[Fraction, frozenset[int]] | None:
    """Return (w, tasks) if an operation's operands are w c_i with one common w > 0, else None."""
    members, factors = set(), set()
    for operand in tree.operands:
        linear = _linear(operand)
        if linear is None or linear[1] != 0 or len(linear[0]) != 1:
            return None
        ((task, factor),) = linear[0].items()
        members.add(task)
        factors.add(factor)
    if len(factors) != 1 or min(factors) <= 0:
        return None
    return factors.pop(), frozenset(members)


def _convex(tree: Tree, factor: Fraction, tasks: int) -> Term | None:
    """Return factor * tree as |c_i - c_j|, tardiness or a weighted maximum, or None."""
    if not isinstance(tree, Operation) or tree.name not in ("abs", "max"):
        return None
    forms = [_linear(operand) for operand in tree.operands]
    if any(form is None for form in forms):
        return None
    known = [form for form in forms if form is not None]
    if tree.name == "abs":
        form, constant = known[0]
        if len(form) == 2 and constant == 0 and sum(form.values()) == 0:
            return SpreadRate(factor * max(form.values()), frozenset(form))
        return None
    if len(known) == 2:
        for (zero, nothing), (form, constant) in (known, known[::-1]):
            if not zero and nothing == 0 and len(form) == 1:
                ((task, slope),) = form.items()
                if slope > 0 and constant <= 0:
                    return Tardiness(task, -constant / slope, factor * slope)
    weights = [Fraction(0)] * tasks
    for form, constant in known:
        if constant != 0 or len(form) != 1 or min(form.values()) < 0:
            return None
        ((task, slope),) = form.items()
        weights[task] = max(weights[task], factor * slope)
    return Maximum(tuple(weights))
