"""Drawings of automata: what their labels mean, what a page finds in them, and that nothing lies on anything else."""

from __future__ import annotations

import os
import random
import re
import shutil
import xml.etree.ElementTree as ET
from itertools import combinations
from pathlib import Path

import judge
import numpy as np
import pytest
from judge.semantics import powerset
from report_pages import ERRANDS

from experiments.figures.diagrams import node_link
from experiments.figures.diagrams.automaton import diagram
from experiments.figures.diagrams.guards import LONG, OTHERWISE, cover, labels
from experiments.figures.diagrams.node_link import WIDEST, Diagram, Edge, GraphvizError, Node
from experiments.figures.figures import SVG
from experiments.report.page import write_page
from prefplan import pareto_front
from prefplan.logic.dfa import automaton
from prefplan.logic.mtbdd import leaves
from prefplan.scenario.decode import loads

FORMULAS = [
    "true",
    "false",
    "F a & F b & F c",
    "(!cheese U pizza) & (!cheese U tacos)",
    "F(cheese & F(tacos) & F(grocer) & F(pizza))",
    *(judge.to_text(judge.random_formula(random.Random(seed), "abc", 3)) for seed in range(12)),
]


def covered(cubes: list[dict[str, bool]], letter: frozenset[str]) -> bool:
    return any(all((name in letter) == holds for name, holds in cube.items()) for cube in cubes)


@pytest.mark.parametrize("formula", FORMULAS)
def test_guards_hold_exactly_where_the_automaton_goes_there_and_no_term_can_be_left_out(formula: str) -> None:
    dfa = automaton(formula)
    for state in range(dfa.size):
        for target in leaves(dfa.transitions[state]):
            cubes = cover(dfa, state, target)
            for letter in powerset(dfa.propositions):
                assert covered(cubes, letter) == (dfa.step(state, letter) == target)
            for i in range(len(cubes)):
                fewer = cubes[:i] + cubes[i + 1 :]
                assert any(covered(cubes, x) and not covered(fewer, x) for x in powerset(dfa.propositions))


def test_one_label_of_a_state_says_otherwise_that_of_the_dead_state_or_the_longest() -> None:
    dfa = automaton("F(cheese & F(tacos) & F(grocer) & F(pizza))")
    texts = list(labels(dfa, 8).values())
    assert texts.count(OTHERWISE) == 1
    assert labels(automaton("F (a & b)"), 0) == {1: "a & b", 0: "!a | !b"}
    assert len("!a | !b") < LONG
    dfa = automaton("!a U b")
    assert labels(dfa, 0) == {1: "b", 0: "!a & !b", 2: OTHERWISE} and dfa.dead == 2


@pytest.mark.parametrize("formula", FORMULAS)
def test_a_page_finds_every_state_and_edge_by_class(formula: str) -> None:
    dfa = automaton(formula)
    root = ET.fromstring(node_link.svg(diagram(dfa), title=f"Automaton of {dfa.text}"))
    found = {element.get("class", "") for element in root.iter()}
    kinds = {dfa.accepting: "accepting", dfa.dead: "dead"}
    nodes = {f"node {kinds.get(state, 'plain')} q{state}" for state in range(dfa.size)}
    edges = {
        f"edge q{state}-q{target}"
        for state in range(dfa.size)
        for target in leaves(dfa.transitions[state])
        if not (state == target and state in kinds)
    }
    assert {name for name in found if name.split(" ")[0] in ("node", "edge")} == nodes | edges | {"edge start"}
    assert root.get("role") == "img" and dfa.text in (root.get("aria-label") or "")
    assert not any(element.get("id") for element in root.iter())


def extent(node: ET.Element) -> np.ndarray:
    """Return the (4,) rectangle of a circular node."""
    outer = node.findall(f"{SVG}ellipse")[-1]
    middle, half = (np.array([float(outer.get(key, "")) for key in keys]) for keys in (("cx", "cy"), ("rx", "ry")))
    return np.concatenate([middle - half, middle + half])


