"""Graphs from files equal the same graph given explicitly, in every format."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from graph_writers import WRITERS, dimacs, states_of
from hypothesis import example, given
from hypothesis import strategies as st
from judge.random_problems import random_problem

from prefplan import ModelError, Scenario, ScenarioError, TransitionSystem, pareto_front
from prefplan.errors import LimitError
from prefplan.exact_costs import common_unit, exact, in_common_unit, in_units
from prefplan.limits import CLOCK_PERIOD, Limits
from prefplan.models.graph_file import GraphFileModel
from prefplan.scenario.decode import from_dict


def described(system: TransitionSystem, name: Callable[[Any], str]) -> tuple[dict, Counter]:
    """Return the labels of a system's states and its edges, with states renamed."""
    names = [name(state) for state in system.states]
    labels = {names[state]: system.label(state) for state in range(system.size)}
    edges = Counter(
        (names[state], names[system.targets[edge]], system.cost(edge))
        for state in range(system.size)
        for edge in system.edges(state)
    )
    return labels, edges


def edges_of(system: TransitionSystem) -> list[tuple[Any, ...]]:
    """Return the source, the target and the costs of every edge of a system whose states are numbers."""
    found = []
    for state in range(system.size):
        for edge in system.edges(state):
            costs = (int(each.entries[edge] * each.unit) for each in system.costs)
            found.append((int(system.states[state]), int(system.states[system.targets[edge]]), *costs))
    return found


def points(scenario: Scenario) -> list[tuple[Any, Any]]:
    return [(plan.cost, plan.preference) for plan in pareto_front(scenario.problem())]


def without_parallel_edges(model: dict[str, Any]) -> dict[str, Any]:
    """Return a model with only the first edge between each two states, as files may lose parallel edges."""
    first = {(edge["from"], edge["to"]): edge for edge in reversed(model["transitions"])}
    return {**model, "transitions": list(first.values())[::-1]}


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
def test_limits_hold_while_nodes_and_edges_are_read(tmp_path: Path, write: Callable) -> None:
    model = random_problem(0).scenario()["model"]
    written = write(model, tmp_path)
    with Limits(seconds=0), pytest.raises(LimitError):
        GraphFileModel(tmp_path, **{"start": 1, **written}).network  # noqa: B018


def test_limits_hold_while_the_nodes_before_the_edges_are_passed_over(tmp_path: Path) -> None:
    (tmp_path / "town.json").write_text('{"edges": [], "nodes": [{"id": 1}, {"id": 2}, {"id": 3}, {"id": }]}')
    with Limits(seconds=0), pytest.raises(LimitError):
        GraphFileModel(tmp_path, "town.json", start=1).network  # noqa: B018


@pytest.mark.parametrize("write", WRITERS, ids=lambda write: write.__name__)
@pytest.mark.parametrize("seed", range(12))
def test_a_graph_read_from_a_file_is_the_one_written_out(tmp_path: Path, write: Callable, seed: int) -> None:
    table = random_problem(seed, decimals=seed % 3).scenario()
    model = table["model"] = without_parallel_edges(table["model"])
    if not model["transitions"]:
        model["transitions"] = [{"from": model["start"], "to": model["start"], "cost": 1}]
    model["labels"] = {state: names for state, names in model["labels"].items() if state in states_of(model)}
    model["propositions"] = ["a", "b", "c"]
    written = write(model, tmp_path)
    kept = {key: model[key] for key in ("kind", "start", "propositions")}
    read = from_dict({**table, "model": {**kept, **written}}, path=tmp_path / "town.toml")
    listed = from_dict(table)
    by_number = dict(enumerate(states_of(model), start=1))
    rename = (lambda state: by_number[int(state)]) if write is dimacs else str
    assert described(read.problem().system, rename) == described(listed.problem().system, str)
    units = [[table.unit for table in one.problem().system.costs] for one in (read, listed)]
    assert units[0] == units[1]
    assert points(read) == points(listed)


def read(tmp_path: Path, text: str | bytes, file: str = "town.csv", **keys: Any) -> TransitionSystem:
    (tmp_path / file).write_bytes(text.encode() if isinstance(text, str) else text)
    return GraphFileModel(tmp_path, file, keys.pop("start", "a"), **keys).transition_system()


def test_parallel_edges_have_actions_of_their_own(tmp_path: Path) -> None:
    text = "from,to,action,cost\na,b,,2\na,b,,3\na,b,,2\na,b,tram,2\nb,a,,1\na,b,tram,2\na,c,,9\n"
    system = read(tmp_path, text)
    actions = [system.action_names[system.actions[edge]] for edge in system.edges(0)]
    assert actions == ["b", "b#2", "b#3", "tram", "tram#2", "c"]
    assert [system.step(0, action) for action in actions] == [(1, 2), (1, 3), *[(1, 2)] * 3, (2, 9)]


