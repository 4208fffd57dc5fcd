"""Nothing that a stranger named acts on the terminal, or looks like a line of the program."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from forged_logs import telling
from scenario_texts import GRAPH, GRID, TABLE

from experiments.commands.command_line import main
from prefplan.text.layout import is_printable, printable, printable_lines
from sim.evidence.log import Log, encode
from sim.simulation.run import Event

EVIL = "evil\x1b]0;owned\x07\u202e\n  ok  forged: proved\n\x9b2J\x7f\u2028"
"""Sets the window's title, turns the line around, prints a line of its own, clears the screen."""

TOML = EVIL.encode("unicode_escape").decode().replace("\\x", "\\u00")

COLOUR = re.compile("\x1b\\[[0-9;]*m")
"""What the program itself sends to a terminal."""

CONTROLS = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def shown(capsys: pytest.CaptureFixture[str], *arguments: str, named: bool = True) -> str:
    """Return what a command shows on a terminal in colour, after checking that all of it is text."""
    main(arguments)
    text = "".join(capsys.readouterr())
    assert "evil" in text or not named, "the name is shown"
    assert not CONTROLS.findall(COLOUR.sub("", text))
    assert not re.search("^(  )?ok  forged", COLOUR.sub("", text), re.MULTILINE), "no line is forged"
    return text


@pytest.fixture(autouse=True)
def terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")


SCENARIOS = {
    "task": GRID.replace('name = "eat"', f'name = "{TOML}"').replace('"bake", "eat"', f'"bake", "{TOML}"'),
    "region": GRID.replace("cheese = [2", f'"{TOML}" = [2'),
    "action": GRAPH.replace('"east"', f'"{TOML}"'),
    "state": GRAPH.replace("s1", TOML),
    "start": GRAPH.replace('start = "s0"', f'start = "{TOML}"'),
    "proposition": GRAPH.replace('"rock"', f'"{TOML}"'),
    "location": TABLE.replace("san =", f'"{TOML}" ='),
    "object": TABLE.replace("blue =", f'"{TOML}" ='),
    "label": TABLE.replace("blue = {", f'blue = {{ label = "{TOML}",'),
    "mark": TABLE.replace('"clean"', f'"{TOML}"'),
    "support": TABLE.replace('"right"]', f'"{TOML}"]'),
    "file": TABLE.replace("blue = {", f'blue = {{ file = "{TOML}",'),
    "scene": TABLE.replace('start = "home"', f'start = "home"\nscene = "{TOML}"'),
    "robot": TABLE.replace("[model.locations]", f'[model.robot]\nname = "{TOML}"\n[model.locations]'),
    "key": GRID.replace("size =", f'"{TOML}" = 1\nsize ='),
    "table": GRID + f'\n["{TOML}"]\na = 1\n',
    "kind": GRID.replace('kind = "order"', f'kind = "{TOML}"'),
    "formula": GRID.replace("F cheese", f"F cheese {TOML}"),
    "cost": GRAPH.replace("cost = 1 ", f'cost = {{ "{TOML}" = 1 }}').replace(
        "cost = 0.5", f'cost = {{ "{TOML}" = 1 }}'
    ),
    "not TOML": GRID + f"\n{EVIL}",
}