@pytest.mark.parametrize("formula", FORMULAS)
def test_nodes_lie_apart_and_inside_the_picture(formula: str) -> None:
    root = ET.fromstring(node_link.svg(diagram(automaton(formula)), title=""))
    shift = np.array(re.findall(r"translate\((.*?) (.*?)\)", root[0].get("transform", ""))[0], dtype=float)
    boxes = [extent(part) + [*shift, *shift] for part in root.iter() if part.get("class", "").startswith("node ")]
    for box in boxes:
        assert (box[:2] >= 0).all() and (box[2:] <= [float(root.get(side, "")) for side in ("width", "height")]).all()
    for one, other in combinations(boxes, 2):
        assert (one[2:] <= other[:2]).any() or (other[2:] <= one[:2]).any()


def test_every_letter_of_a_long_label_is_in_the_picture() -> None:
    dfa = automaton("F (stove & F (table & F door)) & (!cellar U (gate & (attic | hall) | F attic))")
    root = ET.fromstring(node_link.svg(diagram(dfa), title=dfa.text))
    for state in range(dfa.size):
        for target, text in labels(dfa, state).items():
            if target == state and state in (dfa.accepting, dfa.dead):
                continue
            (edge,) = (part for part in root.iter() if part.get("class") == f"edge q{state}-q{target}")
            lines = ["".join(line.itertext()) for line in edge.findall(f"{SVG}text")]
            assert " ".join(lines) == text and max(map(len, lines)) <= WIDEST


def test_text_stays_as_it_is_written() -> None:
    for text in ('"b" \\n c', "<b>", "&amp; &lt;", "naïve", "\\"):
        two = Diagram([Node("s0", (text, "second line")), Node("s1", ("1",))], [Edge(0, 1, text)])
        root = ET.fromstring(node_link.svg(two, title=text))
        assert {"".join(part.itertext()) for part in root.iter(f"{SVG}text")} == {text, "second line", "1"}
        assert root.get("aria-label") == text


def test_what_cannot_be_printed_is_escaped() -> None:
    two = Diagram([Node("s0", ("kiosk\x1b[31m",)), Node("s1", ("\0 \ufffe",))], [])
    root = ET.fromstring(node_link.svg(two, title="from \x1b"))
    assert {"".join(part.itertext()) for part in root.iter(f"{SVG}text")} == {"kiosk\\x1b[31m", "\\x00 \\ufffe"}
    assert root.get("aria-label") == "from \\x1b"


@pytest.fixture
def without_graphviz(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name, path=None: None)


def test_without_graphviz_a_page_has_the_table_and_a_file_is_refused(without_graphviz: None, tmp_path: Path) -> None:
    scenario = loads(ERRANDS, name="errands")
    page = write_page(scenario, pareto_front(scenario.problem()), {}, tmp_path / "report").read_text(encoding="utf-8")
    assert "│ 0 (start)     │ bank  │          1 │" in page
    assert "Automata are tables, and plans on graphs have no pictures: Graphviz is not installed." in page
    with pytest.raises(GraphvizError, match="Graphviz draws this, and it is not installed: get Debian's package"):
        node_link.draw({"pay": diagram(automaton("F bank"))}, tmp_path / "pay.svg")
    assert not (tmp_path / "pay.svg").exists()


def test_what_graphviz_cannot_do_is_said_in_its_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dot").write_text("#!/bin/sh\necho 'Format: \"pdf\" not recognized.' >&2\nexit 1\n")
    (tmp_path / "dot").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(GraphvizError, match='^dot cannot write pdf: Format: "pdf" not recognized.$'):
        node_link.draw({"pay": diagram(automaton("F bank"))}, tmp_path / "pay.pdf")


def test_diagrams_of_a_file_stand_in_their_order(tmp_path: Path) -> None:
    titles = [f"{formula}: the formula" for formula in ("F a", "F b & F c", "!a U b")]
    node_link.draw({title: diagram(automaton(title.split(":")[0])) for title in titles}, tmp_path / "three.svg")
    heights = {text.text: float(text.get("y", "")) for text in ET.parse(tmp_path / "three.svg").iter(f"{SVG}text")}
    assert sorted(titles, key=heights.__getitem__) == titles
