"""The program as a whole: wrong calls, mistakes in scenarios, exit statuses, and how it starts and ends."""

from __future__ import annotations

import io
import itertools
import json
import os
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import click
import pytest
from command_line import Run, assert_is_error
from scenario_texts import CUP, DETOUR

import prefplan
from experiments import commands
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner
from experiments.cli.status import QUIET
from experiments.program import main as start
from prefplan.models import kernels


@pytest.mark.parametrize("command", ["front", "plan", "check"])
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
        ("case_study_11", "'case_study_11' ships or is in this folder (did you mean 'case_study_1'?)"),
        ("detuor", "'detuor' ships or is in this folder (did you mean 'detour'?)"),
        ("nowhere.toml", "nowhere.toml: no such file"),
        ("far/away", "far/away: no such file"),
        (".", ".: cannot be read"),
    ],
)
def test_a_scenario_that_does_not_exist(run: Run, detour: Path, scenario: str, message: str) -> None:
    assert_is_error(run("front", scenario), message)


def test_only_files_that_are_scenarios_are_suggested_for_one_that_does_not_exist(run: Run, detour: Path) -> None:
    (detour.parent / "pyproject.toml").write_text('[project]\nname = "tidy"\n')
    (detour.parent / "costs.toml").write_text("[model]\n")
    (detour.parent / "broken.toml").write_text("[model\n")
    result = run("front", "zzzz")
    assert_is_error(result, "(valid: case_study_1, ")
    assert "detour" in result.err and not any(name in result.err for name in ("pyproject", "costs", "broken"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["frnot", "example"], "No such command 'frnot'. Did you mean 'front'?"),
        (["--verison"], "No such option '--verison'. Did you mean '--version'?"),
        (["front"], "SCENARIO"),
        (["front", "example", "--jsn"], "No such option '--jsn'. Did you mean '--json'?"),
        (["front", "example", "more"], "unexpected extra argument (more)"),
        (["front", "example", "--max-cost", "-1"], "'-1' is not a number >= 0"),
        (["front", "example", "--max-cost", "cheap"], "'cheap' is not a number >= 0"),
        (["front", "example", "--max-cost", "nan"], "'nan' is not a number >= 0"),
        (["plan", "example", "--max-preference"], "--max-preference"),
    ],
)
def test_a_wrong_call_is_told_on_stderr_with_the_call_that_shows_the_usage(
    run: Run, arguments: list[str], message: str
) -> None:
    result = run(*arguments)
    assert_is_error(result, message)
    name = "prefplan" if arguments[0] in ("frnot", "--verison") else f"prefplan {arguments[0]}"
    assert result.err.startswith(f"{name}: ")
    assert "usage: " not in result.err and result.err.endswith(f"\nUsage: `{name} --help`\n")


@pytest.mark.parametrize("arguments", [[], ["--help"], ["front", "--help"]])
def test_help_is_no_error(run: Run, arguments: list[str]) -> None:
    result = run(*arguments)
    assert (result.status, result.err) == (0, "")
    assert "Usage: prefplan" in result.out


def test_the_version_is_that_of_the_package(run: Run) -> None:
    assert prefplan.__version__ == metadata.version("prefplan")
    assert run("--version") == (0, f"prefplan {prefplan.__version__}\n", "")


