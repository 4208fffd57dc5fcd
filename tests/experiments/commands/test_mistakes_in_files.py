"""Natural mistakes in files and options: each has a message that says what is wrong, where, and what would be right."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from command_line import call
from scenario_texts import GRAPH, GRID, TABLE

TASKS = GRID[GRID.index("[[tasks]]") : GRID.index("[preference]")]
PREFERENCE = GRID[GRID.index("[preference]") :]

IN_FILES = [
    (
        GRID,
        "[[tasks]]",
        "[tasks]",
        "not TOML: Cannot declare ('tasks',) twice (at line 17, column 7); write [[tasks]] above each of its tables",
    ),
    (
        GRID,
        TASKS,
        '[tasks]\nname = "eat"\nformula = "F cheese"\n',
        "tasks: must be tables: write [[tasks]] above each, not { name = 'eat', formula = 'F cheese' }",
    ),
    (
        GRID,
        TASKS,
        "",
        "tasks: missing; expected tables: write [[tasks]] above each",
    ),
    (
        GRID,
        PREFERENCE,
        "",
        'preference: missing; write [preference] and below it, for example, kind = "order"',
    ),
    (
        GRID,
        PREFERENCE,
        "[preference]\n",
        "preference.kind: missing (valid: order, weighted-sum, max, deadline, expression, sum)",
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "weighted-sum"\nweights = [1, 2]\n',
        "preference.weights: must be weights by task, such as { TASK = 2 }, not [1, 2]",
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "weighted-sum"\n',
        "preference.weights: missing; expected weights by task, such as { TASK = 2 }",
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "order"\norder = "bake"\n',
        'preference.order: must be a list of tasks, such as ["TASK1", "TASK2"], or of groups of tasks, not \'bake\'',
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "deadline"\ndeadlines = { eat = 20 }\n',
        "preference.deadlines.eat: must be a table such as { by = 20, weight = 1 }, not 20",
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "expression"\nexpression = "eat - 20"\n',
        "preference.expression: must not be negative, but is -20 at (eat=0, bake=0); write max(0, ...)",
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "expression"\nexpression = "eat ^ 2"\n',
        "preference.expression: '^' is not allowed (only + - * / min max abs, numbers, brackets, tasks), at column 5",
    ),
    (
        GRID,
        PREFERENCE,
        '[preference]\nkind = "sum"\nterms = ["order"]\n',
        "preference.terms[0]: must be a table with a kind (valid: order, weighted-sum, max, deadline, "
        "expression), not 'order'",
    ),
    (
        GRID,
        PREFERENCE,
        '[[preference]]\nkind = "order"\n',
        "preference: must be a table with a kind (valid: order, weighted-sum, max, deadline, "
        "expression, sum), not [{ kind = 'order' }]",
    ),
    (
        GRID,
        "[2, 0, 3, 1]",
        "[2, 0]",
        "model.regions.cheese: must be [x0, y0, x1, y1] in whole cells, or a list of such boxes, not [2, 0]",
    ),
    (
        GRID,
        "[2, 0, 3, 1]",
        '"2 0 3 1"',
        "model.regions.cheese: must be [x0, y0, x1, y1] in whole cells, or a list of such boxes, not '2 0 3 1'",
    ),
    (
        GRID,
        "[2, 0, 3, 1]",
        "[3, 1, 2, 0]",
        "model.regions.cheese: box [3, 1, 2, 0] needs x0 <= x1 and y0 <= y1 (corners are inclusive)",
    ),
    (
        GRID,
        "[2, 0, 3, 1]",
        "[2, 0, 9, 1]",
        "model.regions.cheese: box [2, 0, 9, 1] reaches outside the grid of 4 x 3 cells",
    ),
    (
        GRID,
        "size = [4, 3]",
        'size = "4x3"',
        "model.size: must be [width, height] in cells, not '4x3'",
    ),
    (
        GRID,
        "start = [0, 0]",
        'start = "cheese"',
        "model.start: must be [x, y], the cell where the robot starts, not 'cheese'",
    ),
    (
        GRID,
        "start = [0, 0]\n",
        "",
        "model.start: missing; expected [x, y], the cell where the robot starts",
    ),
    (
        GRID,
        "cost = 1",
        'cost = "1"',
        "model.cost: must be a number, not '1'",
    ),
    (
        GRID,
        'kind = "grid"\n',
        "",
        "model.kind: missing (valid: graph, grid, manipulation)",
    ),
    (
        GRID,
        "F cheese",
        "F chees",
        "tasks[0].formula: unknown proposition 'chees' (did you mean 'cheese'?), at column 3",
    ),
    (
        GRID,
        "F cheese",
        "G cheese",
        "tasks[0].formula: not co-safe: 'G cheese' must hold for ever, which no finite plan shows; "
        "write the rule 'G cheese', at column 1",
    ),
    (
        GRID,
        '"F cheese"',
        "F cheese",
        'not TOML: Invalid value (at line 15, column 11); text is written in "quotes"',
    ),
    (
        GRID,
        "start = [0, 0]",
        "start = [.5, 0]",
        "not TOML: Invalid value (at line 5, column 10); a number has a digit before its point, such as 0.5",
    ),
    (
        GRID,
        "F cheese",
        "",
        "tasks[0].formula: expected a formula, but the formula ends, at column 1",
    ),
    (
        GRID,
        'name = "bake"',
        'name = "bake it"',
        "tasks[1].name: 'bake it' is not a name (a to z, A to Z, 0 to 9 and _, not starting with a digit)",
    ),
    (
        GRID,
        'formula = "F cheese"',
        'goal = "F cheese"',
        "tasks[0].goal: unknown key (valid: name, formula, relax, skip, label)",
    ),
    (
        GRID,
        'formula = "F cheese"',
        'formula = "F cheese"\nrelax = { assume = "cheese" }',
        'tasks[0].relax: must be a list such as [{ assume = "p", when = "q", cost = 1 }], not { assume = \'cheese\' }',
    ),
    (
        GRAPH,
        's2 = ["plant"]',
        's2 = "plant"',
        "model.labels.s2: must be a list of propositions, such as [\"shelf\"], not 'plant'",
    ),
    (
        GRAPH,
        '{ from = "s0", to = "s1", action = "east", cost = 1 }',
        '["s0", "s1", 1]',
        'model.transitions: must be a list such as [{ from = "a", to = "b", cost = 1 }], not [[\'s0\', '
        "'s1', 1], { from = 's1', to = 's2', cost = 0.5 }]",
    ),
    (
        TABLE,
        "[0.50, 0.03]",
        '"0.6 0.1"',
        "model.locations.left.at: must be [x, y] or [x, y, height] in metres, not '0.6 0.1'",
    ),
    (
        TABLE,
        "[0.50, 0.03]",
        "[0.50]",
        "model.locations.left.at: must be [x, y] or [x, y, height] in metres, not [0.5]",
    ),
    (
        TABLE,
        "[model.objects]\n",
        '[model.objects]\ngreen = "left"\n',
        "model.objects.green: must be a table (valid: start, fixed, rgba, kind, size, file, scale, "
        "body, mass, label), not 'left'",
    ),
    (
        TABLE,
        "[model.locations]\n",
        "[model.locations]\nspot = [0.4, 0.2]\n",
        "model.locations.spot: must be a table (valid: at, site, on, capacity, marks, kind, label), not [0.4, 0.2]",
    ),
]
"""The text of a file, what is changed, to what, and the message."""

WRONG = "Invalid value for"

LONG = "x" * 300
"""Longer than any name of a file."""

IN_OPTIONS = [
    ("front", "prefplan front: Missing argument 'SCENARIO'."),
    (
        "front nope",
        "prefplan: no scenario named 'nope' ships or is in this folder (valid: case_study_1, "
        "case_study_2, case_study_2_skip20, case_study_3, case_study_3_energy, city, clutter, example, "
        "kitchen, kitchen_energy, rover, shelf, tidy, tower)",
    ),
    ("front tidy.tml", "prefplan: tidy.tml: no such file (did you mean 'tidy.toml'?)"),
    ("front tidy.toml extra", "prefplan front: Got unexpected extra argument (extra)"),
    ("frnt tidy.toml", "prefplan: No such command 'frnt'. Did you mean 'front'?"),
    ("front tidy.toml --jsn", "prefplan front: No such option '--jsn'. Did you mean '--json'?"),
    ("front tidy.toml --max-cost", "prefplan front: Option '--max-cost' requires an argument."),
    ("front tidy.toml --max-cost ten", f"prefplan front: {WRONG} '--max-cost': 'ten' is not a number >= 0"),
    (
        "front tidy.toml --max-seconds 1m",
        f"prefplan front: {WRONG} '--max-seconds': '1m' is not a number of seconds >= 0",
    ),
    (
        "front tidy.toml --max-memory 4GB",
        f"prefplan front: {WRONG} '--max-memory': '4GB' is not a number of MiB >= 0",
    ),
    (
        "front tidy.toml --at-most energy",
        f"prefplan front: {WRONG} '--at-most': 'energy' is not NAME=VALUE, such as energy=40",
    ),
    ("front tidy.toml --at-most enrgy=3", "prefplan: --at-most: unknown objective 'enrgy' (valid: cost, preference)"),
    ("front tidy.toml --objective costs", "prefplan: --objective: unknown objective 'costs' (did you mean 'cost'?)"),
    (
        "front tidy.toml --plot a.gif",
        "prefplan: a.gif: pictures are written to files that end in .png, .svg, .pdf, not '.gif'",
    ),
    (
        "plan tidy.toml --plan best",
        f"prefplan plan: {WRONG} '--plan': 'best' is no plan: a number from 0, or one of cost, preference, cheapest, "
        "preferred",
    ),
    ("plan tidy.toml --plan 99", "prefplan: --plan 99: the front has one plan, 0"),
    (
        "run tidy.toml",
        "prefplan: tidy.toml: model.kind: only a manipulation model can be carried out; try `prefplan "
        "front` or `prefplan plan` with this scenario",
    ),
    ("automaton 'F(a'", "prefplan: '(' is never closed, at column 2"),
    (
        "draw tidy.toml a.png",
        f"prefplan draw: {WRONG} 'WHAT': 'tidy.toml' is not one of 'plans', 'automata'.",
    ),
    (
        "init tidy --kind gird",
        f"prefplan init: {WRONG} '--kind': 'gird' is not one of 'grid', 'manipulation', 'graph'.",
    ),
    ("init ''", "prefplan: .: is a folder; name a file"),
    ("front .", "prefplan: .: cannot be read (Is a directory)"),
    # The operating system will not even look at a path like this one; nor at one in a folder that may not be read.
    (f"front {LONG}.toml", f"prefplan: {LONG}.toml: cannot be read (File name too long)"),
    (f"init {LONG}", f"prefplan: {LONG}.toml: cannot be written (File name too long)"),
    (f"export {LONG}.npz --to glb", f"prefplan: {LONG}.npz: broken, or not a log of `prefplan run`"),
]
"""The arguments of the program, and the message; `tidy.toml` is a grid."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("text", "old", "new", "message"), IN_FILES)
def test_a_mistake_in_a_file_gets_its_message(
    text: str, old: str, new: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert old in text
    (folder / "tidy.toml").write_text(text.replace(old, new))
    result = call(capsys, "--quiet", "front", "tidy.toml")
    assert (result.status, result.out) == (2, "")
    assert result.err.partition("\n")[0] == f"prefplan: tidy.toml: {message}"


@pytest.mark.parametrize(("arguments", "message"), IN_OPTIONS)
def test_a_mistake_in_options_gets_its_message(
    arguments: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "tidy.toml").write_text(GRID)
    result = call(capsys, "--quiet", *shlex.split(arguments))
    assert (result.status, result.out) == (2, "")
    assert result.err.partition("\n")[0] == message
    assert "usage: " not in result.err


@pytest.mark.parametrize(("word", "name"), [("cheapest", "cost"), ("preferred", "preference")])
def test_the_words_for_the_ends_of_a_front_name_plans(
    word: str, name: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(capsys, "plan", "example", "--plan", word) == call(capsys, "plan", "example", "--plan", name)


def test_the_tables_have_fifty_mistakes_and_more() -> None:
    assert len({*map(str, IN_FILES), *map(str, IN_OPTIONS)}) == len(IN_FILES) + len(IN_OPTIONS) >= 50
