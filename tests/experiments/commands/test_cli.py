"""The program as a whole: wrong calls, mistakes in scenarios, exit statuses, and how it starts and ends."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from command_line import Run, assert_is_error
from scenario_texts import DETOUR

import prefplan
from experiments import commands


@pytest.mark.parametrize("command", ["front", "plan"])
@pytest.mark.parametrize("json_option", [[], ["--json"]])
def test_a_mistake_in_the_scenario_is_told_on_stderr(
    run: Run, detour: Path, command: str, json_option: list[str]
) -> None:
    detour.write_text(DETOUR.replace("F bread", "F braed"))
    result = run(command, "detour.toml", *json_option)
    assert_is_error(result, "detour.toml: tasks[1].formula: unknown proposition 'braed' (did you mean 'bread'?)")


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        ("case_study_11", "no scenario named 'case_study_11' (did you mean 'case_study_1'?)"),
        ("nowhere.toml", "nowhere.toml: no such file"),
        ("far/away", "far/away: no such file"),
        (".", ".: cannot be read"),
    ],
)
def test_a_scenario_that_does_not_exist(run: Run, scenario: str, message: str) -> None:
    assert_is_error(run("front", scenario), message)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "COMMAND"),
        (["frnot", "example"], "frnot"),
        (["front"], "SCENARIO"),
        (["front", "example", "--jsn"], "--jsn"),
        (["front", "example", "--max-cost", "-1"], "'-1' is not a number >= 0"),
        (["front", "example", "--max-cost", "cheap"], "'cheap' is not a number >= 0"),
        (["front", "example", "--max-cost", "nan"], "'nan' is not a number >= 0"),
        (["plan", "example", "--objective", "speed"], "speed"),
        (["plan", "example", "--max-preference"], "--max-preference"),
    ],
)
def test_a_wrong_call_is_told_on_stderr(run: Run, arguments: list[str], message: str) -> None:
    result = run(*arguments)
    assert_is_error(result, message)
    assert len(result.err.splitlines()) == 1 and "--help`" in result.err


@pytest.mark.parametrize("arguments", [["--help"], ["front", "--help"], ["plan", "--help"]])
def test_help_is_no_error(run: Run, arguments: list[str]) -> None:
    result = run(*arguments)
    assert (result.status, result.err) == (0, "")
    assert "usage: prefplan" in result.out


def test_the_version_is_that_of_the_package(run: Run) -> None:
    assert prefplan.__version__ == metadata.version("prefplan")
    assert run("--version") == (0, f"prefplan {prefplan.__version__}\n", "")


def test_what_was_never_installed_has_no_version(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> str:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", absent)
    assert run("--version") == (0, "prefplan unknown\n", "")


def test_the_package_is_a_program(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "prefplan", "plan", "nowhere"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("prefplan: no scenario named 'nowhere'")


NO_SIMULATION = "import sys; sys.modules['mujoco'] = None; from prefplan.__main__ import main; sys.exit(main())"


@pytest.mark.parametrize("call", ["run case_study_3", "verify run.npz"])
def test_without_the_simulation_a_sentence_says_how_to_install_it(call: str, tmp_path: Path) -> None:
    command = [sys.executable, "-c", NO_SIMULATION, *call.split()]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (4, "")
    install = "pip install '.[sim]', in a clone of prefplan"
    assert done.stderr == f"prefplan: {call.split()[0]} needs the simulation: {install}\n"


@pytest.mark.parametrize("call", ["check case_study_3", "report case_study_1"])
def test_planning_does_without_the_simulation(call: str, tmp_path: Path) -> None:
    command = [sys.executable, "-c", NO_SIMULATION, *call.split()]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_name_that_the_package_does_not_have_is_an_attribute_error() -> None:
    assert not hasattr(prefplan, "nonsense") and not hasattr(prefplan, "__nonsense__")
    assert {"Planner", "load", "__version__"} <= set(dir(prefplan))


def test_an_interrupt_has_its_own_status(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.scenarios.find", interrupted)
    result = run("front", "example")
    assert result.status == 130
    assert "Traceback" not in result.err


def test_a_path_names_a_scenario_from_another_folder(run: Run, detour: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (detour.parent / "deep").mkdir()
    monkeypatch.chdir(detour.parent / "deep")
    for name in ("../detour.toml", str(detour)):
        assert run("plan", name).status == 0


@pytest.fixture
def program() -> list[str]:
    """The installed script, or the module it starts where it is not on this machine's path."""
    script = Path(sys.executable).with_name("prefplan")
    return [str(script)] if script.exists() else [sys.executable, "-m", "prefplan"]


def test_the_program_works_from_any_folder(program: list[str], tmp_path: Path) -> None:
    done = subprocess.run(
        [*program, "front", "example", "--json"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert [(point["cost"], point["preference"]) for point in json.loads(done.stdout)["front"]] == [(6, 4), (9, 3)]


def test_every_process_finds_the_same_plans(program: list[str], tmp_path: Path) -> None:
    """The order of sets differs between processes; plans must not."""
    fronts = []
    for seed in ("1", "2"):
        done = subprocess.run(
            [*program, "front", "case_study_3", "--json"],
            cwd=tmp_path,
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        fronts.append(json.loads(done.stdout)["front"])
    assert fronts[0] == fronts[1]


@pytest.mark.parametrize("arguments", [["front", "example"], ["--help"]])
def test_a_reader_that_leaves_early_is_no_failure(program: list[str], tmp_path: Path, arguments: list[str]) -> None:
    """The pipe is closed before anything is written to it."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [*program, *arguments], cwd=tmp_path, stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")


def test_every_command_prints_through_the_console_that_knows_pipes() -> None:
    for file in Path(commands.__file__).parent.rglob("*.py"):
        assert "from rich.console import" not in file.read_text(encoding="utf-8"), file.name
