"""Scenario files: what they become, and a message with file, key and what would be valid for all that is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from prefplan import (
    Deadline,
    Due,
    GridModel,
    Location,
    ManipulationModel,
    NoPlanError,
    Object,
    Order,
    PrefplanError,
    Problem,
    ScenarioError,
    Task,
    TransitionSystem,
    WeightedSum,
    cheapest_plan,
    load,
    pareto_front,
)

GRID = """
[model]
kind = "grid"
size = [4, 3]
start = [0, 0]
cost = 1
[model.regions]
cheese = [2, 0, 3, 1]
pizza = [[0, 2, 0, 2], [3, 2, 3, 2]]
[model.obstacles]
wall = [1, 1, 1, 2]

[[tasks]]
name = "eat"
formula = "F cheese"

[[tasks]]
name = "bake"
formula = "!cheese U pizza"

[preference]
kind = "order"
order = ["bake", "eat"]
"""

GRAPH = """
[model]
kind = "graph"
start = "s0"
propositions = ["rock"]
transitions = [
  { from = "s0", to = "s1", action = "east", cost = 1 },
  { from = "s1", to = "s2", cost = 0.5 },
]
[model.labels]
s2 = ["plant"]

[[tasks]]
name = "phi1"
formula = "F plant"

[preference]
kind = "weighted-sum"
weights = { phi1 = 0.1 }
"""

TABLE = """
[model]
kind = "manipulation"
start = "home"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
[model.locations]
left = { at = [0.50, 0.03] }
right = { at = [0.50, -0.03] }
top = { on = ["left", "right"] }
san = { at = [0.45, 0.30], marks = "clean" }
bin = { at = [0.40, -0.30], capacity = 2, kind = "bin" }
[model.objects]
blue = { start = "left", rgba = [0.1, 0.3, 0.9, 1] }
pink = { start = "right", fixed = false }

[[tasks]]
name = "phi1"
formula = "F (blue_clean & blue_bin)"

[preference]
kind = "deadline"
deadlines = { phi1 = { by = 20, weight = 2 } }
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "case.toml"


def error_of(file: Path, text: str) -> str:
    """Return the first line of the error that a scenario makes, without the file's name, which must come first."""
    file.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load(file).problem()
    first = str(caught.value).split("\n")[0]
    assert first.startswith(f"{file}: ")
    return first.removeprefix(f"{file}: ")


