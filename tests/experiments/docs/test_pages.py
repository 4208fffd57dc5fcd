"""README, tutorial and guide, done as a reader does: save the files, run the commands, compare what is printed."""

from __future__ import annotations

import contextlib
import doctest
import io
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from command_line import main, parsed

from experiments.sweep import job, workers
from experiments.viewer import session
from sim.execution import cost_measurement
from sim.execution.cost_measurement import Measurement, Pair, Trial
from sim.world.scene import Scene

ROOT = Path(__file__).parents[3]

PAGES = [
    ROOT / f"{name}.md"
    for name in (
        "README",
        "docs/guide/installation",
        "docs/tutorial/first_grid",
        "docs/tutorial/own_preference",
        "docs/tutorial/partial_satisfaction",
        "docs/tutorial/own_scene",
        "docs/tutorial/regression_tests",
        "docs/guide/scenarios",
        "docs/guide/executions",
        "docs/guide/report",
        "docs/guide/why",
        "docs/guide/json",
        "docs/guide/extending",
    )
]
"""The pages, in reading order."""

FAST = ("first_grid", "own_preference", "partial_satisfaction", "extending")
"""Pages without simulation."""

FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)

AS_ON_A_TERMINAL = {"FORCE_COLOR": "1", "TERM": "dumb", "PY_COLORS": "0"}

OUTPUT = ("text", "json")
"""Languages of blocks that show what is printed."""

EXTRAS = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"])
"""What may be installed with prefplan."""


def run_pytest(arguments: list[str]) -> int:
    return pytest.main(["-p", "no:unraisableexception", *arguments])  # it collects garbage for seconds


IN_THIS_PROCESS: dict[str, Callable[[list[str]], int]] = {"prefplan": main, "python -m pytest": run_pytest}
"""Programs that are called as functions."""

FOR_A_SHELL = re.compile(r"[|&<>$]")

READ_ONLY = (
    r"prefplan run (case_study_3|.* --camera) |MUJOCO_GL|"
    r"prefplan (report|draw|export|view|doctor)\b"
)
"""Commands that have separate tests or are run on a later page, and produce nothing that a page needs: only their
arguments are parsed."""

MISTAKE = ' || echo "exit status $?"'
"""Ends a line that shows a mistake, and what is said of it."""


@dataclass(frozen=True)
class Block:
    """A block of code on a page."""

    language: str
    text: str

    @property
    def file_name(self) -> str | None:
        """The file that the block is to be saved as: its first comment begins with the name."""
        match = re.match(r"(?:#!.*\n)?# (\w+\.\w+)", self.text)
        return match[1] if match else None


def blocks(page: Path) -> list[Block]:
    """Return the blocks of a page in order."""
    return [Block(language, text) for language, text in FENCE.findall(page.read_text(encoding="utf-8"))]


def save(page: list[Block], folder: Path) -> None:
    """Save the files that a page says to save."""
    for block in page:
        if block.file_name:
            (folder / block.file_name).write_text(block.text, encoding="utf-8")


def test_all_pages_are_done() -> None:
    folders = (ROOT / "docs" / "tutorial", ROOT / "docs" / "guide")
    assert sorted(PAGES[1:]) == sorted(page for folder in folders for page in folder.glob("*.md"))


@pytest.mark.parametrize(
    "page", [pytest.param(page, id=page.stem, marks=[pytest.mark.slow] * (page.stem not in FAST)) for page in PAGES]
)
def test_what_is_printed_is_what_is_shown(page: Path, reader: Path) -> None:
    for earlier in PAGES[: PAGES.index(page)]:
        save(blocks(earlier), reader)
    compare = doctest.OutputChecker().check_output
    shown = 0
    for block, printed in done_in_order(blocks(page), reader):
        if block is None:
            continue
        if block.language == "json":
            assert_alike(json.loads(block.text), json.loads(printed))
        else:
            assert compare(block.text, printed, doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE), printed
        shown += 1
    assert shown, "the page shows no output"