@pytest.mark.parametrize("place", SCENARIOS)
def test_a_name_in_a_scenario_is_text(place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "evil.toml"
    path.write_text(SCENARIOS[place])
    for command in ("check", "front", "plan"):
        shown(capsys, "-q", command, str(path))


@pytest.mark.parametrize("command", ["check", "front", "plan", "run", "report", "sweep", "measure", "view", "draw"])
def test_the_name_of_a_file_is_text(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / f"{EVIL}.toml"
    for contents in ("[", GRAPH.replace('kind = "order"', 'kind = "disorder"') + "[[tasks]]\n"):
        path.write_text(contents)
        shown(capsys, command, str(path))


@pytest.mark.parametrize("column", ["from", "to", "action"])
def test_a_name_in_a_graph_s_file_is_text(column: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = EVIL.replace('"', "'")
    row = {"from": "s0", "to": "s1", "action": "east"} | {column: f'"{name}"'}
    (tmp_path / "roads.csv").write_text("from,to,action,cost\n{from},{to},{action},1\n".format(**row))
    start = EVIL.encode("unicode_escape").decode().replace("\\x", "\\u00") if column == "from" else "s0"
    goal = TOML if column == "to" else "s1"
    (tmp_path / "evil.toml").write_text(
        f'[model]\nkind = "graph"\nfile = "roads.csv"\nstart = "{start}"\n[model.labels]\n"{goal}" = ["plant"]\n'
        '[[tasks]]\nname = "go"\nformula = "F plant"\n[preference]\nkind = "order"\n'
    )
    for command in ("check", "front", "plan"):
        shown(capsys, "-q", command, str(tmp_path / "evil.toml"))


def test_arguments_are_text(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (
        ("automaton", f"F evil {EVIL}"),
        ("front", "example", f"--evil{EVIL}"),
        (f"evil{EVIL}",),
        ("run", "kitchen", "--robot", EVIL),
        ("run", "case_study_3", "--fault", EVIL),
        ("run", "case_study_3", "--perturb", EVIL, "--seed", "1"),
        ("run", "case_study_3", "--camera", EVIL),
        ("verify", f"{EVIL}.npz"),
        ("export", f"{EVIL}.npz", "--to", "glb"),
    ):
        shown(capsys, *arguments)


def test_of_a_formula_of_a_megabyte_a_message_shows_a_part(capsys: pytest.CaptureFixture[str]) -> None:
    many = " & ".join(["a"] * 100_000)
    for formula, words in ((f"F ({many} & & b)", "not '&', at column"), ("F " + "a" * 10**6 + " b", "not 'b', at")):
        assert main(["automaton", formula]) == 2
        told = capsys.readouterr().err
        assert words in told and len(told) < 500
        _, shown, pointer = told.rstrip("\n").split("\n")
        assert shown[pointer.index("^")] == words[5]
    assert main(["automaton", f"F a{'b' * 10**6} &"]) == 2
    assert main(["front", "case_study_1", "--at-most", "a" * 10**6]) == 2
    assert len(capsys.readouterr().err) < 5000


PLACES = (
    *("scenario", "action", "label", "event", "fault", "contact"),
    *("task", "robot", "version", "perturbation", "file", "text"),
)


def forged(log: Log) -> dict[str, Log]:
    """Return logs with the name in every place that a certificate or an error may show."""
    about = log.about
    first, *others = about.actions
    return {
        "scenario": telling(log, scenario=EVIL),
        "action": telling(log, actions=(replace(first, action=EVIL), *others)),
        "label": telling(log, actions=(replace(first, label=(EVIL,)), *others)),
        "event": telling(log, events=(Event(0.1, EVIL, {"object": EVIL}), *about.events)),
        "fault": telling(log, events=(Event(0.1, "fault", {"fault": EVIL}), *about.events)),
        "contact": telling(log, events=(Event(0.1, "contact", {"moving": EVIL, "other": EVIL}), *about.events)),
        "task": telling(log, claims=replace(about.claims, task_costs={EVIL: 1})),
        "robot": telling(log, robot=EVIL),
        "version": telling(log, versions=about.versions | {"mujoco": EVIL}),
        "perturbation": telling(log, setting={"seed": 3, "perturbation": EVIL}),
        "file": telling(log, files=about.files | {EVIL: ""}),
        "text": telling(log, text=about.text.replace('"cup"', f'"{TOML}"')),
    }


@pytest.mark.parametrize("place", PLACES)
def test_a_name_in_a_log_is_text(
    place: str, bench_log: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "evil.npz"
    path.write_bytes(encode(forged(bench_log)[place]))
    given = () if place == "scenario" else ("--scenario", "case_study_3")  # its own name is shown where none is given
    shown(capsys, "verify", str(path), *given, named=place not in ("label", "event", "version"))


def test_all_but_the_lines_is_escaped() -> None:
    assert printable("a\n\tb\x1b[0m\x85\u2066") == "a\\n\\tb\\x1b[0m\\x85\\u2066"
    assert printable_lines("a\n\tb\x1b[0m") == "a\n\tb\\x1b[0m"
    for text in ("Grün, 桌子, \U0001f600", "می\u200cخواهم", "\U0001f468\u200d\U0001f680"):
        assert printable(text) == text and is_printable(text)