@pytest.mark.parametrize("ending", ["graphml", "json"])
def test_undirected_edges_lead_both_ways(tmp_path: Path, ending: str) -> None:
    texts = {
        "graphml": '<graphml><key id="d" for="edge" attr.name="cost"><default>4</default></key>'
        '<graph edgedefault="undirected"><node id="a"/><node id="b"/><edge source="a" target="b"/></graph></graphml>',
        "json": '{"directed": false, "nodes": [{"id": "a"}, {"id": "b"}], '
        '"edges": [{"source": "a", "target": "b", "cost": 4}]}',
    }
    system = read(tmp_path, texts[ending], f"town.{ending}")
    assert [system.step(0, "b"), system.step(1, "a")] == [(1, 4), (0, 4)]


def test_edges_without_numbers_cost_one_and_labels_of_file_and_scenario_add_up(tmp_path: Path) -> None:
    (tmp_path / "places.csv").write_text('node,x,y,labels\na,0,0,\nb,3,4,"shop, bank"\n')
    system = read(tmp_path, "from,to,name\na,b,High Street\n", nodes="places.csv", labels={"b": ["park"]})
    assert system.step(0, "b") == (1, 1)
    assert system.label(1) == {"shop", "bank", "park"}


NODE_LINK = "not node-link JSON ('nodes' with an 'id', 'edges' or 'links' with 'source' and 'target')"

GRAPHML = '<graphml><graph><node id="a"/>\n{}</graph></graphml>'


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("town.csv", "from,to,cost\na,b,1\nb,c,x\n", "line 3: edge from 'b' to 'c': cost is not a number: 'x'"),
        ("town.csv", "from,to,cost\na,b,-1\n", "line 2: edge from 'a' to 'b': cost is negative: '-1'"),
        ("town.csv", "from,to,cost\na,b,2e15\n", "line 2: edge from 'a' to 'b': cost is larger than 1e+15: '2e15'"),
        ("town.csv", "from,to,cost\na,b\n", "line 2: 2 columns, where there must be 3: from to cost"),
        ("town.csv", "source,to,cost\n", "line 1: no column 'from' (columns: source, to, cost)"),
        ("town.csv", 'from,to\na,"b\n', "line 2: not CSV: unexpected end of data"),
        ("town.csv", "from,to,action\na,b,go\na,c,go\n", "action 'go' leaves node 'a' twice, to different nodes"),
        ("town.graphml", "<graphml>\n<graph>", "line 2: not XML: no element found"),
        ("town.graphml", "<html></html>", "not GraphML: file not successfully read as graphml"),
        ("town.graphml", GRAPHML.format('<edge source="a"/>'), "not GraphML: None cannot be a node"),
        ("town.graphml", GRAPHML.format("<hyperedge/>"), "not GraphML: GraphML reader doesn't support hyperedges"),
        ("town.graphml", GRAPHML.format('<data key="d7">3</data>'), "not GraphML: Bad GraphML data: no key d7"),
        ("town.graphml", '<?xml version="1.0" encoding="no"?><graphml/>', "not GraphML: unknown encoding: no"),
        ("town.json", '{"nodes": [{"id": "1"}, {"id": 1}], "edges": []}', "node '1' occurs twice"),
        (
            "town.json",
            '{"nodes": [{"id": "a"}], "edges": [{"source": "a", "target": "z"}]}',
            "'z' is the end of an edge, but not listed as a node",
        ),
        ("town.json", '{"edges": [' + "9" * 5000 + "]}", f"{NODE_LINK}: ValueError('Exceeds the limit"),
        ("town.json", '{"nodes": [],\n "edges": [}', "line 2: not JSON: Expecting value"),
        ("town.json", '{"nodes": []}', f"{NODE_LINK}: KeyError('edges')"),
        ("town.json", '{"edges": [{"source": "a"}]}', f"{NODE_LINK}: KeyError('target')"),
        ("town.json", '{"edges": [[1, 2]]}', f"{NODE_LINK}: TypeError("),
        ("town.json", "[]", f"{NODE_LINK}: TypeError("),
        ("town.json", "[" * 100_000, f"{NODE_LINK}: RecursionError("),
        ("town.gr", "p sp 2 2\na 1 2 5\n", "must begin with 'p sp NODES ARCS', not 'p sp 2 2'; it has 1 arcs"),
        ("town.gr", "", "must begin with 'p sp NODES ARCS', not ''; it has 0 arcs"),
        ("town.gr", "c no heading\na 1 2 5\n", "must begin with 'p sp NODES ARCS', not 'a 1 2 5'; it has 0 arcs"),
        ("town.gr", "p sp 2 1\na 1 2\n", "line 2: 3 columns, where there must be 4: a from to cost"),
        ("town.gr", "p sp 2 1\nb 1 2 5\n", "line 2: must begin with 'a', not 'b'"),
        ("town.gr", "p sp 2 2\na 1 2 5\na 2 3 5\n", "line 3: node '3' is not from 1 to 2"),
        ("town.gr", "p sp 2 1\na 0 2 5\n", "line 2: node '0' is not from 1 to 2"),
        ("town.gr", "p sp x 1\na 1 2 5\n", "must begin with 'p sp NODES ARCS', not 'p sp x 1'; it has 1 arcs"),
        ("town.csv", "from,to,cost\na,b,1_0\n", "line 2: edge from 'a' to 'b': cost is not a number: '1_0'"),
        ("town.csv", "from,to,cost\n,b,1\n", "line 2: edge from '' to 'b': '' is not listed as a node"),
        ("town.gr", "c caf\xe9\np sp 0 0\n".encode("latin-1"), "cannot be read: 'utf-8' codec can't decode"),
        ("town.csv", "from,to,to\n", "line 1: two columns 'to' (columns: from, to, to)"),
        ("town.csv.gz", "from,to\n", "cannot be read: Not a gzipped file"),
    ],
)
def test_what_is_wrong_in_a_file_is_named_with_its_place(
    tmp_path: Path, file: str, text: str | bytes, message: str
) -> None:
    with pytest.raises(ModelError) as caught:
        read(tmp_path, text, file)
    assert str(caught.value).startswith(f"file: {file}: {message}")


