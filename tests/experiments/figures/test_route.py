"""Plans on graphs: every action on its edge in order, and of large graphs what the plan visits."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from experiments.commands.command_line import main
from experiments.figures.diagrams import node_link
from experiments.figures.diagrams.route import MOST_STATES, Route, SystemSizeError, route
from experiments.figures.figures import SVG
from experiments.starters import starter
from prefplan import Plan, TransitionSystem, load, pareto_front


def plan_of(*actions: str) -> Plan:
    return Plan(0, 0, {}, {}, actions, ())


def ring(size: int, labelled: int) -> TransitionSystem:
    """Return a ring of states, the first few of which have a proposition."""
    transitions = [(f"r{i}", "go", f"r{(i + 1) % size}", 2) for i in range(size)]
    return TransitionSystem.from_transitions(
        transitions, start="r0", labels={f"r{i}": [f"p{i}"] for i in range(labelled)}
    )


def steps(found: Route) -> dict[int, tuple[str, str]]:
    """Return the numbered actions by their first step, each with the names of the states at the ends of its edge."""
    return {
        int(match[1]): (found.diagram.nodes[edge.source].text[0], found.diagram.nodes[edge.target].text[0])
        for edge in found.diagram.edges
        for match in re.finditer(r"(\d+)(?:, |-\d+\. |\. )", edge.label)
    }


def test_a_small_graph_is_drawn_whole_with_the_actions_in_order(tmp_path: Path) -> None:
    (tmp_path / "town.toml").write_text(starter("graph", file="town.toml"))
    problem = load(tmp_path / "town.toml").problem()
    plan = pareto_front(problem)[1]
    found = route(problem.system, plan)
    assert found.note is None and len(found.diagram.nodes) == 4 and len(found.diagram.edges) == 7
    names = [found.diagram.nodes[i].text[0] for i in found.at]
    assert names == list(plan.states)
    assert steps(found) == {k + 1: pair for k, pair in enumerate(zip(names, names[1:], strict=False))}
    assert {edge.kind for edge in found.diagram.edges if edge.label[0].isdigit()} == {"taken"}
    root = ET.fromstring(node_link.svg(found.diagram, title="town"))
    classes = [element.get("class", "") for element in root.iter()]
    assert sum(name.endswith(" taken") for name in classes) == len(plan.actions)
    assert {f"node plain s{i}" for i in range(4)} <= set(classes)


def test_an_edge_taken_again_has_all_its_places() -> None:
    found = route(ring(2, 0), plan_of("go", "go", "go"))
    assert {edge.label for edge in found.diagram.edges} == {"1, 3. go 2", "2. go 2"}


def test_of_a_large_graph_is_drawn_what_the_plan_visits() -> None:
    found = route(ring(300, 2), plan_of(*["go"] * 9))
    assert len(found.diagram.nodes) == 10 and found.at == tuple(range(10))
    assert found.note == "Drawn of 300 states: those that the plan visits."
    assert steps(found)[9] == ("r8", "r9")


def test_of_a_long_plan_are_drawn_the_states_with_propositions() -> None:
    found = route(ring(300, 2), plan_of(*["go"] * 99))
    assert [node.text[0] for node in found.diagram.nodes] == ["r0", "r1", "r99"]
    assert [edge.label for edge in found.diagram.edges] == ["1. go 2", "2-99. 98 actions, cost 196"]
    assert found.at == (0, *[1] * 98, 2) and "propositions" in (found.note or "")


def test_a_plan_through_too_many_propositions_is_refused() -> None:
    with pytest.raises(SystemSizeError, match="too many to draw"):
        route(ring(300, MOST_STATES + 1), plan_of(*["go"] * 99))


def test_plans_on_graphs_are_drawn(tmp_path: Path) -> None:
    (tmp_path / "town.toml").write_text(starter("graph", file="town.toml"))
    assert main(["draw", "plans", str(tmp_path / "town.toml"), str(tmp_path / "town.svg")]) == 0
    elements = ET.parse(tmp_path / "town.svg").iter("{http://www.w3.org/2000/svg}text")
    texts = {"".join(element.itertext()).strip() for element in elements}
    assert {"0: cost 3.5, μ = 2", "1: cost 6.5, μ = 0", "2. take the tram 2.5", "bakery", "home 1"} <= texts


def test_no_text_in_a_graph_overlaps() -> None:
    found = route(ring(12, labelled=3), plan_of(*["go"] * 11))
    wide, tall = (ET.fromstring(node_link.svg(found.diagram, title="", direction=to)) for to in ("LR", "TB"))
    assert float(wide.get("width", "")) > float(wide.get("height", ""))
    assert float(tall.get("height", "")) > float(tall.get("width", ""))
    for root in (wide, tall):
        boxes = []
        for text in root.iter(f"{SVG}text"):
            x, y, size = (float(text.get(key, "")) for key in ("x", "y", "font-size"))
            half = 0.3 * size * len(text.text or "")  # letters are 0.6 as wide as high
            boxes.append([x - half, y - 0.7 * size, x + half, y])
        low, high = np.array(boxes)[:, :2], np.array(boxes)[:, 2:]
        shared = (np.minimum(high[:, None], high) - np.maximum(low[:, None], low)).clip(min=0).prod(axis=2)
        assert np.count_nonzero(shared) == len(boxes), "each overlaps itself alone"
