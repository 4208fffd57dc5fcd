"""Plans as SVG: on the map of a grid, or as a timeline."""

from __future__ import annotations

import subprocess
import sys
from xml.etree import ElementTree

import pytest
from scenario_texts import shipped_front

import prefplan as pp
from prefplan.plan import Plan, Purchase

SVG = "{http://www.w3.org/2000/svg}"


def drawn(plan: Plan) -> ElementTree.Element:
    return ElementTree.fromstring(plan._repr_svg_())


def words(picture: ElementTree.Element) -> list[str]:
    return [text.text or "" for text in picture.iter(f"{SVG}text")]


def titled(picture: ElementTree.Element) -> dict[str, tuple[float, float]]:
    """Return the left edge and the width of every rectangle that has a title, by the title."""
    found = {}
    for box in picture.iter(f"{SVG}rect"):
        for title in box.iter(f"{SVG}title"):
            found[title.text or ""] = (float(box.attrib["x"]), float(box.attrib["width"]))
    return found


def dots(picture: ElementTree.Element) -> list[tuple[float, float]]:
    return [(float(dot.attrib["cx"]), float(dot.attrib["cy"])) for dot in picture.iter(f"{SVG}circle")]


def test_a_timeline_has_a_block_for_each_action_as_long_as_its_cost() -> None:
    plan = shipped_front("case_study_3")[0]
    blocks = titled(drawn(plan))
    assert list(blocks)[:3] == [
        "transit top: cost 0 to 3",
        "grasp pink: cost 3 to 4",
        "transport pink sanitizer: cost 4 to 9",
    ]
    assert len(blocks) == len(plan.actions) and plan.action_costs[:3] == (3, 1, 5)
    widths = [width for _, width in blocks.values()]
    unit = sum(widths) / plan.cost
    assert widths == pytest.approx([cost * unit for cost in plan.action_costs], abs=0.02)


def test_a_task_ends_below_the_action_that_satisfies_it() -> None:
    plan = shipped_front("case_study_3")[0]
    picture = drawn(plan)
    blocks = list(titled(picture).values())
    ends = {round(left + width, 1) for left, width in blocks}
    assert all(round(x, 1) in ends for x, _ in dots(picture))
    assert sorted(x for x, _ in dots(picture))[-1] == pytest.approx(sum(blocks[-1]), abs=0.02)
    assert {"cost 34, penalty 17", "blue", "34", "pink", "17"} <= set(words(picture))


def test_equal_actions_in_a_row_are_one_block_and_names_are_escaped() -> None:
    plan = Plan(3, 0, {"a<b": 3}, {}, ("go <on>", "go <on>", "stop"), (), action_costs=(1, 1, 1))
    picture = drawn(plan)
    assert list(titled(picture)) == ["2 x go <on>: cost 0 to 2", "stop: cost 2 to 3"]
    assert "a<b" in words(picture)


def test_a_plan_of_no_cost_or_of_no_actions_is_drawn() -> None:
    assert "nothing to do" in words(drawn(Plan(0, 0, {"a": 0}, {}, (), ())))
    assert list(titled(drawn(Plan(0, 0, {"a": 0}, {}, ("go",), (), action_costs=(0,))))) == ["go: cost 0 to 0"]


def test_a_skipped_task_is_not_satisfied() -> None:
    plan = Plan(1, 2, {"a": 1, "b": 1}, {}, ("go",), (), (Purchase("b", 0, None, 2),), action_costs=(1,))
    assert "not satisfied" in words(drawn(plan)) and len(dots(drawn(plan))) == 1


def test_a_plan_on_a_grid_is_drawn_on_its_map() -> None:
    office = pp.GridModel((3, 2), (0, 0), regions={"desk": [(2, 1, 2, 1)]}, obstacles={"wall": [(1, 1, 1, 1)]})
    plan = pp.cheapest_plan(pp.Problem(office, {"work": "F desk"}, pp.Order()))
    picture = drawn(plan)
    boxes = titled(picture)
    assert set(boxes) == {"desk", "wall"} and boxes["desk"][0] - boxes["wall"][0] == pytest.approx(boxes["wall"][1])
    assert {"desk", "work", "cost 3, penalty 0"} == set(words(picture))
    start, goal = dots(picture)
    side = boxes["wall"][1]
    assert (goal[0] - start[0], start[1] - goal[1]) == (pytest.approx(2 * side), pytest.approx(side))
    (way,) = (
        line.attrib["points"].split() for line in picture.iter(f"{SVG}polyline") if line.attrib["stroke-width"] == "2"
    )
    assert [tuple(map(float, point.split(","))) for point in way][::2] == [start, goal]


def test_costs_of_actions_hold_where_the_search_was_on_a_smaller_model() -> None:
    problem = pp.load("kitchen").problem()
    for plan in pp.pareto_front(problem)[:3]:
        assert sum(plan.action_costs) == plan.cost and len(plan.action_costs) == len(plan.actions)
        assert list(plan.action_costs) == list(pp.Ledger.of_plan(problem, plan).costs)


def test_drawing_needs_no_other_library() -> None:
    script = (
        "import sys, prefplan as pp; plan = pp.cheapest_plan('example'); before = set(sys.modules); plan._repr_svg_();"
        "print(len(set(sys.modules) - before), 'matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "0 False\n"