TWO_NUMBERS = "from,to,length,time,name\na,b,1,2,High Street\n"


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "cost: missing; it says which number of an edge is its cost (valid: length, time)"),
        ({"cost": "lenght"}, "cost: no number 'lenght' on the edges (did you mean 'length'?)"),
        ({"cost": "name"}, "file: town.csv: line 2: edge from 'a' to 'b': name is not a number: 'High Street'"),
        ({"cost": 3}, "cost: must be the name of an attribute of the edges, not 3"),
        ({"cost": {"time": 3}}, "cost: must be the name of an attribute of the edges, not {'time': 3}"),
        ({"cost": {"time": "tiem"}}, "cost.time: no number 'tiem' on the edges (did you mean 'time'?)"),
        ({"cost": {}}, "cost: names no cost"),
        ({"cost": {"two words": "time"}}, "cost: 'two words' is not a name"),
        ({"cost": "time", "start": "z"}, "start: unknown state 'z' (valid: a, b)"),
        ({"cost": "time", "labels": {"z": ["p"]}}, "labels: unknown state 'z' (valid: a, b)"),
        ({"cost": "time", "labels": {"a": ["k k"]}}, "labels.a: 'k k' is not a name"),
        ({"cost": "time", "nodes": "x.txt"}, "nodes: x.txt: must end in .csv, .co, or in one of these and .gz"),
        ({"cost": "time", "nodes": "x.csv"}, "nodes: x.csv: no such file beside the scenario"),
        ({"cost": "time", "nodes": "\0.csv"}, "nodes: \0.csv: cannot be read: embedded null byte"),
        ({"cost": "time", "start": ""}, "start: unknown state '' (valid: a, b)"),
    ],
)
def test_keys_that_do_not_fit_the_file_are_refused(tmp_path: Path, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError) as caught:
        read(tmp_path, TWO_NUMBERS, **keys)
    assert str(caught.value).startswith(message)


def test_several_files_are_of_one_format_and_have_one_cost_each(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"^file.time: must be a file that ends in .gr, not 't.csv'"):
        _ = GraphFileModel(tmp_path, {"time": "t.csv"}, "1").network
    files = {"time": "t.gr", "toll": "c.gr"}
    with pytest.raises(ModelError, match=r"^cost: must be one of time, toll, or missing for all"):
        _ = GraphFileModel(tmp_path, files, "1", cost="tim").network
    with pytest.raises(ModelError, match=r"^cost: must be one of time, toll, or missing for all"):
        _ = GraphFileModel(tmp_path, files, "1", cost={"time": "time"}).network


OTHERS = "must list the same edges in the same order as t.gr"


@pytest.mark.parametrize(
    ("arcs", "message"),
    [
        (["a 1 2 5", "a 1 3 5"], OTHERS),
        (["a 1 2 5", "a 2 3 5", "a 3 1 5"], OTHERS),
        (["a 1 2 5"], OTHERS),
        (["a 1 2 5", "a 2 3 -5"], "line 3: edge from '2' to '3': cost is negative: '-5'"),
    ],
)
def test_files_of_several_costs_have_the_same_arcs(tmp_path: Path, arcs: list[str], message: str) -> None:
    (tmp_path / "t.gr").write_text("p sp 3 2\na 1 2 1\na 2 3 1\n")
    (tmp_path / "d.gr").write_text("\n".join([f"p sp 3 {len(arcs)}", *arcs]))
    with pytest.raises(ModelError) as caught:
        _ = GraphFileModel(tmp_path, {"time": "t.gr", "distance": "d.gr"}, "1").network
    assert str(caught.value).startswith(f"file: d.gr: {message}")


