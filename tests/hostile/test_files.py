"""What is written stays whole: one writer a folder, a full disk, and what a killed process leaves."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from scenario_texts import CUP

from experiments.cli.files import make_folder, only_writer
from experiments.cli.journal import Journal
from experiments.commands.command_line import main
from prefplan.errors import PrefplanError

PROGRAM = [sys.executable, "-c", "import sys; from experiments.commands.command_line import main; sys.exit(main())"]

DEAD = 2**22 - 3
"""Number of no process: greater than the kernel's usual most."""


@pytest.fixture
def cup(tmp_path: Path) -> Path:
    path = tmp_path / "cup.toml"
    path.write_text(CUP)
    return path


@pytest.mark.parametrize("command", [["run", "--no-video"], ["report", "--no-video"], ["sweep", "--rollouts", "1"]])
def test_a_folder_has_one_writer(
    command: list[str], cup: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    descriptor = os.open(out, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        assert main(["-q", command[0], str(cup), *command[1:], "--out", str(out)]) == 2
    finally:
        os.close(descriptor)
    told = capsys.readouterr().err
    assert told == f"prefplan: {out}: another process is writing to it; wait for it or give another --out\n"
    assert list(out.iterdir()) == []


def test_a_writer_lets_go_of_its_folder(tmp_path: Path) -> None:
    with only_writer(tmp_path), pytest.raises(PrefplanError, match="another process"), only_writer(tmp_path):
        pass
    with only_writer(tmp_path):
        pass


def test_what_a_killed_process_left_is_removed_and_nothing_else(tmp_path: Path) -> None:
    left = [
        f".cost.npz.{DEAD}.part",
        f".cost.json.{DEAD}.part",
        f".video-{DEAD}-x1/0.mp4",
        f".clip-{DEAD}-x2/whole.mp4",
    ]
    kept = [f".cost.npz.{os.getpid()}.part", f".video-{os.getpid()}-x/0.mp4", ".bashrc", f".notes.{DEAD}", "a.part"]
    for name in (*left, *kept):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"half")
    make_folder(tmp_path)
    assert {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()} == set(kept)


@pytest.mark.parametrize("command", [["front", "example"], ["front", "example", "--json"], ["list"], ["--help"]])
def test_a_full_disk_is_told_in_a_sentence(command: list[str]) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*PROGRAM, "-q", *command], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 4
    assert done.stderr == "prefplan: cannot be written: standard output (No space left on device)\n"


def test_results_for_which_there_is_no_space_have_the_status_of_a_full_disk(tmp_path: Path) -> None:
    limit = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200));"
    command = [PROGRAM[0], PROGRAM[1], limit + PROGRAM[2], "-q", "report", "example", "--out", str(tmp_path)]
    # Python itself does not notice that a file of its cache is incomplete.
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 4 and re.fullmatch(r"prefplan: .*: cannot be written \(File too large\)\n", done.stderr)
    assert not (tmp_path / "index.html").exists()


@pytest.mark.parametrize(("command", "status"), [(["front", "nowhere.toml"], 2), (["plan", "example", "--rush"], 2)])
def test_a_message_that_cannot_be_written_changes_no_status(command: list[str], status: int) -> None:
    with open("/dev/full", "w") as full:
        assert subprocess.run([*PROGRAM, *command], stdout=subprocess.DEVNULL, stderr=full).returncode == status


def test_a_journal_on_a_full_disk_says_so_and_loses_nothing(tmp_path: Path) -> None:
    path = tmp_path / "rollouts.jsonl"
    code = f"""
import resource, signal
from experiments.cli.journal import Journal
from prefplan.errors import PrefplanError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))
try:
    records = Journal({str(path)!r}, {{"prefplan": "1"}}, key="rollout")
    for i in range(100):
        records.add({{"rollout": i}})
except PrefplanError as error:
    print(error)
"""
    code = code.replace(f"Journal({str(path)!r}", f"Journal(__import__('pathlib').Path({str(path)!r})")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stderr == "" and done.stdout.startswith(f"{path}: cannot be written (")
    assert len(Journal(path, {"prefplan": "1"}, key="rollout").done) > 5


def test_a_scene_may_lie_under_any_path_in_any_locale(tmp_path: Path) -> None:
    from hostile_bench import write_bench

    folder = tmp_path / "büro_桌"
    write_bench(folder)
    for utf8 in ("0", "1"):
        environment = os.environ | {"LC_ALL": "C", "PYTHONUTF8": utf8, "PYTHONCOERCECLOCALE": "0"}
        command = [*PROGRAM, "-q", "check", str(folder / "bench.toml")]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "") and done.stdout.startswith("bench: a manipulation model")
