"""Logs from strangers: what is no log is refused before it is unpacked, and its files stay in their folder."""

from __future__ import annotations

import base64
import os
import resource
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from forged_logs import telling

from sim.errors import LogError
from sim.evidence.certificate import certify
from sim.evidence.log import Log, encode, read_log
from sim.external import bundle


def packed(text: str | bytes) -> str:
    return base64.b64encode(text.encode() if isinstance(text, str) else text).decode()


def files_of(log: Log, **changes: str) -> Log:
    return telling(log, files=log.about.files | changes)


def written(log: Log, folder: Path) -> Path:
    path = folder / "run.npz"
    path.write_bytes(encode(log))
    return path


def with_member(path: Path, name: str, contents: bytes) -> None:
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, contents)


def array_of(shape: str, size: int) -> bytes:
    """Return an array's file whose header gives a shape, followed by so many zeros."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + bytes(size)


def without(path: Path, name: str) -> None:
    with zipfile.ZipFile(path) as archive:
        parts = {part: archive.read(part) for part in archive.namelist() if part != name}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for part, contents in parts.items():
            archive.writestr(part, contents)


@pytest.mark.parametrize("name", ["more.npy", "torques.npy", "times", "../times.npy", "about.npy"])
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_member_that_no_log_has_or_that_is_there_twice_is_refused(bench_log: Log, tmp_path: Path, name: str) -> None:
    path = written(bench_log, tmp_path)
    with_member(path, name, array_of("(1,)", 8))
    with pytest.raises(LogError, match="not a log of `prefplan run`: it holds"):
        read_log(path)


@pytest.mark.parametrize(
    ("shape", "size", "words"),
    [
        ("(1,)", 2**30, "too large: its arrays have 102[4-9] MiB"),
        ("(200000000,)", 8, "broken"),
        ("(134217728,)", 2**30, "too large: its arrays have 102[4-9] MiB"),
    ],
)
def test_nothing_is_unpacked_beyond_what_the_archive_says_and_a_log_may_have(
    bench_log: Log, tmp_path: Path, shape: str, size: int, words: str
) -> None:
    """A file of 1 MB that unpacks to 1 GB costs next to no memory."""
    path = written(bench_log, tmp_path)
    without(path, "times.npy")
    with_member(path, "times.npy", array_of(shape, size))
    assert path.stat().st_size < 3e6
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(LogError, match=words):
        read_log(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000


EASY = "<mujoco/>"


@pytest.mark.parametrize(
    "name", ["z/../bench.xml", "./bench.xml", "/bench.xml", "a//b.xml", "../a/../../b.xml", "b\0.xml", "C:\\b.xml"]
)
def test_the_name_of_a_file_is_normal(bench_log: Log, name: str) -> None:
    with pytest.raises(LogError, match="no valid path"):
        certify(files_of(bench_log, **{name: packed(EASY)}))


@pytest.mark.parametrize("name", ["more.xml", "../above/bench.xml", "../bench.xml"])
def test_its_files_are_exactly_those_that_its_scenario_names(bench_log: Log, name: str) -> None:
    with pytest.raises(LogError, match="held or named, but not both|cannot be unpacked"):
        certify(files_of(bench_log, **{name: packed(EASY)}))


def renamed(log: Log, name: str) -> Log:
    return telling(log, text=log.about.text.replace('"bench.xml"', f'"{name}"'))


@pytest.mark.parametrize("name", ["../../../../../../../../etc/passwd", "/etc/passwd", "lab.xml", "../bench.xml"])
def test_a_scene_that_the_log_does_not_hold_is_not_read(bench_log: Log, name: str) -> None:
    with pytest.raises(LogError, match="does not hold the file|must be a path"):
        certify(renamed(bench_log, name))


@pytest.mark.parametrize(
    ("attribute", "refused"),
    [
        ('<include file="{0}/secret.xml"/>', "is no relative path"),
        ('<include file="{1}/secret.xml"/>', "lead too far up|MuJoCo|file|XML"),
        ('<compiler meshdir="{0}"/><asset><mesh name="m" file="secret.stl"/></asset>', "is no relative path"),
        ('<asset><texture name="t" type="cube" fileback="{0}/secret.png"/></asset>', "is no relative path"),
    ],
)
def test_a_file_of_the_log_names_no_file_outside(
    bench_log: Log, tmp_path: Path, attribute: str, refused: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret = tmp_path / "secret"
    secret.mkdir()
    (secret / "secret.xml").write_text(EASY)
    folder = tmp_path / "tmp"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    bundle._unpacked.cache_clear()
    up = "../" * 3 + "secret"
    scene = base64.b64decode(bench_log.about.files["bench.xml"]).decode()
    forged = scene.replace('<include file="light.xml"/>', '<include file="light.xml"/>' + attribute.format(secret, up))
    with pytest.raises(LogError, match=refused):
        certify(files_of(bench_log, **{"bench.xml": packed(forged)}))


def test_broken_xml_is_refused(bench_log: Log) -> None:
    with pytest.raises(LogError, match="no valid XML"):
        certify(files_of(bench_log, **{"bench.xml": packed("<mujoco><include")}))


def test_a_temporary_folder_behind_a_link_breaks_nothing(
    bench_log: Log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "real").mkdir()
    os.symlink(tmp_path / "real", tmp_path / "link")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "link"))
    bundle._unpacked.cache_clear()
    assert certify(bench_log).confirmed
    assert list((tmp_path / "real").iterdir()), "it was used"


def test_an_encrypted_member_is_refused(bench_log: Log, tmp_path: Path) -> None:
    path = written(bench_log, tmp_path)
    contents = bytearray(path.read_bytes())
    for mark, flag in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        place = contents.find(mark)
        contents[place + flag] |= 1
    path.write_bytes(contents)
    with pytest.raises(LogError, match="broken"):
        read_log(path)


Forge = Callable[[Log], Log]


def test_the_honest_log_is_read_and_holds(bench_log: Log, tmp_path: Path) -> None:
    log = read_log(written(bench_log, tmp_path))
    assert certify(replace(log)).confirmed and np.array_equal(log.qpos, bench_log.qpos)
