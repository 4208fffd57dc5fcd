"""Files that are kept in the user's cache."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from sim.cache import keep


def test_of_a_file_that_cannot_be_kept_nothing_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keep(tmp_path / "kept", b"all of it")
    assert (tmp_path / "kept").read_bytes() == b"all of it"

    def full(path: Path, contents: bytes) -> int:
        path.open("xb").write(contents[:1])
        raise OSError(errno.ENOSPC, "no space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    keep(tmp_path / "kept", b"something else")
    keep(tmp_path / "other", b"something else")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]
    assert (tmp_path / "kept").read_bytes() == b"all of it"
