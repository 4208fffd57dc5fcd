"""Everything the README shows is run here as a reader would run it; only rendering and make's targets are spared."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from documents import ROOT, blocks, environment, save, shell

README = ROOT / "README.md"
BLOCKS = blocks(README)


def written_in(language: str) -> list[str]:
    return [block.text for block in BLOCKS if block.language == language]


COMMANDS = [line for block in written_in("sh") for line in block.splitlines()]
MAKE = [line for line in COMMANDS if line.startswith("make")]
VIEW = [line for line in COMMANDS if line.startswith("prefplan view")]
PROGRAM = [line for line in COMMANDS if line not in MAKE + VIEW]
SNIPPETS = [block.text for block in BLOCKS if block.language == "python" and not block.file_name]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A reader's folder, with every file that the README says to save."""
    save(BLOCKS, tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("command", PROGRAM)
def test_every_command_works(command: str, folder: Path) -> None:
    if " run " in command and "--no-video" not in command:
        command += " --no-video"
    done = shell(command, folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("command", VIEW)
def test_every_view_can_be_looked_at_until_it_is_ended(command: str, folder: Path) -> None:
    pipe = subprocess.PIPE
    command = f"exec {command} --no-browser --port 0"
    with subprocess.Popen(["sh", "-c", command], cwd=folder, env=environment(), stdout=pipe, stderr=pipe) as program:
        assert program.stdout is not None
        try:
            address = re.search(rb"http://[0-9.:]+", program.stdout.readline())
            if address:
                assert b"<title>" in urllib.request.urlopen(address[0].decode(), timeout=60).read()
            program.send_signal(signal.SIGINT)
            _, errors = program.communicate(timeout=60)
        finally:
            program.kill()
    assert address and program.returncode == 0, errors


@pytest.mark.parametrize("command", MAKE)
def test_every_target_of_make_exists(command: str) -> None:
    done = subprocess.run([*command.split(), "-n"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("code", SNIPPETS)
def test_every_snippet_runs(code: str, folder: Path) -> None:
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_first_snippet_prints_what_is_shown(folder: Path) -> None:
    done = subprocess.run([sys.executable, "-c", SNIPPETS[0]], cwd=folder, capture_output=True, text=True)
    assert done.stdout and done.stdout in written_in("text")


def test_the_front_is_the_one_shown(folder: Path) -> None:
    (shown,) = (block for block in written_in("text") if block.startswith("┏"))
    printed = shell("FORCE_COLOR=1 TERM=dumb prefplan front tidy.toml", folder).stdout  # as on a terminal
    assert shown in printed


def test_the_pictures_are_there_and_light() -> None:
    pictures = [ROOT / name for name in re.findall(r"!\[.*?\]\((.*?)\)", README.read_text(encoding="utf-8"))]
    assert pictures
    assert sum(picture.stat().st_size for picture in pictures) < 1_200_000
