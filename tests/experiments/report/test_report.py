"""`prefplan report`: a folder with a page, and what it says when something failed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from command_line import Run, assert_is_error
from report_pages import ERRANDS, data, page, pictures_for_tests
from scenario_texts import PLACES, cup_scenario
from skill_runs import displaced

from experiments.commands.execution.report import _status
from experiments.report import recordings
from experiments.runs import run_plan
from prefplan import load
from prefplan.planner import Planner
from sim.errors import RenderingError
from sim.execution import executor

CUP = cup_scenario(places=PLACES | {"tray": '{ at = [0.45, -0.20], kind = "bin" }'})


@pytest.fixture
def report(run: Run, tmp_path: Path) -> Run:
    """Return a function that calls `prefplan report` in a folder with two small scenarios."""
    (tmp_path / "shelf.toml").write_text(CUP)
    (tmp_path / "errands.toml").write_text(ERRANDS)
    return partial(run, "report")


@pytest.fixture
def rendered() -> Iterator[list[Path]]:
    """The paths of the videos that are rendered, of a test picture."""
    with pictures_for_tests() as videos:
        yield videos


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["shelf.toml", "--plans", "1"], "--plans 1: the front has one plan, 0"),
        (["shelf.toml", "--plans", "0,x"], "'--plans': 'x' is not a valid integer"),
        (["shelf.toml", "--size", "321x200"], "must be even"),
        (["shelf.toml", "--quality", "fine"], "--quality: unknown name 'fine' (did you mean 'final'?)"),
        (["shelf.toml", "--size", "big"], "'big' is not a size such as 1280x720"),
        (["shelf.toml", "--out", "shelf.toml"], "shelf.toml: cannot be made"),
        (["errands.toml", "--seed", "1"], "--seed: only for the arm of a manipulation model, and errands.toml has a"),
        (["errands.toml", "--plans", "0"], "--plans: only for the arm of a manipulation model"),
    ],
)
def test_bad_input_is_told_in_a_sentence(report: Run, words: list[str], message: str) -> None:
    assert_is_error(report(*words), message)


def test_a_report_is_a_folder_that_needs_nothing_else(report: Run) -> None:
    result = report("errands.toml")
    assert (result.status, result.out, result.err) == (0, "out/errands/index.html\n", "")
    folder = Path("out", "errands")
    for source in re.findall(r'(?:src|href)="([^"#]*)"', page(folder)):
        assert source.startswith("data:") or (folder / source).is_file(), source
    own = [path for path in folder.rglob("*") if path.suffix in (".html", ".css", ".js")]
    assert not [path.name for path in own if re.search(r"""(?:src|href|url\(|@import)\W+https?:""", path.read_text())]
    assert sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) < 6_000_000


def test_the_page_holds_what_is_known_of_every_plan(report: Run) -> None:
    report("errands.toml", "--out", "here")
    found = data("here")
    assert [(plan["cost"], plan["preference"]) for plan in found["plans"]] == [(7, 5), (8, 0)]
    cheap, dear = found["plans"]
    assert dear["explanations"][0]["headline"] == (
        "1 more than the cheapest: it goes first to bank instead of post, so that pay is done before send."
    )
    assert dear["ledger"]["tasks"]["pay"] == {"states": [0, 0, 0, 1, 1, 1, 1, 1, 1]} | {
        "satisfied": 3,
        "advances": [3],
        "bought": [],
    }
    assert "Map of 4 by 3 cells with the robot's path of 7 moves through post, bank." in page("here")
    assert all(check["holds"] for check in dear["checks"])
    assert "Two errands, and the nearer one is not the one that is preferred first." in page("here")
    assert page("here").count('id="map-') == 2


def test_text_of_a_scenario_stays_text(report: Run, tmp_path: Path) -> None:
    (tmp_path / "evil.toml").write_text("# </script><script>alert(1)</script> & more\n" + ERRANDS)
    report("evil.toml")
    assert "<script>alert" not in page("out/evil")
    assert "&lt;/script&gt;" in page("out/evil")


def test_where_there_is_no_plan_the_page_says_why(report: Run, tmp_path: Path) -> None:
    (tmp_path / "never.toml").write_text(ERRANDS.replace("F post", "F (post & bank)"))
    result = report("never.toml")
    assert (result.status, result.out) == (3, "out/never/index.html\n")
    for text in (result.err, page("out/never")):
        assert "task send can never be satisfied" in text
    assert 'class="task blamed"' in page("out/never") and data("out/never")["plans"] == []


def test_a_cost_bound_is_passed_on(report: Run) -> None:
    assert report("errands.toml", "--max-cost", "7").status == 0
    assert [plan["cost"] for plan in data("out/errands")["plans"]] == [7]


def test_an_unfinished_front_is_called_so(report: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Planner.front
    monkeypatch.setattr(Planner, "front", lambda self, **options: whole(self, **options | {"max_seconds": 0}))
    result = report("case_study_1")
    assert "stopped by the time limit" in result.err
    assert "The search was not completed (stopped by the time limit" in page("out/case_study_1")
    assert "no plan costs less" not in page("out/case_study_1")


def test_plans_are_carried_out_and_certified(report: Run, rendered: list[Path]) -> None:
    result = report("shelf.toml", "--size", "64x36", "--seed", "4")
    assert (result.status, result.err) == (0, "")
    assert rendered == [Path("out/shelf/plan_0.mp4")]
    written = {path.name for path in Path("out", "shelf").iterdir()}
    assert written == {"index.html", "page"} | {f"plan_0.{end}" for end in ("json", "npz", "mp4", "certificate.json")}
    (plan,) = data("out/shelf")["plans"]
    run = plan["run"]
    assert (run["video"], run["completed"], run["as_planned"]) == ("plan_0.mp4", True, True)
    assert run["certificate"]["confirmed"] is True and run["certificate"]["setting"]["seed"] == 4
    assert len(plan["times"]) == len(plan["plan"]) == 4
    assert all(start < end for start, end in plan["times"])
    assert plan["ledger"]["tasks"]["tidy"]["satisfied"] == 4


def test_what_is_there_is_not_done_again(report: Run, rendered: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    report("shelf.toml", "--size", "64x36")
    before = data("out/shelf")
    with monkeypatch.context() as patch:
        patch.delattr(recordings, "run_plan")
        report("shelf.toml", "--size", "64x36")
        report("shelf.toml", "--no-video")
    assert data("out/shelf") == before
    with monkeypatch.context() as patch:
        patch.setattr(recordings, "run_plan", interrupted)
        for change in (["--seed", "1"], ["--size", "32x32"], ["--camera", "orbit"]):
            assert report("shelf.toml", "--size", "64x36", *change).status == 130, "it is done again"
    Path("out/shelf/plan_0.npz").write_bytes(b"torn")
    assert report("shelf.toml", "--no-video").status == 0
    assert data("out/shelf")["plans"][0]["run"]["video"] is None


def test_a_plan_is_kept_to_as_by_a_run_of_its_number(report: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a mismatch, a preferred plan is not given up for a cheap one."""
    chosen = []

    def noted(*arguments: Any, choice: str | int = "cost", **options: Any) -> Any:
        chosen.append(choice)
        raise KeyboardInterrupt

    monkeypatch.setattr(recordings, "run_plan", noted)
    assert report("shelf.toml", "--no-video").status == 130 and chosen == [0]


def interrupted(*arguments: Any, **options: Any) -> Any:
    raise KeyboardInterrupt


def test_ctrl_c_leaves_a_page_and_nothing_half_done(report: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executor.Execution, "step", interrupted)
    result = report("shelf.toml", "--no-video")
    assert result.status == 130 and "continues from here" in result.err
    assert data("out/shelf")["plans"][0]["run"] is None
    assert [path.name for path in Path("out/shelf").glob("plan_*")] == []


def test_ctrl_c_while_planning_leaves_a_page(report: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Planner, "_search", interrupted)
    result = report("errands.toml")
    assert result.status == 130
    assert "The search was not completed (interrupted" in page("out/errands")


def test_without_opengl_all_but_the_videos_is_there(report: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> None:
        raise RenderingError("no OpenGL here")

    monkeypatch.setattr(recordings, "check_rendering", none)
    result = report("shelf.toml")
    assert (result.status, result.err) == (0, "prefplan: no videos: no OpenGL here\n")
    (plan,) = data("out/shelf")["plans"]
    assert plan["run"]["video"] is None and plan["run"]["certificate"]["confirmed"] is True
    assert "no videos: no OpenGL here" in page("out/shelf")


def test_a_run_that_fails_is_shown_as_it_went(report: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_plan, "drawn", displaced(cup=(3.0, 0.0)))
    result = report("shelf.toml", "--no-video")
    run = data("out/shelf")["plans"][0]["run"]
    assert result.status == 4 and "execution of plan 0 failed" in result.err
    assert run["completed"] is False and run["as_planned"] is False
    assert run["reason"] in result.err


def test_one_run_that_fails_among_others_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    planner = Planner(load("example").problem())
    outcomes = {0: {"completed": True}, 1: {"completed": False, "reason": "the cup fell"}}
    assert _status(planner, planner.front(), outcomes, interrupted=False) == 4
    assert capsys.readouterr().err == "prefplan: execution of plan 1 failed the cup fell\n"
