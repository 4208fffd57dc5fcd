"""Completion, tried in the shells themselves where they are installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import Run

from experiments import scenarios
from experiments.commands.command_line import FOLDERS

SHELLS = ("bash", "fish", "zsh")

BASH = """
source ./script
complete_words() {
  COMP_WORDS=("$@"); COMP_CWORD=$(( $# - 1 )); COMPREPLY=()
  $(complete -p prefplan | sed 's/.*-F \\([^ ]*\\).*/\\1/') prefplan
  printf '%s\\n' "${COMPREPLY[@]}"
}
complete_words """


@pytest.fixture
def folder(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scenario, another file and a subfolder; shells find this program."""
    (tmp_path / "extra.toml").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "sub").mkdir()
    program = tmp_path / "sub" / "prefplan"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m experiments.program "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)
    return tmp_path


def script(shell: str) -> str:
    """Return what a shell reads at its start."""
    asked = os.environ | {"_PREFPLAN_COMPLETE": f"{shell}_source"}
    command = [sys.executable, "-m", "experiments.program"]
    done = subprocess.run(command, env=asked, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return done.stdout


def offered(folder: Path, shell: str, *words: str) -> set[str]:
    """Return the completions that a shell offers for the last of these words."""
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    (folder / "script").write_text(script(shell))
    quoted = " ".join(f"'{word}'" for word in ("prefplan", *words))
    code = BASH + quoted if shell == "bash" else f'source ./script; complete -C "prefplan {" ".join(words)}"'
    done = subprocess.run([shell, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    return {line.split("\t")[0] for line in done.stdout.splitlines() if line}


@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_commands_are_offered(folder: Path, shell: str) -> None:
    assert offered(folder, shell, "") >= set(FOLDERS)
    assert offered(folder, shell, "fr") == {"front"}


@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_scenarios_that_ship_and_scenario_files_are_offered(folder: Path, shell: str) -> None:
    found = offered(folder, shell, "front", "")
    assert found >= {*scenarios.names(), "extra.toml", "sub/"}
    assert "notes.txt" not in found
    assert offered(folder, shell, "front", "ex") == {"example", "extra.toml"}


def test_bash_puts_no_space_behind_a_folder() -> None:
    assert "complete -o nosort -o filenames -F" in script("bash")


@pytest.mark.parametrize("shell", ["bash", "fish"])
def test_options_and_their_choices_are_offered(folder: Path, shell: str) -> None:
    assert offered(folder, shell, "plan", "example", "--obj") == {"--objective"}
    assert offered(folder, shell, "plan", "example", "--objective", "") == {"cost", "preference"}


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_can_read_its_script(folder: Path, shell: str) -> None:
    text = script(shell)
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    (folder / "script").write_text(text)
    read = "source ./script"
    if shell == "zsh":
        read = 'autoload -Uz compinit; compinit -u -d ./dump; eval "$(<./script)"; (( ${+_comps[prefplan]} ))'
    done = subprocess.run([shell, "-c", read], cwd=folder, capture_output=True, text=True, check=True)
    assert done.stderr == ""
