from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prefplan.claims import Claims
from prefplan.plan import Purchase
from sim.errors import LogError
from sim.evidence.log import ARRAYS, FORMAT, MORE_ARRAYS, About, Log, LoggedAction, encode, read_log
from sim.simulation.run import Event


@pytest.fixture
def log() -> Log:
    about = About(
        versions={"prefplan": "0.1.0"},
        scenario="cup",
        text="[model]\n",
        measured=(("transit", "home", "desk", 1.5),),
        robot="panda",
        setting={"seed": 3, "faults": ["slip@2"]},
        joints={"joint1": 0},
        actions=(LoggedAction("grasp cup", 0.0, 0.05, 1, ("holding_cup",)),),
        events=(Event(0.04, "grasped", {"object": "cup"}),),
        claims=Claims(True, 1.5, {"tidy": 1.5}, {"tidy": 0}, 2, (Purchase("tidy", 0, None, 3),)),
    )
    rows = np.arange(14.0).reshape(2, 7)
    return Log(
        about=about,
        times=np.array([0.0, 1 / 30]),
        qpos=rows,
        qvel=rows - 1,
        glow=np.array([-1, 0]),
        controls=np.array([[3, -4], [2**40, 1]]),
        interventions=np.array([[0, np.pi]]),
    )


@pytest.fixture
def path(log: Log, tmp_path: Path) -> Path:
    path = tmp_path / "cost.npz"
    path.write_bytes(encode(log))
    return path


def npz(**arrays: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


Rewrite = Callable[..., None]

NO_FRAMES = {
    "times": np.zeros(0),
    "glow": np.zeros(0, int),
    "qpos": np.zeros((7, 0), int),
    "qvel": np.zeros((7, 0), int),
}


@pytest.fixture
def rewrite(path: Path) -> Rewrite:
    """Return a function that changes parts of the file: arrays, or parts of its JSON; None leaves a part out."""

    def change(*, about: dict[str, Any] | None = None, **arrays: np.ndarray | None) -> None:
        with np.load(path) as archive:
            parts: dict[str, Any] = dict(archive)
        words = json.loads(parts["about"].tobytes()) | (about or {})
        words = {key: value for key, value in words.items() if value is not None}
        parts["about"] = np.frombuffer(json.dumps(words).encode(), dtype=np.uint8)
        parts |= arrays
        path.write_bytes(npz(**{name: array for name, array in parts.items() if array is not None}))

    return change


def test_what_is_written_is_read_back(log: Log, path: Path) -> None:
    found = read_log(path)
    assert found.about == log.about
    assert isinstance(found.about.claims.cost, float) and isinstance(found.about.actions[0].cost, int)
    for name in (*ARRAYS, *MORE_ARRAYS):
        assert np.array_equal(getattr(found, name), getattr(log, name))


def test_the_same_log_is_the_same_file(log: Log) -> None:
    assert encode(log) == encode(log)


def test_a_file_cut_short_is_told_wherever_it_is_cut(path: Path) -> None:
    whole = path.read_bytes()
    for share in np.linspace(0, 1, 40, endpoint=False):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(LogError, match="cost.npz: broken, or not a log"):
            read_log(path)


def test_flipped_bytes_never_pass_for_another_log(log: Log, path: Path) -> None:
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    told = 0
    for place in rng.integers(0, len(whole), 100):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            found = read_log(path)
        except LogError:
            told += 1
        else:
            assert found.about == log.about and np.array_equal(found.qpos, log.qpos)
    assert told > 50


@pytest.mark.parametrize(
    ("contents", "words"),
    [
        (b"", "broken, or not a log"),
        (b"PK\x05\x06" + bytes(18), "not a log of `prefplan run`"),
        (b"hello, world", "broken, or not a log"),
        (npy(np.zeros(3)), "not a log of `prefplan run`"),
        (npz(weights=np.zeros(3)), "not a log of `prefplan run`"),
    ],
)
def test_other_files_are_refused(path: Path, contents: bytes, words: str) -> None:
    path.write_bytes(contents)
    with pytest.raises(LogError, match=words) as told:
        read_log(path)
    assert "pickle" not in str(told.value)


def test_missing_files_and_folders_are_told(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="none.npz: no such file"):
        read_log(tmp_path / "none.npz")
    with pytest.raises(LogError, match="is a directory"):
        read_log(tmp_path)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"about": {"format": FORMAT + 1}}, f"a log of format {FORMAT + 1}; this version of prefplan reads {FORMAT}"),
        ({"about": {"format": None}}, "a log of format None"),
        ({"about": {"claims": None}}, "about.claims: field required"),
        ({"about": {"text": 3}}, "about.text: input should be a valid string"),
        ({"about": {"claims": {"completed": "perhaps"}}}, "about.claims.completed"),
        ({"about": {"actions": [{"action": "grasp cup"}]}}, "about.actions.0.start: field required"),
        ({"about": {"seed": float("inf")}}, "about is not the JSON it should be"),
        ({"about": {"seed": float("nan")}}, "about is not the JSON it should be"),
        ({"qvel": None}, "qvel is missing"),
        ({"qpos": np.zeros(2, int)}, "qpos has the shape"),
        ({"qvel": np.zeros(3, int)}, "qvel has the shape"),
        ({"controls": np.zeros(3, int)}, "controls has the shape"),
        ({"times": np.zeros(3)}, "qpos has the shape"),
        ({"qvel": np.zeros((2, 2))}, "qvel holds what is not a number"),
        ({"interventions": np.full((2, 2), np.nan)}, "interventions holds what is not a number"),
        ({"times": np.array(["a", "b"])}, "times holds what is not a number"),
        (NO_FRAMES, "not a single frame"),
    ],
)
def test_damaged_parts_are_told(path: Path, rewrite: Rewrite, parts: dict[str, Any], words: str) -> None:
    rewrite(**parts)
    with pytest.raises(LogError, match=words):
        read_log(path)


@pytest.mark.parametrize("words", [b"{", b"[1]", b"3", b"\xff", b"", b'{"cost": 1e999}'])
def test_an_account_that_is_none_is_told(path: Path, log: Log, words: bytes) -> None:
    arrays = {name: getattr(log, name) for name in ARRAYS}
    path.write_bytes(npz(about=np.frombuffer(words, dtype=np.uint8), **arrays))
    with pytest.raises(LogError, match="about is not the JSON"):
        read_log(path)


def test_the_account_is_plain_json(path: Path, log: Log) -> None:
    with np.load(path) as archive:
        words = json.loads(archive["about"].tobytes())
    assert words["format"] == FORMAT and set(words) == {"format", *asdict(log.about)}


def test_a_log_nested_too_deep_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "deep.npz", about=np.frombuffer(b"[" * 200_000, dtype=np.uint8))
    with pytest.raises(LogError, match="nested too deep"):
        read_log(tmp_path / "deep.npz")
