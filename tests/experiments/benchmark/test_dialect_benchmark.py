"""The comparison with another tool's collection of formulas, with a small made-up collection."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.benchmark import dialect


def test_formulas_are_counted_and_their_automata_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "some.ltl").write_text("# a comment\nFa & Xb\nG!a\nGFa\n\na U (b\n", encoding="utf-8")
    (tmp_path / "sizes").mkdir()
    sizes = [{"formula": "((F a) & (X b))", "properties": {"size": 7}}, {"formula": "Ga"}]
    (tmp_path / "sizes" / "coSafety.json").write_text(json.dumps(sizes), encoding="utf-8")
    assert dialect.main([str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "| some | 4 | 1 | 1 | 1 | 1 |" in printed
    assert "1 different co-safe formulas; Owl publishes the size of its automaton for 1 of them" in printed
    assert "- fewer here: 1" in printed and "  `F a & X b`: 5, Owl 7" in printed