def with_change(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


def test_a_grid_scenario(file: Path) -> None:
    file.write_text(GRID)
    scenario = load(file)
    assert (scenario.name, scenario.path) == ("case", file)
    assert scenario.model == GridModel(
        (4, 3),
        (0, 0),
        1,
        regions={"cheese": ((2, 0, 3, 1),), "pizza": ((0, 2, 0, 2), (3, 2, 3, 2))},
        obstacles={"wall": ((1, 1, 1, 2),)},
    )
    assert scenario.tasks == (Task("eat", "F cheese"), Task("bake", "!cheese U pizza"))
    assert scenario.preference == Order(("bake", "eat"))
    assert [(plan.cost, plan.preference) for plan in pareto_front(scenario.problem())] == [(6, 0)]


def test_a_graph_scenario(file: Path) -> None:
    file.write_text(GRAPH)
    scenario = load(str(file))
    assert scenario.problem().system.propositions == {"plant", "rock"}
    plan = cheapest_plan(scenario.problem())
    assert (plan.cost, plan.preference, plan.actions) == (1.5, 0.15, ("east", "s2"))
    assert isinstance(scenario.preference, WeightedSum)


def test_a_manipulation_scenario(file: Path) -> None:
    file.write_text(TABLE)
    scenario = load(file)
    assert isinstance(scenario.model, ManipulationModel)
    assert scenario.model.locations == (
        Location("left", at=(0.50, 0.03)),
        Location("right", at=(0.50, -0.03)),
        Location("top", on=("left", "right")),
        Location("san", at=(0.45, 0.30), marks="clean"),
        Location("bin", at=(0.40, -0.30), capacity=2, kind="bin"),
    )
    assert scenario.model.objects == (Object("blue", "left", rgba=(0.1, 0.3, 0.9, 1)), Object("pink", "right"))
    assert scenario.preference == Deadline({"phi1": Due(20, 2)})
    assert cheapest_plan(scenario.problem()).cost == 3 + 1 + 5 + 1 + 1 + 5 + 1


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        (GRID, "cost = 1\n", ""),
        (GRID, 'order = ["bake", "eat"]\n', ""),
        (GRID, '["bake", "eat"]', '[["eat", "bake"]]'),
        (GRID, "[model.obstacles]\nwall = [1, 1, 1, 2]\n", ""),
        (GRID, "wall = [1, 1, 1, 2]", "true = [1, 1, 1, 2]"),
        (GRAPH, ', action = "east", cost = 1', ""),
        (GRAPH, 'propositions = ["rock"]\n', ""),
        (GRAPH, "F plant", "F (plant & !rock)"),
        (TABLE, 'start = "home"', 'start = "the parking pose"'),
        (TABLE, 'start = "home"', 'start = "san"'),
        (TABLE, ", weight = 2", ""),
        (TABLE, "phi1 = { by = 20, weight = 2 }", ""),
    ],
)
def test_what_may_be_left_out_or_said_otherwise(file: Path, text: str, old: str, new: str) -> None:
    file.write_text(with_change(text, old, new))
    assert pareto_front(load(file).problem())


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GRID, "cost = 1", "cots = 1", "model.cots: unknown key (did you mean 'cost'?)"),
        (GRID, "[model.regions]", "[model.region]", "model.region: unknown key (did you mean 'regions'?)"),
        (GRID, 'name = "eat"', 'nmae = "eat"', "tasks[0].nmae: unknown key (did you mean 'name'?)"),
        (GRID, "[preference]", "[preferences]", "preferences: unknown key (did you mean 'preference'?)"),
        (GRID, "[model]", 'title = "x"\n[model]', "title: unknown key (valid: model, tasks, preference)"),
        (GRAPH, "cost = 1", "cots = 1", "model.transitions[0].cots: unknown key (did you mean 'cost'?)"),
        (GRAPH, 'to = "s2"', 'too = "s2"', "model.transitions[1].too: unknown key (did you mean 'to'?)"),
        (TABLE, 'marks = "clean"', 'mark = "x"', "model.locations.san.mark: unknown key (did you mean 'marks'?)"),
        (TABLE, "fixed = false", "fixd = 1", "model.objects.pink.fixd: unknown key (did you mean 'fixed'?)"),
        (TABLE, "by = 20", "until = 20", "preference.deadlines.phi1.until: unknown key (valid: by, weight)"),
        (TABLE, "release = 1", "releese = 1", "model.costs: unknown action 'releese' (did you mean 'release'?)"),
    ],
)
def test_an_unknown_key_is_named_with_the_nearest_known(
    file: Path, text: str, old: str, new: str, message: str
) -> None:
    assert error_of(file, with_change(text, old, new)) == message


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GRID, 'kind = "grid"', 'kind = "gird"', "model.kind: unknown kind 'gird' (did you mean 'grid'?)"),
        (GRID, 'kind = "grid"', 'kind = "3d"', "model.kind: unknown kind '3d' (valid: graph, grid, manipulation)"),
        (GRID, 'kind = "grid"\n', "", "model.kind: missing (valid: graph, grid, manipulation)"),
        (GRID, 'kind = "order"', 'kind = "ordr"', "preference.kind: unknown kind 'ordr' (did you mean 'order'?)"),
    ],
)
def test_an_unknown_kind_is_named_with_the_valid_ones(file: Path, text: str, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(text, old, new)) == message


TASKS = GRID[GRID.index("[[tasks]]") : GRID.index("[preference]")]


@pytest.mark.parametrize(
    ("text", "old", "key"),
    [
        (GRID, "size = [4, 3]\n", "model.size"),
        (GRID, "start = [0, 0]\n", "model.start"),
        (GRID, 'name = "bake"\n', "tasks[1].name"),
        (GRID, 'formula = "F cheese"\n', "tasks[0].formula"),
        (GRID, TASKS, "tasks"),
        (GRID, GRID[GRID.index("[preference]") :], "preference"),
        (GRID, GRID[: GRID.index("[[tasks]]")], "model"),
        (GRAPH, 'start = "s0"\n', "model.start"),
        (GRAPH, 'from = "s1", ', "model.transitions[1].from"),
        (GRAPH, "weights = { phi1 = 0.1 }\n", "preference.weights"),
        (TABLE, 'start = "left", ', "model.objects.blue.start"),
        (TABLE, "by = 20, ", "preference.deadlines.phi1.by"),
    ],
)
def test_a_missing_key_is_named(file: Path, text: str, old: str, key: str) -> None:
    assert error_of(file, with_change(text, old, "")) == f"{key}: missing"


