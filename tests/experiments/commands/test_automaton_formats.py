"""`prefplan automaton`: the formats for other programs, read back, and the table."""

from __future__ import annotations

import random
import re
import shutil
import subprocess

import judge
import pytest
from command_line import Run, assert_is_error
from hoa.ast.acceptance import AcceptanceAtom, AtomType
from hoa.ast.boolean_expression import And, Not, Or, TrueFormula
from hoa.ast.label import LabelAtom, LabelExpression
from hoa.core import HOA
from hoa.parsers import HOAParser
from judge.semantics import powerset

from experiments.figures.diagrams import node_link
from experiments.figures.diagrams.automaton import diagram
from experiments.figures.diagrams.automaton_text import hoa
from prefplan import Automaton
from prefplan.logic.dfa import automaton

FORMULAS = [
    "true",
    "false",
    "a",
    "X(a | !a)",
    "!plant U dirt",
    "F(a & X b)",
    "F a & F b & F c",
    "(!cheese U pizza) & (!cheese U tacos)",
    *(judge.to_text(judge.random_formula(random.Random(seed), "abc", 3)) for seed in range(60)),
]


@pytest.fixture(scope="module")
def parser() -> HOAParser:
    return HOAParser()


def is_true(label: LabelExpression, letter: set[int]) -> bool:
    match label:
        case TrueFormula():
            return True
        case LabelAtom():
            return label.proposition in letter
        case Not():
            return not is_true(label.argument, letter)
        case And():
            return all(is_true(part, letter) for part in label.operands)
        case Or():
            return any(is_true(part, letter) for part in label.operands)
    raise AssertionError(label)


def assert_same(read: HOA, dfa: Automaton) -> None:
    """Compare what was read with the automaton, for every state and letter."""
    names = tuple(str(name).strip('"') for name in read.header.propositions or ())
    assert names == dfa.propositions
    assert [list(conjunction) for conjunction in read.header.start_states or ()] == [[0]]
    assert [state.index for state in read.body.state2edges] == list(range(dfa.size))
    for state, edges in read.body.state2edges.items():
        assert (state.acc_sig == frozenset({0})) == (state.index == dfa.accepting)
        for letter in powerset(names):
            numbers = {names.index(name) for name in letter}
            targets = [list(edge.state_conj) for edge in edges if is_true(edge.label, numbers)]
            assert targets == [[dfa.step(state.index, letter)]], (state, letter)


def test_hoa_is_read_back_as_the_same_deterministic_complete_automaton(parser: HOAParser) -> None:
    for formula in FORMULAS:
        dfa = automaton(formula)
        read = parser(hoa(dfa))
        assert read.header.nb_states == dfa.size, formula
        assert {"state-acc", "deterministic", "complete"} <= {str(name) for name in read.header.properties or ()}
        assert read.header.acceptance.name == "Buchi"
        assert read.header.acceptance.condition == AcceptanceAtom(AtomType.INFINITE, 0, False), formula
        assert_same(read, dfa)


def test_hoa_names_the_formula_as_it_was_written(parser: HOAParser) -> None:
    text = "F (a\n  & X b)"
    assert str(parser(hoa(automaton(text))).header.name).strip('"') == "F (a & X b)"


def dot(dfa: Automaton) -> str:
    return node_link.source({dfa.text: diagram(dfa)})


def test_dot_has_every_state_and_one_edge_for_each_pair_of_states() -> None:
    for formula in FORMULAS:
        dfa = automaton(formula)
        text, ends = dot(dfa), {dfa.accepting: "accepting", dfa.dead: "dead"}
        states = re.findall(
            r'^n_0_(\d+) \[label="(\d+)", class="(\w+) q(\d+)", shape=(\w+), style="?([a-z,]*[a-z])', text, re.M
        )
        assert [state[2:] for state in states] == [
            (
                ends.get(state, "plain"),
                str(state),
                "doublecircle" if state == dfa.accepting else "circle",
                "filled,dashed" if state == dfa.dead else "filled",
            )
            for state in range(dfa.size)
        ]
        edges = re.findall(r'^n_0_(\d+) -> n_0_(\d+) \[label="[^"]+", class="q\1-q\2"\]$', text, re.M)
        steps = {
            (str(state), str(dfa.step(state, letter)))
            for state in range(dfa.size)
            for letter in powerset(dfa.propositions)
        }
        # What is never left has no arrows.
        assert len(edges) == len(set(edges)), formula
        assert set(edges) == steps - {(str(state), str(state)) for state in ends}, formula


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
def test_graphviz_draws_it() -> None:
    drawing = subprocess.run(["dot", "-Tsvg"], input=dot(automaton(FORMULAS[5])), capture_output=True, text=True)
    assert drawing.returncode == 0 and "</svg>" in drawing.stdout, drawing.stderr


def test_the_table_has_a_row_for_each_state_and_guard(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")
    status, out, err = run("automaton", "!plant U dirt")
    assert (status, err) == (0, "")
    rows = [line.split("│")[1:-1] for line in out.splitlines() if line.startswith("│")]
    assert [[cell.strip() for cell in row] for row in rows] == [
        ["0 (start)", "dirt", "1"],
        ["", "!dirt & plant", "2"],
        ["", "!dirt & !plant", "0"],
        ["1 (accepting)", "true", "1"],
        ["2 (dead)", "true", "2"],
    ]


@pytest.mark.parametrize(("name", "write"), [("hoa", hoa), ("dot", dot)])
def test_other_formats_stand_alone_on_stdout(run: Run, name: str, write: object) -> None:
    assert callable(write)
    assert run("automaton", "F(a & X b)", "--format", name) == (0, write(automaton("F(a & X b)")), "")


@pytest.mark.parametrize(
    ("formula", "message", "column"),
    [
        (
            "F a & G b",
            "not co-safe: 'G b' must hold for ever, which no finite plan shows; "
            "write the task 'b U a' or the rule 'G b', at column 7",
            6,
        ),
        ("a & &", "expected a formula, not '&', at column 5", 4),
        ("", "expected a formula, but the formula ends, at column 1", 0),
    ],
)
def test_a_formula_that_cannot_be_read_is_pointed_at(run: Run, formula: str, message: str, column: int) -> None:
    status, out, err = run("automaton", formula)
    assert (status, out) == (2, "")
    assert err.split("\n") == [f"prefplan: {message}", f"    {formula}", f"    {' ' * column}^", ""]


def test_guards_of_very_many_propositions_are_left_to_other_programs(run: Run) -> None:
    text = "F(" + " | ".join(f"p{i}" for i in range(1200)) + ")"
    assert_is_error(run("automaton", text), "1200 propositions")
    assert run("automaton", text, "--format", "hoa").out.count("\n[") == 1202
    assert "p399" in run("automaton", text.split(" | p400")[0] + ")").out


@pytest.mark.parametrize(
    ("option", "value", "told"), [("--max-seconds", "0.2", "time"), ("--max-memory", "1", "memory")]
)
def test_an_automaton_that_takes_too_long_is_stopped(run: Run, option: str, value: str, told: str) -> None:
    huge = "F[0:200] (a & F[0:200] b)"
    assert run("automaton", huge, option, value) == (4, "", f"prefplan: stopped by the {told} limit\n")
