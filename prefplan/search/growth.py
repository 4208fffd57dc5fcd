"""How mu grows along a path, for measures whose label key is (g, mu)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.models.kernels import Integer, bare_kernel
from prefplan.product.product_automaton import Product

PRODUCT_LIMIT = 2**61
"""Products of a cost and a weight stay below this."""


class Growth(NamedTuple):
    """How mu grows along a path.

    Attributes:
        rate: (2^N,) int64, units of mu for each unit of cost while that set of tasks is satisfied.
        maximum: (M, 2^N) int64, by satisfied set: mu is at least this times the cost so far.
        late: (D, 3) int64, the task, slope and offset of each tardiness max(0, slope * cost - offset), in units of mu.
        violation: (P,) int64, units of mu for each unit of violation cost.
        cost_limit: from this cost on a product with it might not fit 64 bits.
    """

    rate: np.ndarray
    maximum: np.ndarray
    late: np.ndarray
    violation: np.ndarray
    cost_limit: int


def growth_of(product: Product) -> Growth:
    """Return how mu grows along the paths of a product."""
    measure, units = product.problem.measure, product.units
    maximum = measure.maximum_table(units.factor)
    late = [
        (term.task, int(term.weight * units.factor), min(int(term.weight * term.by / units.mu), PRODUCT_LIMIT))
        for term in measure.tardiness
    ]
    prices = [int(weight * units.price / units.mu) for weight in measure.violation_weights]
    return Growth(
        rate=product.rates,
        maximum=maximum,
        late=np.array(late, dtype=np.int64).reshape(-1, 3),
        violation=np.array(prices, dtype=np.int64),
        cost_limit=PRODUCT_LIMIT // max(1, *(slope for _, slope, _ in late), int(maximum.max(initial=0))),
    )


@bare_kernel
def mu_after(
    growth: Growth, mu: Integer, satisfied: Integer, before: Integer, after: Integer, violation: np.ndarray, pays: bool
) -> Integer:
    """Return a label's mu after a step from cost `before` to `after`.

    Args:
        growth: how mu grows.
        mu: before the step.
        satisfied: the tasks satisfied before the step, as bits.
        before: cost, units.
        after: cost, units.
        violation: (P,) violation costs of the step.
        pays: whether it has any.
    """
    mu += growth.rate[satisfied] * (after - before)
    for d in range(growth.late.shape[0]):
        if not satisfied >> growth.late[d, 0] & 1:
            slope, offset = growth.late[d, 1], growth.late[d, 2]
            mu += max(0, slope * after - offset) - max(0, slope * before - offset)
    if pays:
        for i in range(growth.violation.shape[0]):
            mu += growth.violation[i] * violation[i]
    for m in range(growth.maximum.shape[0]):
        mu = max(mu, growth.maximum[m, satisfied] * after)
    return mu
