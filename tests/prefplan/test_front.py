"""Fronts as results: indexed, as a DataFrame, as a figure and in a notebook."""

from __future__ import annotations

import copy
import pickle
import sys
from dataclasses import replace
from typing import Any

import pytest
from matplotlib.figure import Figure

from prefplan import Front, Plan, PrefplanError, Purchase, Reason, pareto_front
from prefplan.front import Stats

WHOLE = Front(
    (
        Plan(24, 14, {"wash": 24, "s<b>": 7.5}, {"wash": 0, "s<b>": 0}, ("grasp", "release"), (0, 1, 2)),
        Plan(27, 0, {"wash": 17, "s<b>": 27}, {"wash": 0, "s<b>": 0}, ("wait",), (0, 3)),
    )
)
BEGINNING = Front(WHOLE.plans[:1], ended="time", complete_below=26)
NONE = Front((), reason=Reason("task", ("a & b",)))

TABLE = """\
Pareto front of cost and penalty
#  cost  penalty  wash  s<b>
0    24       14    24   7.5
1    27        0    17    27
A task's column is its cost: the total cost until it was satisfied. 0.00 s, 0 labels expanded.

Plan 0 (2 actions)
1. grasp, 2. release

Plan 1 (1 action)
1. wait"""

HEAD = "<tr><th></th><th>cost</th><th>penalty</th><th>wash</th><th>s&lt;b&gt;</th></tr>"
FIRST = "<tr><td>0</td><td>24</td><td>14</td><td>24</td><td>7.5</td></tr>"
SECOND = "<tr><td>1</td><td>27</td><td>0</td><td>17</td><td>27</td></tr>"


def test_a_front_is_a_sequence_of_its_plans() -> None:
    assert WHOLE[0].cost == 24 and WHOLE[-1].preference == 0
    assert WHOLE[1:] == WHOLE.plans[1:] and list(WHOLE) == [WHOLE[0], WHOLE[1]]
    with pytest.raises(IndexError):
        WHOLE[2]


def test_a_front_that_was_searched_for_can_be_pickled() -> None:
    front = pareto_front("example")
    there = pickle.loads(pickle.dumps(front))
    assert list(there) == list(front) and str(there) == str(front)


def test_equal_fronts_and_plans_are_equal() -> None:
    front, again = pareto_front("example"), pareto_front("example")
    assert front == again == pickle.loads(pickle.dumps(front)) == copy.deepcopy(front)
    assert front != front.over(["cost"]) and front != replace(front, ended="time")
    assert {front[0], again[0]} == {front[0]}


def test_a_front_is_printed_as_a_table_and_plans() -> None:
    assert str(WHOLE) == TABLE
    assert str(NONE) == "No plan: task a & b can never be satisfied."
    assert str(BEGINNING).endswith("\n\nIncomplete: stopped by the time limit; the front is complete below cost 26.")


def test_a_front_is_one_line_where_its_value_is_shown() -> None:
    assert repr(WHOLE) == "<Front of 2 plans: cost 24, penalty 14 to cost 27, penalty 0>"
    stopped = "Incomplete: stopped by the time limit; the front is complete below cost 26."
    assert repr(BEGINNING) == f"<Front of 1 plan: cost 24, penalty 14; {stopped}>"
    assert repr(NONE) == "<Front of 0 plans: No plan: task a & b can never be satisfied.>"


def test_a_plan_is_printed_with_the_costs_of_its_tasks_and_its_relaxations() -> None:
    skipped = replace(WHOLE[0], relaxations=(Purchase("wash", 0, None, 2), Purchase("s<b>", 1, "p", 0.5)))
    assert str(skipped).splitlines() == [
        "cost 24, penalty 14",
        "  wash not satisfied",
        "  s<b> satisfied at cost 7.5",
        "1. grasp, 2. release",
        "  wash is skipped, for 2",
        "  s<b> assumes p after action 1, for 0.5",
    ]


def test_what_stopped_a_search_is_said() -> None:
    assert WHOLE.ending is None
    assert BEGINNING.ending == "stopped by the time limit; the front is complete below cost 26"
    assert Front((), ended="memory").ending == "stopped by the memory limit"
    assert Front((), ended="interrupt").ending == "interrupted"


def test_the_work_of_two_searches_adds_up_but_for_what_one_of_them_held() -> None:
    assert Stats(3, 4, 5, 600, 1.0, 2.0) + Stats(2, 40, 50, 700, 0.5, 0.25) == Stats(3, 44, 55, 700, 1.5, 2.25)


def test_a_data_frame_has_a_row_a_plan() -> None:
    pytest.importorskip("pandas")
    frame = WHOLE.to_pandas()
    assert list(frame.columns) == ["cost", "preference", "task_costs.wash", "task_costs.s<b>", "actions"]
    assert frame.values.tolist() == [[24, 14, 24, 7.5, ("grasp", "release")], [27, 0, 17, 27, ("wait",)]]
    assert [str(kind) for kind in frame.dtypes[:4]] == ["int64", "int64", "int64", "float64"]
    none = NONE.to_pandas()
    assert len(none) == 0 and list(none.columns) == ["cost", "preference", "actions"]


def test_without_pandas_it_is_said_what_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(PrefplanError, match="pip install pandas"):
        WHOLE.to_pandas()


def test_a_figure_has_the_points_in_steps() -> None:
    axes = Figure().subplots()
    assert WHOLE.plot(axes) is axes
    (line,) = axes.lines
    assert (list(line.get_xdata()), list(line.get_ydata())) == ([24, 27], [14, 0])
    assert (line.get_drawstyle(), line.get_marker()) == ("steps-post", "o")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("total cost", "penalty (lower is better)")
    assert axes.get_legend() is None


def test_a_figure_says_how_far_a_search_got() -> None:
    axes = BEGINNING.plot(Figure().subplots())
    assert list(axes.lines[1].get_xdata()) == [26, 26]
    legend: Any = axes.get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["complete up to here"]


def test_a_notebook_shows_a_table() -> None:
    assert WHOLE._repr_html_() == f"<table><thead>{HEAD}</thead><tbody>{FIRST}{SECOND}</tbody></table>"


def test_a_notebook_says_what_is_missing() -> None:
    why = "<p>Incomplete: stopped by the time limit; the front is complete below cost 26.</p>"
    assert BEGINNING._repr_html_() == f"<table><thead>{HEAD}</thead><tbody>{FIRST}</tbody></table>{why}"
    assert NONE._repr_html_() == "<p>No plan: task a &amp; b can never be satisfied.</p>"
    assert Front(())._repr_html_() == "<p>No plan.</p>"
