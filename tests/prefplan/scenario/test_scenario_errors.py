"""Scenario files that are refused: the message names the key, and says what is wrong or would be valid."""

from __future__ import annotations

from pathlib import Path

import pytest
from scenario_texts import GRAPH, GRID, TABLE, error_of, with_change

from prefplan import ScenarioError, load

WEIGHED = 'kind = "weighted-sum"\nweights = { phi1 = 0.1 }'

SUM_OF_SUM = 'kind = "sum"\nterms = [{ kind = "sum" }]'

RELAX = 'formula = "F plant"\nrelax = [{ assume = "rock", when = "true", cost = "1" }]'


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GRID, "cost = 1", "cots = 1", "model.cots: unknown key (did you mean 'cost'?)"),
        (GRID, "[preference]", "[prefrence]", "prefrence: unknown key (did you mean 'preference'?)"),
        (
            GRID,
            "[model]",
            'title = "x"\n[model]',
            "title: unknown key (valid: model, tasks, preference, preferences, rules)",
        ),
        (
            GRID,
            "[preference]",
            'preference = "order"\n[preference]',
            "tasks[1].preference: is no key of tasks[1]; "
            "write the heading [preference], and below it the keys of its own table",
        ),
        (
            GRAPH,
            "transitions",
            'file = "town.csv"\ntransitions',
            "model.transitions: these are in the file already; leave out this key or `file`",
        ),
        (GRAPH, 'to = "s2"', 'too = "s2"', "model.transitions[1].too: unknown key (did you mean 'to'?)"),
        (TABLE, 'marks = "clean"', 'mark = "x"', "model.locations.san.mark: unknown key (did you mean 'marks'?)"),
        (GRID, 'order = ["bake", "eat"]', 'over = "violation"', "preference.over: unknown key (did you mean 'order'?)"),
        (
            TABLE,
            "[model.locations]",
            "[model.robot]\nheading = 3\n[model.locations]",
            "model.robot.heading: unknown key "
            "(valid: name, at, yaw, mjcf, joints, tool, gripper, home, velocity, torque, acceleration)",
        ),
        (
            TABLE,
            "[model]",
            '[model]\noperators = ["push"]',
            "model.operators: unknown key "
            "(valid: start, costs, locations, objects, propositions, fixtures, robot, abstract, scene, kind)",
        ),
        (TABLE, "release = 1", "releese = 1", "model.costs: unknown action 'releese' (did you mean 'release'?)"),
        (GRID, 'kind = "grid"', 'kind = "gird"', "model.kind: unknown kind 'gird' (did you mean 'grid'?)"),
        (GRID, 'kind = "grid"\n', "", "model.kind: missing (valid: graph, grid, manipulation)"),
        (GRID, 'kind = "order"', 'kind = "ordr"', "preference.kind: unknown kind 'ordr' (did you mean 'order'?)"),
        (
            GRAPH,
            WEIGHED,
            SUM_OF_SUM,
            "preference.terms[0].kind: unknown kind 'sum' (valid: order, weighted-sum, max, deadline, expression)",
        ),
    ],
)
def test_an_unknown_key_or_kind_is_named_with_those_there_are(
    file: Path, text: str, old: str, new: str, message: str
) -> None:
    assert error_of(file, with_change(text, old, new)) == message


TASKS = GRID[GRID.index("[[tasks]]") : GRID.index("[preference]")]


@pytest.mark.parametrize(
    ("text", "old", "key", "expected"),
    [
        (GRID, "size = [4, 3]\n", "model.size", "; expected [width, height] in cells"),
        (GRID, 'name = "bake"\n', "tasks[1].name", ""),
        (GRID, TASKS, "tasks", "; expected tables: write [[tasks]] above each"),
        (GRID, GRID[: GRID.index("[[tasks]]")], "model", ""),
        (GRAPH, 'from = "s1", ', "model.transitions[1].from", ""),
        (TABLE, 'start = "left", ', "model.objects.blue.start", ""),
        (TABLE, "by = 20, ", "preference.deadlines.phi1.by", ""),
    ],
)
def test_a_missing_key_is_named(file: Path, text: str, old: str, key: str, expected: str) -> None:
    assert error_of(file, with_change(text, old, "")) == f"{key}: missing{expected}"


