"""Scenario files whose values make no sense together: the message names the key and the reason."""

from __future__ import annotations

from pathlib import Path

import pytest
from scenario_texts import GRAPH, GRID, TABLE, error_of, with_change

from prefplan import Order, PrefplanError, Problem, ScenarioError, Task, TransitionSystem, load


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("F cheese", "F chese", "tasks[0].formula: unknown proposition 'chese' (did you mean 'cheese'?), at column 3"),
        ("F cheese", "F wall", "tasks[0].formula: unknown proposition 'wall' (valid: cheese, pizza), at column 3"),
        ("F cheese", "G cheese", "tasks[0].formula: not co-safe: 'G cheese' uses G ('always'), at column 1"),
        (
            "!cheese U pizza",
            "!(cheese U pizza)",
            "tasks[1].formula: not co-safe: '!(cheese U pizza)' negates a temporal operator, at column 1",
        ),
        (
            "!cheese U pizza",
            "pizza & (F cheese -> pizza)",
            "tasks[1].formula: not co-safe: 'F cheese -> pizza' negates 'F cheese', which has a temporal operator,"
            " at column 10",
        ),
        ("F cheese", "F (cheese", "tasks[0].formula: '(' is never closed, at column 3"),
        ("F cheese", "F cheese)", "tasks[0].formula: ')' closes no bracket, at column 9"),
        ("F cheese", "", "tasks[0].formula: expected a formula, but the formula ends, at column 1"),
    ],
)
def test_a_formula_that_does_not_fit_is_refused(file: Path, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(GRID, f'"{old}"', f'"{new}"')) == message


def test_a_formula_error_shows_the_place(file: Path) -> None:
    file.write_text(with_change(GRID, "F cheese", "F chese"))
    with pytest.raises(ScenarioError, match=r"\n    F chese\n      \^$"):
        load(file).problem()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cost = 1", "cost = -1", "model.cost: negative cost -1"),
        ("start = [0, 0]", "start = [4, 0]", "model.start: [4, 0] lies outside the grid of 4 x 3 cells"),
        ("start = [0, 0]", "start = [1, 1]", "model.start: [1, 1] lies in obstacle 'wall'"),
        ("size = [4, 3]", "size = [4, 0]", "model.size: must be at least 1 x 1, not 4 x 0"),
        (
            "[2, 0, 3, 1]",
            "[2, 0, 4, 1]",
            "model.regions.cheese: box [2, 0, 4, 1] reaches outside the grid of 4 x 3 cells",
        ),
        (
            "[3, 2, 3, 2]",
            "[3, 3, 3, 3]",
            "model.regions.pizza: box [3, 3, 3, 3] reaches outside the grid of 4 x 3 cells",
        ),
        (
            "[1, 1, 1, 2]",
            "[1, -1, 1, 2]",
            "model.obstacles.wall: box [1, -1, 1, 2] reaches outside the grid of 4 x 3 cells",
        ),
        (
            "[2, 0, 3, 1]",
            "[3, 0, 2, 1]",
            "model.regions.cheese: box [3, 0, 2, 1] needs x0 <= x1 and y0 <= y1 (corners are inclusive)",
        ),
    ],
)
def test_a_grid_that_makes_no_sense_is_refused(file: Path, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(GRID, old, new)) == message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cost = 1", "cost = -1", "model.transitions[0].cost: negative cost -1"),
        ("cost = 0.5", "cost = -0.5", "model.transitions[1].cost: negative cost -0.5"),
        ('start = "s0"', 'start = "s9"', "model.start: unknown state 's9' (valid: s0, s1, s2)"),
        ('s2 = ["plant"]', 's3 = ["plant"]', "model.labels: unknown state 's3' (valid: s0, s1, s2)"),
        (
            'from = "s1", to = "s2"',
            'from = "s0", to = "s2", action = "east"',
            "model.transitions[1]: action 'east' leaves state 's0' twice",
        ),
    ],
)
def test_a_graph_that_makes_no_sense_is_refused(file: Path, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(GRAPH, old, new)) == message


