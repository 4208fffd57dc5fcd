"""An automaton as text: a table to read, and HOA for other tools."""

import io
import json
import re

from rich.console import Console

from experiments.cli.console import table
from experiments.figures.diagrams.guards import cover, product
from prefplan.logic.dfa import Automaton
from prefplan.logic.mtbdd import leaves
from prefplan.logic.normal_form import parse
from prefplan.text.layout import counted

TEXT_COLUMNS = 72
"""Width of a table as text, letters: what fits beside another one on a page."""


def show_table(console: Console, automaton: Automaton) -> None:
    """Print a table with a row for each state and term of a guard."""
    count = counted(automaton.size, "state")
    text, read = _one_line(automaton.text), str(parse(automaton.text))
    same = re.sub(r"[\s()]", "", text) == re.sub(r"[\s()]", "", read)
    title = f"{text}{'' if same else f', read as {read}'}: {count}"
    found = table(title, ("state", "guard", "next state"), (), right=[2])
    for state in range(automaton.size):
        roles = {"(start)": 0, "(accepting)": automaton.accepting, "(dead)": automaton.dead}
        name = " ".join([str(state), *(role for role, holder in roles.items() if holder == state)])
        for target in leaves(automaton.transitions[state]):
            for term in cover(automaton, state, target):
                found.add_row(name, product(term), str(target))
                name = ""
        found.add_section()
    console.print(found)


def table_text(automaton: Automaton) -> str:
    """Return the table of `show_table` as text."""
    console = Console(file=io.StringIO(), width=TEXT_COLUMNS, no_color=True, markup=False, emoji=False)
    with console.capture() as capture:
        show_table(console, automaton)
    return capture.get()


def hoa(automaton: Automaton) -> str:
    """Return an automaton in the Hanoi Omega-Automata format, version 1.

    It is deterministic and complete. As a Buchi automaton it accepts the infinite words that satisfy the formula: those
    with a prefix that leads to the accepting state, which is never left. T. Babiak et al., "The Hanoi Omega-Automata
    Format", CAV 2015.
    """
    number = {name: index for index, name in enumerate(automaton.propositions)}
    names = "".join(f' "{name}"' for name in automaton.propositions)
    lines = [
        "HOA: v1",
        f"name: {json.dumps(_one_line(automaton.text))}",
        'tool: "prefplan"',
        f"States: {automaton.size}",
        "Start: 0",
        f"AP: {len(number)}{names}",
        "acc-name: Buchi",
        "Acceptance: 1 Inf(0)",
        "properties: trans-labels explicit-labels state-acc deterministic complete terminal",
        "--BODY--",
    ]
    for state in range(automaton.size):
        lines.append(f"State: {state} {{0}}" if state == automaton.accepting else f"State: {state}")
        for guard, target in automaton.guards(state):
            label = "&".join(str(number[name]) if holds else f"!{number[name]}" for name, holds in guard.items())
            lines.append(f"[{label or 't'}] {target}")
    return "\n".join([*lines, "--END--", ""])


def _one_line(text: str) -> str:
    """Return a formula on one line; a formula has neither quotes nor backslashes to escape."""
    return " ".join(text.split())
