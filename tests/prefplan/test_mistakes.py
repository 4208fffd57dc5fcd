"""Natural mistakes in Python: each has a message that says what is wrong, where, and what would be right."""

from __future__ import annotations

from typing import Any

import networkx as nx
import pytest

import prefplan

TASKS = {"stock": "F shelf"}


def aisle() -> nx.DiGraph:
    graph = nx.DiGraph()
    for place in ("dock", "shelf"):
        graph.add_node(place, labels=[place])
    graph.add_edge("dock", "shelf", cost=3)
    return graph


def with_edge(**attributes: Any) -> nx.DiGraph:
    graph = aisle()
    graph.add_edge("shelf", "door", **attributes)
    return graph


def with_labels(labels: Any) -> nx.DiGraph:
    graph = aisle()
    graph.nodes["dock"]["labels"] = labels
    return graph


def problem(graph: Any = None, tasks: Any = TASKS, preference: Any = None, **more: Any) -> prefplan.Problem:
    wanted = prefplan.Order() if preference is None else preference
    return prefplan.Problem(graph or aisle(), tasks, wanted, start="dock", **more)


NAMES = {name: getattr(prefplan, name) for name in prefplan.__all__} | {
    "prefplan": prefplan,
    "graph": aisle(),
    "grid": prefplan.GridModel((3, 3), (0, 0), regions={"desk": [(2, 2, 2, 2)]}),
    "TASKS": TASKS,
    "problem": problem,
    "with_edge": with_edge,
    "with_labels": with_labels,
}

