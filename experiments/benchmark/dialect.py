"""Read a collection of formulas of another tool, and compare the sizes of automata with those that it publishes.

Owl's collection is the folder `data/formulas` of https://github.com/owl-toolkit/owl: files of formulas, most of them
from the literature, one a line, and in `sizes/coSafety.json` the sizes of Owl's automata of the co-safe ones.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from prefplan import Automaton, FormulaError, automaton, parse
from prefplan.logic.formula import Formula
from prefplan.logic.normal_form import parse_rule

TASK, RULE, REFUSED, BROKEN = "read as a task", "read as a rule", "neither co-safe nor safety", "not read"

KINDS = (TASK, RULE, REFUSED, BROKEN)

COMMENTS = ("#", "//")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="the collection's folder")
    folder = parser.parse_args(arguments).folder
    print("| file | formulas |", " | ".join(KINDS), "|")
    print("| --- " * (len(KINDS) + 2) + "|")
    read: dict[Formula, Automaton] = {}
    whole: Counter[str] = Counter()
    for path in sorted(folder.rglob("*.ltl")):
        found = Counter(kind_of(text) for text in formulas(path))
        read |= {parse(text): automaton(text) for text in formulas(path) if kind_of(text) == TASK}
        whole += found
        _show(path.stem, found)
    _show("all", whole)
    sizes = list(compared(folder / "sizes" / "coSafety.json", read))
    print(
        f"\n{len(read)} different co-safe formulas; Owl publishes the size of its automaton for {len(sizes)} of them:"
    )
    for words, count in (
        ("as many states here", sum(ours == theirs for _, ours, theirs in sizes)),
        ("fewer here", sum(ours < theirs for _, ours, theirs in sizes)),
        ("more here", sum(ours > theirs for _, ours, theirs in sizes)),
    ):
        print(f"- {words}: {count}")
    for formula, ours, theirs in sizes:
        if ours != theirs:
            print(f"  `{formula}`: {ours}, Owl {theirs}")
    return 0


def formulas(path: Path) -> Iterator[str]:
    """Yield the formulas of a file."""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.strip() and not line.lstrip().startswith(COMMENTS):
            yield line.strip()


def kind_of(text: str) -> str:
    """Return which of `KINDS` a formula is."""
    try:
        parse(text)
        return TASK
    except FormulaError as error:
        if not str(error).startswith("not co-safe"):
            return BROKEN
    try:
        parse_rule(text)
    except FormulaError:
        return REFUSED
    return RULE


def compared(sizes: Path, read: dict[Formula, Automaton]) -> Iterator[tuple[Formula, int, int]]:
    """Yield each formula whose automaton's size is published, and both numbers of states, ours without the dead one."""
    for entry in json.loads(sizes.read_text(encoding="utf-8")):
        try:
            formula = parse(entry["formula"])
        except FormulaError:
            continue
        if formula in read and "properties" in entry:
            ours = read[formula]
            yield formula, ours.size - (ours.dead is not None and ours.size > 1), entry["properties"]["size"]


def _show(name: str, found: Counter[str]) -> None:
    print(f"| {name} | {sum(found.values())} |", " | ".join(str(found[kind]) for kind in KINDS), "|")


if __name__ == "__main__":
    sys.exit(main())
