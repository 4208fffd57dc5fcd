"""Plans in notebooks: on the map of a grid, or as a timeline."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from scenario_texts import shipped_front

import prefplan as pp
from prefplan.plan import Plan, Purchase


def drawn(plan: Plan) -> Axes:
    """Draw a plan, after checking that a notebook gets it as SVG."""
    assert ElementTree.fromstring(plan._repr_svg_()).tag == "{http://www.w3.org/2000/svg}svg"
    return plan.plot()


def words(axes: Axes) -> set[str]:
    names = [*axes.texts, *axes.get_yticklabels()]
    return {text.get_text() for text in names} | {axes.get_title(loc="left")}


def boxes(axes: Axes) -> dict[str, tuple[float, float]]:
    """Return the left edge and the width of every named rectangle, by its name."""
    found = [box for box in axes.patches if isinstance(box, Rectangle)]
    return {str(box.get_gid()): (box.get_x(), box.get_width()) for box in found}


def dots(axes: Axes) -> list[tuple[float, float]]:
    return [tuple(line.get_xydata()[0]) for line in axes.lines if line.get_marker() == "o"]


def test_a_timeline_has_a_block_for_each_action_as_long_as_its_cost() -> None:
    plan = shipped_front("case_study_3")[0]
    bars = [box for box in drawn(plan).patches if isinstance(box, Rectangle)]
    assert [bar.get_gid() for bar in bars][:3] == ["transit top", "grasp pink", "transport pink sanitizer"]
    assert plan.action_costs[:3] == (3, 1, 5)
    assert [bar.get_width() for bar in bars] == pytest.approx(list(plan.action_costs))
    assert [bar.get_x() for bar in bars][:4] == [0, 3, 4, 9]


def test_a_task_ends_below_the_action_that_satisfies_it() -> None:
    plan = shipped_front("case_study_3")[0]
    axes = drawn(plan)
    ends = [left + width for left, width in boxes(axes).values()]
    assert all(any(x == pytest.approx(end) for end in ends) for x, _ in dots(axes))
    assert sorted(x for x, _ in dots(axes)) == [17, 34]
    assert {"cost 34, penalty 17", "blue", "34", "pink", "17"} <= words(axes)
    assert axes.get_xlabel() == "cost"


def test_equal_actions_in_a_row_are_one_block_and_names_are_written_as_they_are() -> None:
    plan = Plan(3, 0, {"a<b": 3}, {}, ("go $<on>$", "go $<on>$", "stop"), (), action_costs=(1, 1, 1))
    axes = drawn(plan)
    assert boxes(axes) == {"2 x go $<on>$": (0, 2), "stop": (2, 1)}
    assert {"a<b", "2 x go $<on>$"} <= words(axes)


def test_a_plan_of_no_cost_or_of_no_actions_is_drawn() -> None:
    assert boxes(drawn(Plan(0, 0, {"a": 0}, {}, (), ()))) == {}
    assert boxes(drawn(Plan(0, 0, {"a": 0}, {}, ("go",), (), action_costs=(0,)))) == {"go": (0, 0)}


def test_a_skipped_task_is_not_satisfied() -> None:
    plan = Plan(1, 2, {"a": 1, "b": 1}, {}, ("go",), (), (Purchase("b", 0, None, 2),), action_costs=(1,))
    axes = drawn(plan)
    assert "not satisfied" in words(axes) and len(dots(axes)) == 1


def test_a_plan_on_a_grid_is_drawn_on_its_map() -> None:
    office = pp.GridModel((3, 2), (0, 0), regions={"desk": [(2, 1, 2, 1)]}, obstacles={"wall": [(1, 1, 1, 1)]})
    plan = pp.cheapest_plan(pp.Problem(office, {"work": "F desk"}, pp.Order()))
    axes = drawn(plan)
    assert boxes(axes) == {"desk": (1.5, 1), "wall": (0.5, 1)}
    assert {"desk", "work", "cost 3, penalty 0"} == words(axes) - {""}
    assert dots(axes) == [(0, 0), (2, 1)]
    path = axes.lines[0].get_xydata().tolist()
    assert path[0] == [0, 0] and path[-1] == [2, 1] and len(path) == 4


def test_costs_of_actions_hold_where_the_search_was_on_a_smaller_model() -> None:
    problem = pp.load("kitchen").problem()
    for plan in pp.pareto_front(problem)[:3]:
        assert sum(plan.action_costs) == plan.cost and len(plan.action_costs) == len(plan.actions)
        assert list(plan.action_costs) == list(pp.Ledger.of_plan(problem, plan).costs)