def test_a_missing_kind_of_preference_comes_with_the_valid_ones(file: Path) -> None:
    message = error_of(file, with_change(GRID, 'kind = "order"\n', ""))
    assert message.startswith("preference.kind: missing (valid: order, weighted-sum, ")


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GRID, "cost = 1", 'cost = "one"', "model.cost: must be a number, not 'one'"),
        (GRID, "cost = 1", "cost = true", "model.cost: must be a number, not True"),
        (GRID, "size = [4, 3]", "size = 4", "model.size: should be a valid list"),
        (GRID, "start = [0, 0]", "start = [0]", "model.start: too few entries, at least 2 are needed"),
        (GRID, "start = [0, 0]", "start = [0.5, 0]", "model.start[0]: should be a valid integer"),
        (GRID, "[2, 0, 3, 1]", '"all"', "model.regions.cheese: should be a valid list"),
        (GRID, "[2, 0, 3, 1]", "[[2, 0, 3, 1], 5]", "model.regions.cheese[1]: should be a valid list"),
        (GRID, 'name = "bake"', "name = 3", "tasks[1].name: should be a valid string"),
        (GRID, 'formula = "F cheese"', "formula = 3", "tasks[0].formula: should be a valid string"),
        (GRID, '["bake", "eat"]', '"bake"', "preference.order: should be a valid list"),
        (GRID, TASKS, '[tasks]\neat = "F cheese"\n', "tasks: should be a valid list"),
        (GRAPH, 'to = "s1"', "to = 1", "model.transitions[0].to: should be a valid string"),
        (GRAPH, 's2 = ["plant"]', 's2 = "plant"', "model.labels.s2: should be a valid list"),
        (GRAPH, 'propositions = ["rock"]', 'propositions = "rock"', "model.propositions: should be a valid list"),
        (GRAPH, "phi1 = 0.1", 'phi1 = "1"', "preference.weights.phi1: must be a number, not '1'"),
        (TABLE, "release = 1", 'release = "x"', "model.costs.release: must be a number, not 'x'"),
        (TABLE, 'on = ["left", "right"]', 'on = "left"', "model.locations.top.on: should be a valid list"),
        (TABLE, "capacity = 2", "capacity = 1.5", "model.locations.bin.capacity: should be a valid integer"),
        (TABLE, "fixed = false", "fixed = 0", "model.objects.pink.fixed: should be a valid boolean"),
        (TABLE, "[0.1, 0.3, 0.9, 1]", '"blue"', "model.objects.blue.rgba: should be a valid list"),
        (TABLE, "[0.50, 0.03]", "[0.50]", "model.locations.left.at: too few entries, at least 2 are needed"),
        (TABLE, "[0.50, 0.03]", '[0.50, "0"]', "model.locations.left.at[1]: must be a number, not '0'"),
    ],
)
def test_a_wrong_type_is_named_with_the_right_one(file: Path, text: str, old: str, new: str, message: str) -> None:
    assert error_of(file, with_change(text, old, new)) == message


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


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="nowhere.toml: no such file$"):
        load(tmp_path / "nowhere.toml")


def test_a_folder_is_no_scenario(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="cannot be read"):
        load(tmp_path)


@pytest.mark.parametrize("content", [b"size = [4, 3", b"size = 1\nsize = 2", b"\xff\xfe", b"F cheese"])
def test_a_file_that_is_not_toml(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    with pytest.raises(ScenarioError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}: not TOML: ")


def test_an_empty_file_misses_its_first_key(file: Path) -> None:
    assert error_of(file, "") == "model: missing"


@pytest.mark.parametrize(
    ("text", "old", "new", "sentence"),
    [
        (GRAPH, "F plant", "F rock", "task phi1 can never be satisfied"),
        (GRAPH, "F plant", "plant", "task phi1 can never be satisfied"),
        (GRID, "[[0, 2, 0, 2], [3, 2, 3, 2]]", "[3, 0, 3, 0]", "task bake can never be satisfied"),
        (TABLE, "F (blue_clean & blue_bin)", "F (blue_top & blue_bin)", "task phi1 can never be satisfied"),
        (
            GRID,
            "F cheese",
            "!pizza U cheese",
            "tasks eat, bake cannot be satisfied together, though any fewer of them can",
        ),
    ],
)
def test_tasks_that_can_never_be_satisfied_are_blamed(file: Path, text: str, old: str, new: str, sentence: str) -> None:
    file.write_text(with_change(text, old, new))
    problem = load(file).problem()
    with pytest.raises(NoPlanError) as caught:
        cheapest_plan(problem)
    assert str(caught.value) == str(pareto_front(problem).reason) == sentence


def test_all_errors_have_one_root() -> None:
    assert issubclass(ScenarioError, PrefplanError)
    assert issubclass(NoPlanError, PrefplanError)


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