@pytest.mark.parametrize("page", [pytest.param(page, id=page.stem) for page in PAGES[1:]])
def test_commands_show_what_they_print(page: Path) -> None:
    after = [*blocks(page)[1:], Block("", "")]
    for block, following in zip(blocks(page), after, strict=True):
        if block.language != "sh" or block.file_name:
            continue
        lines = re.split(r"\n| && ", block.text.strip())
        prints = any(line.startswith("prefplan ") and not re.match(READ_ONLY, line) for line in lines)
        assert following.language in OUTPUT or not prints, f"what does this print?\n{block.text}"


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that a reader works in, with the program of this working tree on the path."""
    monkeypatch.chdir(tmp_path)
    path = [str(Path(sys.executable).parent), os.environ["PATH"]]
    for name, value in {**AS_ON_A_TERMINAL, "PATH": os.pathsep.join(path), "PYTHONPATH": str(ROOT)}.items():
        monkeypatch.setenv(name, value)
    # The tests of sweeps have their processes; here each process would load the simulation once more.
    monkeypatch.setattr(workers, "on_this_machine", rolled_out_alike)
    monkeypatch.setattr(cost_measurement, "measure_all", measured_alike)
    # What a browser makes of it, the tests of the viewer see.
    monkeypatch.setattr(session, "watch", lambda *arguments, **options: None)
    return tmp_path


def rolled_out_alike(sweep: job.Sweep, numbers: Sequence[int], **options: Any) -> Iterator[job.Record]:
    """Carry out the last rollout only, and record the same for all others; each would take a second."""
    record = sweep.record(numbers[-1])
    return (record | {"rollout": number} for number in numbers)


def measured_alike(scene: Scene, wanted: Mapping[Pair, Sequence[Trial]], *, jobs: int) -> Iterator[Measurement]:
    """Measure the first action only, and record the same for all others; each would take a second."""
    pair, samples = next(iter(wanted.items()))
    measured = cost_measurement.measure(scene, pair, samples[:1])
    assert isinstance(measured, Measurement)
    return (replace(measured, pair=other) for other in wanted)


def done_in_order(page: list[Block], folder: Path) -> Iterator[tuple[Block | None, str]]:
    """Do what a page says; yield what was printed, with the block that shows it, if one follows."""
    names: dict[str, Any] = {"__name__": "reader"}
    for block, following in zip(page, [*page[1:], Block("", "")], strict=True):
        if block.file_name:
            save([block], folder)
        elif block.language in ("sh", "python"):
            shown = following.language in OUTPUT
            if block.language == "sh":
                printed = printed_by(block.text, shown=shown)
            else:
                with contextlib.redirect_stdout(io.StringIO()) as out:
                    exec(compile(block.text, "page", "exec"), names)
                printed = out.getvalue()
            yield (following if shown else None), printed
        else:
            assert block.language in OUTPUT, f"nothing is done with {block.language}, and it is no file:\n{block.text}"


def printed_by(script: str, *, shown: bool) -> str:
    """Return what a script prints; videos, make's targets and installations are spared, and more if it is not shown."""
    return "".join(line_printed_by(line, shown=shown) for line in re.split(r"\n| && ", script.strip()))


def line_printed_by(line: str, *, shown: bool) -> str:
    if line.startswith("make "):
        subprocess.run([*line.split(), "-n"], cwd=ROOT, check=True, capture_output=True)
        return ""
    if line.startswith("pip install "):
        assert set(re.findall(r"\w+", line.partition("[")[2])) <= EXTRAS
        return ""
    if not shown and re.match(READ_ONLY, line):
        parsed(shlex.split(line.removeprefix("MUJOCO_GL=egl "))[1:])
        return ""
    line = re.sub(r"^prefplan run ", "prefplan run --no-video ", line)
    command = line.removesuffix(MISTAKE)
    program = next((name for name in IN_THIS_PROCESS if command.startswith(f"{name} ")), None)
    if program and not FOR_A_SHELL.search(command):
        return in_this_process(program, command.removeprefix(program), wrong=line.endswith(MISTAKE))
    return in_shell(line)


def in_this_process(program: str, words: str, *, wrong: bool) -> str:
    """Call a program in this process; another process would need a second or two to load everything."""
    out = io.StringIO()
    err = out if wrong else io.StringIO()  # a mistake is shown, and what is said of it
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = IN_THIS_PROCESS[program](shlex.split(words))
    assert bool(status) == wrong, f"{program} {words}\n{out.getvalue()}{err.getvalue()}"
    return out.getvalue() + (f"exit status {status}\n" if wrong else "")


def in_shell(script: str) -> str:
    """Run a script, and end what it leaves running in the background."""
    if "||" in script:  # a mistake is shown, and what is said of it
        script = f"exec 2>&1\n{script}"
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = subprocess.Popen(["sh", "-ec", script], stdout=out, stderr=err, start_new_session=True)
        try:
            status = process.wait()
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
        out.seek(0)
        err.seek(0)
        printed = out.read()
        assert status == 0, f"{script}\n{printed}{err.read()}"
        return printed


def assert_alike(shown: Any, real: Any) -> None:
    """Assert that two JSON values have the same keys in the same order; of lists, as much as is shown."""
    if isinstance(shown, dict):
        assert list(shown) == list(real)
        for key in shown:
            assert_alike(shown[key], real[key])
    elif isinstance(shown, list):
        for one, other in zip(shown, real, strict=False):
            assert_alike(one, other)
    else:
        assert isinstance(real, (int, float) if isinstance(shown, (int, float)) else type(shown))


def test_the_pictures_of_the_readme_are_there_and_light() -> None:
    pictures = [ROOT / name for name in re.findall(r"!\[.*?\]\((docs/.*?)\)", PAGES[0].read_text(encoding="utf-8"))]
    assert pictures
    assert sum(picture.stat().st_size for picture in pictures) < 1_200_000