def several_costs_files(edges: list[tuple[int, int, int, int]], folder: Path) -> dict[str, dict[str, Any]]:
    """Write edges (source, target, time, distance) as a table and as DIMACS files; return the keys for each form."""
    rows = "".join(f"{source},{target},{time},{distance}\n" for source, target, time, distance in edges)
    (folder / "town.csv").write_text("from,to,travel_time,length\n" + rows)
    for k, name in ((2, "t.gr"), (3, "d.gr")):
        arcs = [f"a {edge[0]} {edge[1]} {edge[k]}" for edge in edges]
        (folder / name).write_text("\n".join([f"p sp 9 {len(edges)}", *arcs]))
    return {
        "table": {"file": "town.csv", "cost": {"time": "travel_time", "distance": "length"}},
        "dimacs": {"file": {"time": "t.gr", "distance": "d.gr"}},
    }


@pytest.mark.parametrize("seed", range(12))
def test_several_costs_in_files_are_those_written_out(tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    edges = [(1, 1, 0, 0)]
    edges += [(rng.randint(1, 4), rng.randint(1, 4), rng.randint(0, 5), rng.randint(0, 5)) for _ in range(20)]
    labels = {str(node): ["a"] if node == 3 else ["b"] for edge in edges for node in edge[:2] if node > 2}
    table: dict[str, Any] = {
        "tasks": [{"name": "x", "formula": "F a"}, {"name": "y", "formula": "F b"}],
        "preference": {"kind": "order"},
    }
    keys = {"kind": "graph", "start": "1", "labels": labels, "propositions": ["a", "b"]}
    written_out = [
        {"from": str(a), "to": str(b), "action": f"{b} {k}", "cost": {"time": time, "distance": distance}}
        for k, (a, b, time, distance) in enumerate(edges)
    ]
    listed = from_dict({**table, "model": {**keys, "transitions": written_out}})
    front = [plan.objectives for plan in pareto_front(listed.problem())]
    for form in several_costs_files(edges, tmp_path).values():
        read = from_dict({**table, "model": {**keys, **form}}, path=tmp_path / "town.toml")
        assert Counter(edges_of(read.problem().system)) == Counter(edges)
        assert [plan.objectives for plan in pareto_front(read.problem())] == front


def test_a_mistake_in_a_file_is_told_with_the_scenario(tmp_path: Path) -> None:
    table = random_problem(1).scenario()
    table["model"] = {"kind": "graph", "file": "town.gr", "start": 1}
    with pytest.raises(ScenarioError) as caught:
        from_dict(table, path=tmp_path / "town.toml").problem()
    assert str(caught.value) == f"{tmp_path}/town.toml: model.file: town.gr: no such file beside the scenario"


COSTS = st.one_of(
    st.integers(0, 10**6).map(float),
    st.integers(0, 10**6).map(lambda count: count / 1000),
    st.floats(0, 1000),
    st.sampled_from([1e-10, 1e10, 5e14, 0.123456789012345, 2.00000000001]),
)


def rounded(values: list[float]) -> tuple[list[Fraction], Fraction | None]:
    """Return floats as rationals, each rounded where it must be, and the resolution if one must be."""
    fractions, digits = (
        list(map(exact, values)),
        [Decimal(str(value)).normalize().as_tuple().digits for value in values],
    )
    long = [len(each) > 12 for each in digits]
    resolution = None
    if any(long) and max(fractions) / common_unit(fractions) >= 10**15:
        resolution = Fraction(10) ** (Decimal(str(float(max(fractions)))).adjusted() - 11)
    if resolution is None:
        return fractions, None
    return [
        round(f / resolution) * resolution if is_long else f for f, is_long in zip(fractions, long, strict=True)
    ], resolution


def test_costs_are_made_exact_within_the_limits() -> None:
    with Limits(seconds=0), pytest.raises(LimitError, match="stopped by the time limit"):
        in_units([k + 0.1234567890123456 for k in range(CLOCK_PERIOD)])


@given(st.lists(COSTS, max_size=8))
@example([999.9999999999999, 2.307582760437715e-178])  # the largest is 1000, exactly
@example([1.959018348345161, 999.9999999999999])
def test_costs_in_units_are_as_exact_as_each_alone(values: list[float]) -> None:
    fractions, resolution = rounded(values)
    multiples, unit = in_common_unit(fractions)
    found, found_unit, found_resolution = in_units(values)
    assert found.tolist() == multiples.tolist()
    assert (found_unit, found_resolution) == (unit, resolution)