AT_OR_ON = "needs exactly one of 'at' (a point on the table) and 'on' (its supports)"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'start = "right"',
            'start = "left"',
            "model.objects.pink.start: blue and pink both start at 'left', which has room for 1",
        ),
        (
            'start = "right"',
            'start = "top"',
            "model.objects.pink.start: 'top' rests on 'right', where no object starts",
        ),
        (
            'start = "right"',
            'start = "rihgt"',
            "model.objects.pink.start: unknown location 'rihgt' (did you mean 'right'?)",
        ),
        (
            'on = ["left", "right"]',
            'on = ["left", "rigth"]',
            "model.locations.top.on: unknown location 'rigth' (did you mean 'right'?)",
        ),
        ('on = ["left", "right"]', 'at = [0, 0], on = ["left"]', f"model.locations.top: {AT_OR_ON}"),
        ('on = ["left", "right"]', "", f"model.locations.top: {AT_OR_ON}"),
        ("release = 1", "release = -1", "model.costs.release: negative cost -1"),
        (", release = 1", "", "model.costs: no cost for 'release'"),
        ("capacity = 2", "capacity = 0", "model.locations.bin.capacity: must be at least 1, not 0"),
    ],
)
def test_a_table_that_makes_no_sense_is_refused(file: Path, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(TABLE, old, new)) == message


def test_a_mark_that_reads_like_a_location_clashes(file: Path) -> None:
    message = error_of(file, with_change(TABLE, 'marks = "clean"', 'marks = "bin"'))
    assert "proposition 'blue_bin' would mean both 'blue' at 'bin' and 'blue' marked 'bin'" in message


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("eat", "tasks[1].name: 'eat' is used twice"),
        ("max", "tasks[1].name: 'max' is a reserved word (min max abs)"),
        ("abs", "tasks[1].name: 'abs' is a reserved word (min max abs)"),
    ],
)
def test_a_task_needs_a_name_of_its_own(file: Path, name: str, message: str) -> None:
    assert error_of(file, with_change(GRID, 'name = "bake"', f'name = "{name}"')) == message


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('name = "bake"', 'name = "U"', "U"),
        ('name = "bake"', 'name = "true"', "true"),
        ("cheese = [", "X = [", "X"),
        ("pizza = [", "false = [", "false"),
    ],
)
def test_reserved_words_name_nothing(file: Path, old: str, new: str, word: str) -> None:
    message = error_of(file, with_change(GRID, old, new))
    assert f"'{word}' is a reserved word (F G R U W X false true)" in message


def test_a_name_has_letters_digits_and_underscores_only(file: Path) -> None:
    message = error_of(file, with_change(GRID, "cheese = [", '"big cheese" = ['))
    assert "'big cheese' is not a name (letters, digits and _, not starting with a digit)" in message


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GRID, '["bake", "eat"]', '["bake"]', "preference.order: every task needs a place; missing eat"),
        (GRID, '["bake", "eat"]', '["bake", "eta"]', "preference.order: unknown task 'eta' (did you mean 'eat'?)"),
        (GRID, '["bake", "eat"]', '["bake", ["bake", "eat"]]', "preference.order: 'bake' is named twice"),
        (GRAPH, "phi1 = 0.1", "phi1 = -1", "preference.weights.phi1: must not be negative, but is -1"),
        (GRAPH, "phi1 = 0.1", "phi = 1", "preference.weights: unknown task 'phi' (did you mean 'phi1'?)"),
        (GRAPH, "phi1 = 0.1", "", "preference.weights: every task needs one; missing phi1"),
        (TABLE, "by = 20", "by = -20", "preference.deadlines.phi1.by: must not be negative, but is -20"),
        (TABLE, "weight = 2", "weight = -2", "preference.deadlines.phi1.weight: must not be negative, but is -2"),
        (TABLE, "phi1 = {", "phi2 = {", "preference.deadlines: unknown task 'phi2' (did you mean 'phi1'?)"),
    ],
)
def test_a_preference_that_does_not_fit_is_refused(file: Path, text: str, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(text, old, new)) == message


@pytest.mark.parametrize(
    ("tasks", "message"),
    [
        ([], "tasks: a problem needs at least one task"),
        ([Task("a", "F p"), Task("a", "F p")], "tasks[1].name: 'a' is used twice"),
        ([Task("min", "F p")], "tasks[0].name: 'min' is a reserved word (min max abs)"),
        ([Task("a", "F p"), Task("b", "F q")], "tasks[1].formula: unknown proposition 'q' (valid: p), at column 3"),
    ],
)
def test_a_problem_made_in_python_has_the_same_errors(tasks: list[Task], message: str) -> None:
    system = TransitionSystem.from_transitions([], start="s", propositions=["p"])
    with pytest.raises(PrefplanError) as caught:
        Problem(system, tasks, Order())
    assert str(caught.value).split("\n")[0] == message
