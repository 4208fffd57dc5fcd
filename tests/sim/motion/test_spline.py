"""Splines from rest to rest: scipy's clamped ones."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sim.motion.spline import from_rest


@pytest.mark.parametrize("count", [2, 3, 40])
def test_it_is_the_clamped_spline(count: int) -> None:
    rng = np.random.default_rng(count)
    knots, points = np.cumsum(rng.uniform(0.01, 0.03, count)), np.cumsum(rng.normal(size=(count, 7)), axis=0)
    times = np.linspace(knots[0], knots[-1], 5 * count)
    curve, clamped = from_rest(knots, points), CubicSpline(knots, points, bc_type="clamped")
    assert np.array_equal(curve(times), clamped(times))
    assert np.array_equal(curve(times, 1), clamped(times, 1))