def test_a_missing_kind_of_preference_comes_with_the_valid_ones(file: Path) -> None:
    message = error_of(file, with_change(GRID, 'kind = "order"\n', ""))
    assert message.startswith("preference.kind: missing (valid: order, weighted-sum, ")


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GRID, "cost = 1", 'cost = "one"', "model.cost: must be a number, not 'one'"),
        (GRID, "cost = 1", "cost = true", "model.cost: must be a number, not True"),
        (GRID, "size = [4, 3]", "size = 4", "model.size: must be [width, height] in cells, not 4"),
        (
            GRID,
            "start = [0, 0]",
            "start = [0]",
            "model.start: must be [x, y], the cell where the robot starts, not [0]",
        ),
        (
            GRID,
            "start = [0, 0]",
            "start = [0.5, 0]",
            "model.start: must be [x, y], the cell where the robot starts, not [0.5, 0]",
        ),
        (
            GRID,
            "[2, 0, 3, 1]",
            '"all"',
            "model.regions.cheese: must be [x0, y0, x1, y1] in whole cells, or a list of such boxes, not 'all'",
        ),
        (GRID, 'name = "bake"', "name = 3", "tasks[1].name: must be a string, not 3"),
        (GRID, TASKS, "[tasks]\nname = 3\n", "tasks: must be tables: write [[tasks]] above each, not { name = 3 }"),
        (
            GRAPH,
            's2 = ["plant"]',
            's2 = "plant"',
            "model.labels.s2: must be a list of propositions, such as [\"shelf\"], not 'plant'",
        ),
        (GRAPH, 'formula = "F plant"', RELAX, "tasks[0].relax[0].cost: must be a number, not '1'"),
        (TABLE, "release = 1", 'release = "x"', "model.costs.release: must be a number, not 'x'"),
        (TABLE, "capacity = 2", "capacity = 1.5", "model.locations.bin.capacity: must be an integer, not 1.5"),
        (TABLE, "fixed = false", "fixed = 0", "model.objects.pink.fixed: must be true or false, not 0"),
        (
            TABLE,
            "[0.50, 0.03]",
            "[0.50]",
            "model.locations.left.at: must be [x, y] or [x, y, height] in metres, not [0.5]",
        ),
        (
            TABLE,
            "[0.50, 0.03]",
            '[0.50, "0"]',
            "model.locations.left.at: must be [x, y] or [x, y, height] in metres, not [0.50, '0']",
        ),
        (
            GRID,
            "F cheese",
            "F wall",
            "tasks[0].formula: unknown proposition 'wall' (valid: cheese, pizza), at column 3",
        ),
        (
            GRID,
            "F cheese",
            "G cheese",
            "tasks[0].formula: not co-safe: 'G cheese' must hold for ever, which no finite plan shows; "
            "write the rule 'G cheese', at column 1",
        ),
        (GRID, 'name = "bake"', 'name = "eat"', "tasks[1].name: 'eat' is used twice"),
        (GRID, "cost = 1", "cost = -1", "model.cost: negative cost -1"),
        (GRID, '["bake", "eat"]', "[]", "preference.order: must name at least one task (valid: eat, bake)"),
        (
            GRAPH,
            WEIGHED,
            'kind = "expression"',
            'preference.expression: missing; expected text, such as "TASK1 + 2 * TASK2"',
        ),
        (TABLE, ", release = 1", "", "model.costs: no cost for 'release'"),
    ],
)
def test_values_that_do_not_fit_are_named_by_their_key(file: Path, text: str, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(text, old, new)) == message


def test_an_empty_file_misses_its_first_key(file: Path) -> None:
    assert error_of(file, "") == "model: missing"


def test_a_formula_error_shows_the_place(file: Path) -> None:
    file.write_text(with_change(GRID, "F cheese", "F chese"))
    with pytest.raises(ScenarioError, match=r"\n    F chese\n      \^$"):
        load(file).problem()
