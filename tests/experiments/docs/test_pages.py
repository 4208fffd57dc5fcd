"""Tutorial and guide, done page by page as a reader does it: what is printed is what the pages show."""

from __future__ import annotations

import contextlib
import doctest
import io
import json
import os
import re
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from documents import ROOT, Block, blocks, save, shell

PAGES = [
    ROOT / "docs" / f"{name}.md"
    for name in (
        "tutorial/first_grid",
        "tutorial/own_preference",
        "tutorial/partial_satisfaction",
        "tutorial/own_scene",
        "tutorial/regression_tests",
        "tutorial/cluster",
        "guide/scenarios",
        "guide/executions",
        "guide/report",
        "guide/json",
        "guide/extending",
    )
]
"""In the order in which they are read."""

FAST = ("first_grid", "own_preference", "partial_satisfaction", "extending")
"""Pages on which nothing is simulated."""

AS_ON_A_TERMINAL = {"FORCE_COLOR": "1", "TERM": "dumb", "PY_COLORS": "0"}

OUTPUT = ("text", "json")
"""Languages of blocks that show what is printed."""

SLURM = {"sbatch": 'exec sh "$1"', "srun": 'exec "$@"'}
"""What stands in for Slurm: the job runs here and now."""

PORT = "8786"
"""The pages use Dask's usual one; here another test may have taken it."""


def test_all_pages_are_done() -> None:
    folders = (ROOT / "docs" / "tutorial", ROOT / "docs" / "guide")
    assert sorted(PAGES) == sorted(page for folder in folders for page in folder.glob("*.md"))


@pytest.mark.parametrize(
    "page", [pytest.param(page, id=page.stem, marks=[pytest.mark.slow] * (page.stem not in FAST)) for page in PAGES]
)
def test_what_is_printed_is_what_is_shown(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for earlier in PAGES[: PAGES.index(page)]:
        save(blocks(earlier), tmp_path)
    if page.stem == "cluster":
        _install_slurm(tmp_path / "bin", monkeypatch)
    compare = doctest.OutputChecker().check_output
    shown = 0
    for block, printed in done_in_order(blocks(page), tmp_path):
        if block is None:
            continue
        if block.language == "json":
            assert_alike(json.loads(block.text), json.loads(printed))
        else:
            assert compare(block.text, printed, doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE), printed
        shown += 1
    assert shown, "the page shows no output"


def done_in_order(page: list[Block], folder: Path) -> Iterator[tuple[Block | None, str]]:
    """Do what a page says; yield what was printed, with the block that shows it, if one follows."""
    names: dict[str, Any] = {"__name__": "reader"}
    port = str(_free_port())
    for block, following in zip(page, [*page[1:], Block("", "")], strict=True):
        if block.file_name:
            save([block], folder)
        elif block.language in ("sh", "python"):
            if block.language == "sh":
                script = re.sub(r"(prefplan run [^|&\n]*\.toml(?! --no-video))", r"\1 --no-video", block.text)
                if "||" in script:  # a mistake is shown, and what is said of it
                    script = f"exec 2>&1\n{script}"
                done = shell(script.replace(PORT, port), folder, **AS_ON_A_TERMINAL)
                assert done.returncode == 0, done.stdout + done.stderr
                printed = done.stdout
            else:
                with contextlib.redirect_stdout(io.StringIO()) as out:
                    exec(compile(block.text, "page", "exec"), names)
                printed = out.getvalue()
            yield (following if following.language in OUTPUT else None), printed.replace(port, PORT)
        else:
            assert block.language in OUTPUT, f"nothing is done with {block.language}, and it is no file:\n{block.text}"


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


def _install_slurm(programs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    programs.mkdir()
    for name, script in SLURM.items():
        (programs / name).write_text(f"#!/bin/sh\n{script}\n")
        (programs / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")


def _free_port() -> int:
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        port: int = server.getsockname()[1]
        return port
