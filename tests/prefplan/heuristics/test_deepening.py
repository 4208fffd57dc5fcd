"""Tables of larger sets, which only long searches for one plan fill: the plans must stay the same."""

from __future__ import annotations

import math
from itertools import combinations

import judge
import pytest
from judge.enumerate import cheapest_cost, exact_front
from judge.verdict import misjudged

from prefplan import Options, cheapest_plan
from prefplan.heuristics import preprocessing
from prefplan.heuristics.task_sets import joined_groups
from prefplan.scenario.decode import from_dict

ALL_SETS = [[*combinations(range(3), k)] for k in (1, 2, 3)]
GROUPS = [joined_groups(3, groups) for groups in (3, 2)]


@pytest.mark.parametrize(("levels", "sizes"), [(ALL_SETS, {2, 3}), (GROUPS, {3})])
def test_tables_deepened_in_mid_search_lose_nothing(
    monkeypatch: pytest.MonkeyPatch, levels: list[list[tuple[int, ...]]], sizes: set[int]
) -> None:
    deepened: list[int] = []
    deepen = preprocessing.Prepared.deepen

    def noted(self: preprocessing.Prepared) -> None:
        deepen(self)
        deepened.append(self.bounds.patterns.sets.tasks.shape[1])

    monkeypatch.setattr(preprocessing.Prepared, "deepen", noted)
    monkeypatch.setattr(preprocessing, "DEEPENING_EFFORT", 0)
    monkeypatch.setattr(preprocessing, "levels_of_sets", lambda backward, wanted, *, single, max_entries: levels)
    for seed in range(60):
        problem = judge.random_problem(seed, tasks=3)
        least = cheapest_cost(problem)
        if least is not None:
            plan = cheapest_plan(from_dict(problem.scenario()).problem(), options=Options(landmarks=False))
            assert (plan.cost, plan.preference) == exact_front(problem, max_cost=least)[0], seed
            assert misjudged(problem, plan) is None, seed
    assert set(deepened) == sizes


def test_any_two_tasks_are_in_one_of_the_sets_of_joined_groups() -> None:
    for tasks in range(1, 9):
        for groups in range(1, tasks + 1):
            sets = joined_groups(tasks, groups)
            assert all(any({i, j} <= {*one} for one in sets) for i in range(tasks) for j in range(tasks))
            assert len(sets) == max(1, math.comb(groups, 2))