def test_what_was_never_installed_has_no_version(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> str:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", absent)
    assert run("--version") == (0, "prefplan unknown\n", "")


NO_SIMULATION = """
import sys
sys.modules.update(dict.fromkeys(sys.argv.pop(1).split()))
from experiments.program import main
for call in sys.argv[1:]:
    sys.argv[1:] = call.split()
    print(main())
"""


@pytest.mark.parametrize("absent", ["mujoco", "mujoco mink"])
def test_only_what_needs_the_simulation_asks_to_install_it(absent: str, tmp_path: Path) -> None:
    (tmp_path / "cup.toml").write_text(CUP)
    calls = ["run cup", "verify run.npz", "check cup -q", "report example -q"]
    command = [sys.executable, "-c", NO_SIMULATION, absent, *calls]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert re.findall(r"^\d+$", done.stdout, re.MULTILINE) == ["4", "4", "0", "0"]
    install = "pip install '.[sim]', in a clone of prefplan"
    assert done.stderr == "".join(f"prefplan: {call} needs the simulation: {install}\n" for call in ("run", "verify"))


def test_a_name_that_the_package_does_not_have_is_an_attribute_error() -> None:
    assert not hasattr(prefplan, "nonsense") and not hasattr(prefplan, "__nonsense__")
    assert {"Planner", "load", "__version__"} <= set(dir(prefplan))


def test_an_interrupt_has_its_own_status(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("prefplan.load", interrupted)
    result = run("front", "example")
    assert result.status == 130
    assert "Traceback" not in result.err


def test_a_path_names_a_scenario_with_or_without_its_ending(
    run: Run, detour: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (detour.parent / "detour").mkdir()
    assert run("plan", "detour").status == 0
    monkeypatch.chdir(detour.parent / "detour")
    for name in ("../detour.toml", "../detour", str(detour)):
        assert run("plan", name).status == 0


@pytest.mark.parametrize("arguments", [["--quiet", "plan", "example"], ["plan", "example", "-q"]])
def test_a_quiet_command_shows_its_result_and_no_progress(
    run: Run, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    monkeypatch.setattr("prefplan.warm_up.is_compiled", lambda: False)
    result = run(*arguments)
    assert (result.status, result.err) == (0, "") and "cost 6" in result.out


def context(*, quiet: bool) -> click.Context:
    """Return the context of a command that is called with or without `-q`."""
    found = click.Context(click.Command("any"))
    found.meta.update({QUIET: True} if quiet else {})
    return found


@pytest.mark.parametrize("quiet", [False, True])
def test_compiling_is_announced_when_it_begins(
    quiet: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("prefplan.warm_up.is_compiled", lambda: False)
    monkeypatch.setattr(kernels, "loading", kernels.loading)
    with context(quiet=quiet):
        load_planner()
    with kernels.loading():
        pass
    assert ("compiling" in capsys.readouterr().err) is not quiet


def test_quiet_bars_are_not_drawn(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    for quiet in (False, True):
        with context(quiet=quiet), Bars() as bars:
            bars("planning", 1, 2, "")
        assert ("planning" in capsys.readouterr().err) is not quiet


def test_what_is_printed_beside_bars_stays_on_stdout(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    with Bars() as bars:
        bars("planning", 0, 0, "")
        print("{}")
    assert capsys.readouterr().out == "{}\n"


def test_a_bar_says_how_much_time_is_left_until_its_stage_ends_and_shows_brackets(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    clock = itertools.count()
    with Bars() as bars:
        bars.get_time = lambda: float(next(clock))
        for done in range(4):
            bars("rendering", 100 * done, 400, "")
        assert "left" in drawn(bars, capsys)
        bars("rendering", 400, 400, "")
        assert "left" not in drawn(bars, capsys)
        bars("checking", 0, 0, "the [b]log")
        last = drawn(bars, capsys)
        assert "left" not in last and "the [b]log" in last


def drawn(bars: Bars, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the bars as they are drawn next."""
    capsys.readouterr()
    bars.refresh()
    return capsys.readouterr().err


@pytest.fixture
def program() -> list[str]:
    """The installed script, or its module if the script is not on this machine's path."""
    script = Path(sys.executable).with_name("prefplan")
    return [str(script)] if script.exists() else [sys.executable, "-m", "prefplan"]


def test_the_program_works_from_any_folder_and_every_process_finds_the_same_plans(
    program: list[str], tmp_path: Path, run: Run
) -> None:
    """The order of sets differs between processes; plans must not."""
    done = subprocess.run(
        [*program, "front", "case_study_3", "--json"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONHASHSEED": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    front = json.loads(done.stdout)["front"]
    assert [(point["cost"], point["preference"]) for point in front] == [(34, 17), (41, 0)]
    assert front == run("front", "case_study_3", "--json").json["front"]


@pytest.mark.parametrize("arguments", [["list"], ["--help"]])
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


def test_letters_that_the_output_cannot_encode_are_escaped(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    scenario = tmp_path / "café.toml"
    scenario.write_text((Path(commands.__file__).parents[1] / "scenarios" / "example.toml").read_text())
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding="ascii"))
    monkeypatch.setattr(sys, "argv", ["prefplan", "front", str(scenario)])
    assert start() == 0
    assert written.getvalue().startswith(b"caf\\xe9: Pareto front")


LOADED = """
import sys
from experiments.program import main
sys.argv[1:] = sys.argv[2:]
status = main()
heavy = {"numpy", "numba", "matplotlib", "jinja2", "networkx", "scipy.linalg", "cffi", "yaml"} & set(sys.modules)
print(status, sorted(heavy), file=sys.stderr)
"""


@pytest.mark.parametrize(
    ("call", "status"),
    [("", 0), ("--help", 0), ("list", 0), ("frnot", 2), ("front --help", 0), ("run case_study_3 --jsn", 2)],
)
def test_what_needs_no_planner_does_not_load_it(call: str, status: int, tmp_path: Path) -> None:
    command = [sys.executable, "-c", LOADED, "prefplan", *call.split()]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1] == f"{status} []"


@pytest.mark.parametrize(("scenario", "loaded"), [("example", ["numpy"]), ("case_study_1", ["numba", "numpy"])])
def test_a_front_loads_only_what_it_is_searched_with(scenario: str, loaded: list[str], tmp_path: Path) -> None:
    command = [sys.executable, "-c", LOADED, "prefplan", "front", scenario]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1] == f"0 {loaded}"
