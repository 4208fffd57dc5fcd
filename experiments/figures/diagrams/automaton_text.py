"""An automaton as text: a table to read, and HOA for other tools."""

import io
import json
import re

from rich.console import Console
from rich.table import Table
from rich.text import Text

from experiments.figures.diagrams.guards import cover, product, targets
from prefplan.logic.dfa import Automaton
from prefplan.logic.normal_form import parse
from prefplan.text.layout import counted

TEXT_COLUMNS = 72
"""Width of a table as text, letters: what fits beside another one on a page."""


def show_table(console: Console, automaton: Automaton) -> None:
    """Print a table with a row for each state and term of a guard."""
    count = counted(automaton.size, "state")
    text, read = _one_line(automaton.text), str(parse(automaton.text))
    same = re.sub(r"[\s()]", "", text) == re.sub(r"[\s()]", "", read)
    table = Table(title=Text(f"{text}{'' if same else f', read as {read}'}: {count}"), title_justify="left")
    table.add_column("state")
    table.add_column("guard")
    table.add_column("next state", justify="right")
    for state in range(automaton.size):
        name = " ".join([str(state), *_roles(automaton, state)])
        for target in targets(automaton, state):
            for term in cover(automaton, state, target):
                table.add_row(Text(name), Text(product(term)), str(target))
                name = ""
        table.add_section()
    console.print(table)


def table_text(automaton: Automaton) -> str:
    """Return that table as text."""
    console = Console(file=io.StringIO(), width=TEXT_COLUMNS, no_color=True)
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


def _roles(automaton: Automaton, state: int) -> list[str]:
    roles = {"(start)": 0, "(accepting)": automaton.accepting, "(dead)": automaton.dead}
    return [role for role, holder in roles.items() if holder == state]


def _one_line(text: str) -> str:
    """Return a formula on one line; a formula has neither quotes nor backslashes to escape."""
    return " ".join(text.split())
