"""The cache of machine code on disk."""

from __future__ import annotations

from pathlib import Path

from prefplan.models.kernels import forget_outdated


def test_machine_code_is_kept_while_no_source_changes(tmp_path: Path) -> None:
    forget_outdated(tmp_path)
    index = tmp_path / "search.run-1.py3.nbi"
    index.touch()
    forget_outdated(tmp_path)
    assert index.exists()


def test_machine_code_of_other_sources_is_forgotten(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    forget_outdated(folder)
    index = folder / "search.run-1.py3.nbi"
    index.touch()
    (folder / "sources.sha256").write_text("of other sources")
    forget_outdated(folder)
    assert not index.exists()
    assert [file.name for file in folder.iterdir()] == ["sources.sha256"]
