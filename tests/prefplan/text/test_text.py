from __future__ import annotations

import pytest

from prefplan.text.layout import numbered

LONG = [f"go r{k}" for k in range(1, 41)]


def test_a_plan_has_numbers_and_is_wrapped_between_actions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    assert numbered(["go on", "stay", "stay", "carry the red cup home", "go on"]).splitlines() == [
        "1. go on, 2-3. stay,",
        "4. carry the red cup home, 5. go on",
    ]
    assert numbered(["carry a cup that is wider than the terminal itself", "go"]).splitlines()[1:] == ["2. go"]
    assert numbered([]) == ""


def test_without_a_terminal_lines_have_80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_terminal(*_: int) -> None:
        raise OSError

    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr("os.get_terminal_size", no_terminal)
    lines = numbered(LONG).splitlines()
    assert 70 < max(map(len, lines)) <= 80
    assert " ".join(lines) == ", ".join(f"{k}. {action}" for k, action in enumerate(LONG, 1))


def test_moves_on_a_grid_are_condensed_and_wrapped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "10")
    assert numbered("NNNNEENSSSW") == "4N 2E N 3S\nW"


def test_a_long_plan_says_how_to_see_the_rest() -> None:
    *shown, last = numbered(LONG, most=30, whole="ask").splitlines()
    assert shown[-1].endswith("30. go r30")
    assert last == "... and 10 more actions; ask"
    assert numbered("NNNNEEENW", most=2, whole="ask").splitlines()[-1] == "... and 2 more actions; ask"
    assert numbered(LONG, most=40, whole="ask") == numbered(LONG)
