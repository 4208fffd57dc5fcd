"""Fronts of two costs on published road networks: their format is read, and a second search finds the same points."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from experiments.benchmark import road_front
from experiments.benchmark.road_front import Query

ARCS = "1 2 1 5\n1 2 3 3\n1 2 4 4\n2 3 1 1\n1 3 9 1\n3 1 0 0\n"


def test_each_query_gets_a_row_that_another_search_agrees_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "DC1").write_text("sp min 3 6\n1 1\n3 -1\n" + ARCS)
    (tmp_path / "DC_ODpairs.txt").write_text("1 1\n3 -1\n\n3 1\n2 -1\n")
    monkeypatch.setattr(sys, "argv", ["road_front", str(tmp_path)])
    road_front.main()
    rows = capsys.readouterr().out.splitlines()[2:]
    assert [row.split(" | ")[:2] for row in rows] == [["| 1 to 3", "3"], ["| 3 to 2", "2"]]
    arcs = road_front.read_arcs(tmp_path / "DC1")
    assert road_front.points_by_one_search(arcs, Query(1, 3)) == [(2, 6), (4, 4), (9, 1)]


def test_missing_files_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["road_front", str(tmp_path)])
    with pytest.raises(SystemExit) as caught:
        road_front.main()
    assert caught.value.code == 2
