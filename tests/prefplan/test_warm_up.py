"""`is_compiled` tells whether the kernels are cached, so that a notice to wait is not shown in vain."""

from __future__ import annotations

from prefplan import Order, Problem, Task, TransitionSystem, pareto_front
from prefplan.warm_up import is_compiled


def test_after_a_search_it_is_compiled() -> None:
    system = TransitionSystem.from_transitions([("a", "go", "b", 1)], start="a", labels={"b": ["there"]})
    assert len(pareto_front(Problem(system, [Task("t", "F there")], Order()))) == 1
    assert is_compiled()