MISTAKES = [
    (
        "pareto_front(graph)",
        "problem: must be a Problem, a scenario, or the name or path of one, not a DiGraph; "
        "Problem(system, tasks, preference) makes one",
    ),
    (
        "pareto_front(None)",
        "problem: must be a Problem, a scenario, or the name or path of one, not None; Problem(system, "
        "tasks, preference) makes one",
    ),
    (
        'pareto_front("case_study_4")',
        "no scenario named 'case_study_4' ships or is in this folder (did you mean 'case_study_3'?)",
    ),
    (
        'load("no/such.toml")',
        "no/such.toml: no such file",
    ),
    (
        'load("case_study_3.toml")',
        "case_study_3.toml: no such file (one of this name ships: 'case_study_3')",
    ),
    (
        "load(3)",
        "a scenario is loaded by its name or path, not 3 (int)",
    ),
    (
        "prefplan.paretofront",
        "module 'prefplan' has no attribute 'paretofront' (did you mean 'pareto_front'?)",
    ),
    (
        "Problem(graph, TASKS, Order())",
        "start: missing; it is the graph's initial node, as in Problem(..., start='dock')",
    ),
    (
        'Problem(graph, TASKS, Order(), start="dok")',
        "start 'dok' is not a node of the graph (did you mean 'dock'?)",
    ),
    (
        'Problem(grid, {"go": "F desk"}, Order(), start=(0, 0))',
        "start: only for a networkx graph; a model or transition system has its own",
    ),
    (
        'Problem("tidy", TASKS, Order())',
        "system: must be a TransitionSystem, a model such as GridModel, or a networkx graph, not 'tidy' (str)",
    ),
    (
        'Problem(load("example"), TASKS, Order())',
        "system: must be a TransitionSystem, a model such as GridModel, or a networkx graph, not a Scenario",
    ),
    (
        "Problem(GridModel, TASKS, Order())",
        "system: must be a TransitionSystem, a model such as GridModel, or a networkx graph, not the class GridModel",
    ),
    (
        "problem(graph=with_edge(weight=2))",
        "edge 'shelf' to 'door': has a 'weight' but no 'cost'; name it 'cost'",
    ),
    (
        'problem(graph=with_edge(cost="3"))',
        "action 'door' from state 'shelf': must be a number, not '3'",
    ),
    (
        "problem(graph=with_edge(cost=-1))",
        "action 'door' from state 'shelf': negative cost -1",
    ),
    (
        'problem(graph=with_labels("dock"))',
        "label on state 'dock': must be a list such as ['dock'], not the string 'dock'",
    ),
    (
        "problem(graph=with_labels(None))",
        "label on state 'dock': must be a list such as ['p'], not None",
    ),
    (
        'problem(tasks="F shelf")',
        'tasks: must be formulas by name, such as {"NAME": "F p"}, or a list such as [Task("NAME", "F '
        "p\")], not 'F shelf' (str)",
    ),
    (
        'problem(tasks=["F shelf"])',
        'tasks[0]: must be a Task, such as Task("NAME", "F p"), not \'F shelf\' (str)',
    ),
    (
        'problem(tasks=Task("stock", "F shelf"))',
        'tasks: must be formulas by name, such as {"NAME": "F p"}, or a list such as [Task("NAME", "F p")], not a Task',
    ),
    (
        'problem(tasks={"stock": Task("stock", "F shelf")})',
        'tasks[0].formula: must be text, such as "F p", not a Task',
    ),
    (
        "problem(tasks={})",
        "tasks: a problem needs at least one task",
    ),
    (
        'problem(tasks={"stock": "F shel"})',
        "tasks[0].formula: unknown proposition 'shel' (did you mean 'shelf'?), at column 3",
    ),
    (
        'problem(tasks={"stock": "G shelf"})',
        "tasks[0].formula: not co-safe: 'G shelf' must hold for ever, which no finite plan shows; write "
        "the rule 'G shelf', at column 1",
    ),
    (
        'problem(tasks={"stock": "F (shelf"})',
        "tasks[0].formula: '(' is never closed, at column 3",
    ),
    (
        'problem(tasks={"stock it": "F shelf"})',
        "tasks[0].name: 'stock it' is not a name (a to z, A to Z, 0 to 9 and _, not starting with a digit)",
    ),
    (
        'problem(tasks=[Task("stock", "F shelf", skip=3)])',
        'tasks[0].skip: no term of the preference depends on this price; add a term with over = "violation"',
    ),
    (
        'problem(rules="G !dock")',
        'rules: must be formulas by name, such as {"NAME": "F p"}, or a list such as [Rule("NAME", "G '
        "!p\")], not 'G !dock' (str)",
    ),
    (
        "problem(preference=())",
        'preference: missing, such as Order(), WeightedSum({"TASK": 1}) or Function(f); it may be left '
        "out only if there are several costs",
    ),
    (
        "problem(preference=Order)",
        'preference: must be a preference, such as Order(), WeightedSum({"TASK": 1}) or Function(f), '
        "not the class Order",
    ),
    (
        'problem(preference="order")',
        'preference: must be a preference, such as Order(), WeightedSum({"TASK": 1}) or Function(f), '
        "not 'order' (str)",
    ),
    (
        'problem(preference={"stock": 1})',
        'preference: must be a preference, such as Order(), WeightedSum({"TASK": 1}) or Function(f), '
        "not {'stock': 1} (dict)",
    ),
    (
        "problem(preference=[Order()])",
        "preference[0]: must be like NamedPreference('NAME', Order()), not Order(order=None) (Order); a "
        'preference alone needs no list, such as Order(), WeightedSum({"TASK": 1}) or Function(f)',
    ),
    (
        'problem(preference=Order("stock"))',
        'preference.order: must be a list such as ["TASK1", "TASK2"], not \'stock\' (str)',
    ),
    (
        'problem(preference=Order(["stok"]))',
        "preference.order: unknown task 'stok' (did you mean 'stock'?)",
    ),
    (
        "problem(preference=WeightedSum([1]))",
        'preference.weights: must be weights by task, such as {"TASK": 2}, not [1] (list)',
    ),
    (
        'problem(preference=WeightedSum({"stock": "1"}))',
        "preference.weights: must be weights by task, such as {\"TASK\": 2}, not {'stock': '1'} (dict)",
    ),
    (
        'problem(preference=Deadline({"stock": 20}))',
        "preference.deadlines.stock: must be a deadline such as Due(by=20, weight=1), not 20 (int)",
    ),
    (
        'problem(preference=Expression("stock - 20"))',
        "preference.expression: must not be negative, but is -20 at (stock=0); write max(0, ...)",
    ),
    (
        "problem(preference=Function(lambda costs: costs[0]))",
        "preference.function: fails at (stock=0): <lambda>() takes 1 positional argument but 2 were "
        "given (it gets two arrays, costs and violations, in the order of the tasks, and returns a "
        "number)",
    ),
    (
        "problem(preference=Sum([Order(), Max()]))",
        "preference.parts: must be pairs of a preference and its weight, such as [(Order(), 1), (Max(), "
        "2)], not a list",
    ),
    (
        "pareto_front(problem(), max_costs=3)",
        "max_costs: no limit of a search (did you mean 'max_cost'?)",
    ),
    (
        'pareto_front(problem(), max_cost="3")',
        "max_cost: must be a number, not '3'",
    ),
    (
        'pareto_front(problem(), max_seconds="3")',
        "max_seconds: must be a number >= 0, not '3' (str)",
    ),
    (
        'pareto_front(problem(), at_most=["cost", 3])',
        "at_most: must be bounds by name, such as {'cost': 40}, not ['cost', 3] (list)",
    ),
    (
        "pareto_front(problem(preference=Function(lambda costs, paid: costs[0])))",
        "preference: its contract is 'general', so that its front may be infinite; a bound on the total "
        "cost is needed (--max-cost C, in Python max_cost=C)",
    ),
    (
        'best_plan(problem(), "costs")',
        "unknown objective 'costs' (did you mean 'cost'?)",
    ),
    (
        "cheapest_plan(problem(), max_cost=1)",
        "no plan lies within the bound; the smallest possible is 3",
    ),
    (
        'Planner(problem()).front(over=["cost", "costs"])',
        "unknown objective 'costs' (did you mean 'cost'?)",
    ),
    (
        'pareto_front(problem()).over(["costs"])',
        "over: unknown objective 'costs' (did you mean 'cost'?)",
    ),
    (
        "problem(preference=Sum(((Order, 1),)))",
        "preference.parts: must be pairs of a preference and its weight, such as [(Order(), 1), (Max(), 2)], "
        "not a tuple",
    ),
    (
        "pareto_front(problem())[5]",
        "plan 5: the front has 1, counted from 0",
    ),
    (
        "GridModel(3, (0, 0))",
        "size: must be (width, height) in cells, not 3 (int)",
    ),
    (
        "GridModel((3, 3), (3, 3))",
        "start: [3, 3] lies outside the grid of 3 x 3 cells",
    ),
    (
        'GridModel((3, 3), (0, 0), regions={"desk": (2, 2, 2, 2)})',
        "regions.desk: must be a list of boxes [(x0, y0, x1, y1), ...], not (2, 2, 2, 2) (tuple)",
    ),
    (
        'GridModel((3, 3), (0, 0), regions={"desk": [(2, 2)]})',
        "regions.desk: must be a list of boxes [(x0, y0, x1, y1), ...], not [(2, 2)] (list)",
    ),
    (
        'GraphModel("dock", [("dock", "shelf")])',
        "transitions: must be a tuple such as (Transition(\"a\", \"b\", cost=1),), not [('dock', 'shelf')] (list)",
    ),
    (
        'GraphModel("dock", (Transition("dock", "shelf", {"time": 1}, "go"),))',
        "transitions[0].action: must be a string, not {'time': 1} (dict)",
    ),
    (
        'TransitionSystem.from_transitions([("dock", "go", "shelf")], start="dock")',
        "transitions[0]: must be (source, action, target, cost), not ('dock', 'go', 'shelf') (tuple)",
    ),
    (
        'automaton(Task("stock", "F shelf"))',
        'a formula must be text, such as "F p", not a Task',
    ),
]


@pytest.mark.parametrize(("mistake", "message"), MISTAKES, ids=[mistake for mistake, _ in MISTAKES])
def test_a_mistake_gets_its_message(mistake: str, message: str) -> None:
    with pytest.raises((prefplan.PrefplanError, IndexError, AttributeError)) as caught:
        eval(mistake, dict(NAMES))
    assert str(caught.value).partition("\n")[0] == message


def test_the_table_has_forty_mistakes_and_more() -> None:
    assert len({mistake for mistake, _ in MISTAKES}) == len(MISTAKES) >= 40
