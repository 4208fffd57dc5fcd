"""Drawings of automata: what their labels mean, what a page finds in them, and that nothing lies on anything else."""

from __future__ import annotations

import random
import xml.etree.ElementTree as ET
from itertools import combinations

import judge
import numpy as np
import pytest
from judge.semantics import powerset

from experiments.figures.diagrams import automaton as picture
from experiments.figures.diagrams.guards import LONG, OTHERWISE, cover, labels
from experiments.figures.diagrams.layered import Box, place
from experiments.figures.diagrams.node_link import ADVANCE_PT
from prefplan.logic.dfa import automaton
from prefplan.logic.mtbdd import leaves

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
    root = ET.fromstring(picture.svg(dfa))
    found = {element.get("class", "") for element in root.iter()}
    kinds = {dfa.accepting: "accepting", dfa.dead: "dead"}
    nodes = {f"node {kinds.get(state, 'plain')} q{state}" for state in range(dfa.size)}
    edges = {
        f"edge q{state}-q{target}"
        for state in range(dfa.size)
        for target in leaves(dfa.transitions[state])
        if not (state == target and state in kinds)
    }
    assert {name for name in found if name.split(" ")[0] in ("node", "edge")} == nodes | edges
    assert root.get("role") == "img" and dfa.text in (root.get("aria-label") or "")
    assert not any(element.get("id") for element in root.iter())


@pytest.mark.parametrize("formula", FORMULAS)
def test_nodes_lie_apart_and_inside_the_picture(formula: str) -> None:
    drawn = picture.diagram(automaton(formula))
    halves = drawn.sizes / 2
    assert (drawn.middles - halves >= 0).all()
    assert (drawn.middles + halves <= drawn.size).all()
    for i, j in combinations(range(len(drawn.nodes)), 2):
        assert (abs(drawn.middles[i] - drawn.middles[j]) >= halves[i] + halves[j]).any()
    for arrow in drawn.arrows:
        assert np.isfinite(arrow.curve).all()


def test_labels_lie_apart_from_each_other_and_from_nodes() -> None:
    rng = random.Random(1)
    count = 9
    edges = [(rng.randrange(i), i) for i in range(1, count)]
    edges += [
        (a, b) for a in range(count) for b in range(count) if a != b and (a, b) not in edges and rng.random() < 0.2
    ]
    node, label = Box(30, 15, 15), Box(60, 16, 4)
    layout = place([node] * count, edges, [label] * len(edges), gap=(20, 10))
    places = [*((x, y, node) for x, y in layout.nodes), *((x, y, label) for x, y in layout.labels)]
    for (x, y, a), (u, v, b) in combinations(places, 2):
        beside = abs(x - u) >= (a.width + b.width) / 2 - 1e-9
        upper, lower = ((y, a), (v, b)) if y < v else ((v, b), (y, a))
        assert beside or lower[0] - lower[1].above >= upper[0] + upper[1].below - 1e-9
    assert len(layout.labels) == len(edges)
    forward = [layout.nodes[a][0] < layout.nodes[b][0] for a, b in edges]
    for (a, b), route, ahead in zip(edges, layout.routes, forward, strict=True):
        assert layout.nodes[a][0] != layout.nodes[b][0]
        assert (np.diff(route[:, 0]) >= 0).all() if ahead else (np.diff(route[:, 0]) <= 0).all()


def test_every_letter_of_a_long_label_is_in_the_picture() -> None:
    formula = "F (stove & F (table & F door)) & (!cellar U (gate & (attic | hall) | F attic))"
    dfa = automaton(formula)
    drawn = picture.diagram(dfa)
    numbers = {arrow.lines[0] for arrow in drawn.arrows if arrow.lines[0].startswith("(")}
    assert numbers and {line.split(" ")[0] for line in drawn.notes if line.startswith("(")} == numbers
    said = " ".join([*drawn.notes, *(" ".join(arrow.lines) for arrow in drawn.arrows)])
    assert "..." not in said
    squeezed = "".join(said.split())
    for state in range(dfa.size):
        for target, text in labels(dfa, state).items():
            assert "".join(text.split()) in squeezed or (target == state and state in (dfa.accepting, dfa.dead))
    assert max(len(line) for line in drawn.notes) * ADVANCE_PT <= drawn.size[0]
    notes = [element for element in ET.fromstring(picture.svg(dfa)).iter() if element.get("class") == "note"]
    assert len(notes) == len(drawn.notes)
