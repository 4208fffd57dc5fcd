"""Reproduction of the paper: the page and the exit status say what agrees, what differs and what failed."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from experiments import case_study_1, case_study_2, reproduce_paper
from experiments.benchmark.runs import BARE, FRONT, MAX_MIN, SINGLE
from experiments.paper.study import AGREES, DIFFERS, ERRATUM, Study, show_alone
from experiments.paper.table import _speed_up
from experiments.runs import run_plan
from prefplan import PrefplanError, pareto_front
from prefplan.scenario.decode import load


def verdicts(study: Study) -> list[str]:
    return [finding.verdict for finding in study.findings]


def test_one_page_holds_everything_and_errata_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert reproduce_paper.main(["--quick", "--out", str(tmp_path)]) == 0
    printed = [line.split()[-1] for line in capsys.readouterr().out.splitlines() if line]
    found = [word for word in printed if word in (AGREES, ERRATUM, "measured")]
    three, times = [AGREES] * 3, ["measured"] * 3
    assert found == [AGREES, ERRATUM, AGREES, *[AGREES] * 6, *three, ERRATUM, *three, AGREES, *times, ERRATUM]
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    for title in ("Examples 1 to 3", "Case Study 1", "Case Study 2", "Case Study 3", "Table I"):
        assert f"<h2>{title}</h2>" in page
    assert DIFFERS not in page
    assert page.count("<img ") == 4
    assert all(address.startswith(("data:", "#")) for address in re.findall(r'(?:src|href)="([^"]*)"', page))
    names = {path.name for path in tmp_path.iterdir()}
    assert names >= {"figure_1.svg", "figure_3.svg", "figure_4.svg", "table_1.png"}


def test_an_erratum_that_cannot_be_confirmed_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = Study("Examples", "")
    monkeypatch.setattr(reproduce_paper, "PRINTED_PLAN", reproduce_paper.DRAWN_PLAN)
    reproduce_paper.examples(study, tmp_path)
    assert verdicts(study) == [AGREES, DIFFERS, AGREES]


def test_points_that_are_missing_and_points_too_many_differ() -> None:
    front = pareto_front(load("example").problem())
    study = Study("Figure 9", "")
    study.compare_front("Figure 9", [(5, 5), (9, 3)], front)
    missing, extra, same = study.findings
    assert (missing.what, missing.ours, missing.verdict) == ("Figure 9 (a)", "-", DIFFERS)
    assert (extra.what, extra.paper, extra.ours, extra.verdict) == ("not in the paper", "-", "cost 6, mu 4", DIFFERS)
    assert (same.what, same.verdict) == ("Figure 9 (b)", AGREES)


def test_what_differs_and_what_cannot_be_done_is_shown_and_ends_with_status_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(study: Study, out: Path) -> None:
        raise PrefplanError("the town is <closed>")

    monkeypatch.setattr(case_study_1, "PUBLISHED", ((68, 29), (70, 27), (72, 24), (74, 23), (84, 11), (98, 0)))
    monkeypatch.setattr(case_study_2, "reproduce", refuse)
    monkeypatch.setattr(Study, "draw", lambda *arguments: None)
    monkeypatch.setattr(reproduce_paper, "case_study_3", lambda study, out, *, simulate: None)  # not judged here
    assert reproduce_paper.main(["--quick", "--out", str(tmp_path)]) == 1
    said = capsys.readouterr()
    assert re.search(r"Figure 3 \(b\) +cost 70, mu 27 +- +DIFFERS", said.out)
    assert "Case Study 2: the town is <closed>" in said.out
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "Not everything agrees" in page and DIFFERS in page
    assert "could not be completed: the town is &lt;closed&gt;" in page


def test_the_heuristic_is_as_much_faster_as_the_times_say() -> None:
    bare = {(SINGLE, BARE, 4): 8.0, (FRONT, BARE, 4): 6.0, (SINGLE, BARE, 5): 90.0}  # a single plan goes further
    study = Study("Table I", "")
    _speed_up(study, bare | {(SINGLE, MAX_MIN, 4): 2.0, (FRONT, MAX_MIN, 4): 4.0})
    assert [(each.what, each.ours) for each in study.findings] == [
        ("heuristic, one plan of 4 tasks", "x 4 faster"),
        ("heuristic, front of 4 tasks", "x 1.5 faster"),
    ]


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("")
    assert reproduce_paper.main(["--quick", "--out", str(tmp_path / "taken")]) == 2
    assert "cannot be made" in capsys.readouterr().err


@pytest.mark.parametrize(("study", "figure"), [(case_study_1, "figure_3.svg"), (case_study_2, "figure_4.svg")])
def test_each_case_study_on_a_grid_is_a_script_of_its_own(
    study: ModuleType, figure: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert show_alone(Study(study.TITLE, study.ABOUT), study.reproduce) == 0
    verdicts = [line.split()[-1] for line in capsys.readouterr().out.splitlines() if line.split()]
    assert verdicts.count(AGREES) == len(study.PUBLISHED)
    name = study.__name__.rpartition(".")[2]
    assert Path("out", name, figure).exists()


def test_plans_of_case_study_3_are_carried_out_and_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the preferred plan up to the first release; `prefplan demo` carries both out in whole."""
    whole = run_plan.run_plan
    monkeypatch.setattr(
        run_plan,
        "run_plan",
        lambda scenario, scene, plan: whole(scenario, scene, replace(plan, actions=plan.actions[:4])),
    )
    monkeypatch.setattr(reproduce_paper, "FIGURE_5", {"preference-optimal": -1})
    study = Study("Case Study 3", "")
    reproduce_paper.case_study_3(study, tmp_path, simulate=True)
    assert verdicts(study) == [AGREES] * 4
    ((picture, _),) = study.figures
    assert picture.read_bytes().startswith(b"\x89PNG")
    states = study.findings[2]
    assert states.ours == "10009" and "it has 729," in states.remark
