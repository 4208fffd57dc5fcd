"""The paper done again: what agrees, what differs and what cannot be done is said, on the page and by the status."""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType

import pytest

from experiments import case_study_1, case_study_2, reproduce_paper, scenarios
from experiments.paper import grids
from experiments.paper.arm import case_study_3
from experiments.paper.findings import AGREES, DIFFERS, ERRATUM, MEASURED, Study, point_by_point
from experiments.paper.table import table_1
from prefplan import PrefplanError, pareto_front


def verdicts(study: Study) -> list[str]:
    return [finding.verdict for finding in study.findings]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("paper")
    assert reproduce_paper.main(["--quick", "--out", str(folder)]) == 0
    return folder


def test_one_page_holds_everything(out: Path) -> None:
    page = (out / "index.html").read_text(encoding="utf-8")
    for title in ("Examples 1 to 3", "Case Study 1", "Case Study 2", "Case Study 3", "Table I"):
        assert f"<h2>{title}</h2>" in page
    assert DIFFERS not in page
    assert page.count("<img ") == 4
    assert all(address.startswith(("data:", "#")) for address in re.findall(r'(?:src|href)="([^"]*)"', page))


def test_the_figures_are_written(out: Path) -> None:
    assert {path.name for path in out.iterdir()} >= {"figure_1.svg", "figure_3.svg", "figure_4.svg", "table_1.png"}


def test_what_the_paper_has_wrong_is_named(tmp_path: Path) -> None:
    assert verdicts(grids.examples(tmp_path)) == [AGREES, ERRATUM, AGREES]
    assert verdicts(grids.case_study_2(tmp_path)) == [AGREES, AGREES, AGREES, ERRATUM]
    assert verdicts(table_1(tmp_path)) == [AGREES, MEASURED, MEASURED, MEASURED, ERRATUM]


def test_an_erratum_that_cannot_be_confirmed_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grids, "PRINTED_PLAN", grids.DRAWN_PLAN)
    assert verdicts(grids.examples(tmp_path)) == [AGREES, DIFFERS, AGREES]


def test_points_that_are_missing_and_points_too_many_differ() -> None:
    front = pareto_front(scenarios.find("example").problem())
    missing, extra, same = point_by_point("Figure 9", [(5, 5), (9, 3)], front)
    assert (missing.what, missing.ours, missing.verdict) == ("Figure 9 (a)", "-", DIFFERS)
    assert (extra.what, extra.paper, extra.ours, extra.verdict) == ("a point too many", "-", "cost 6, mu 4", DIFFERS)
    assert (same.what, same.verdict) == ("Figure 9 (b)", AGREES)


def test_a_front_that_differs_ends_with_status_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(grids, "FIGURE_3", ((68, 29), (70, 27), (72, 24), (74, 23), (84, 11), (98, 0)))
    assert reproduce_paper.main(["--quick", "--out", str(tmp_path)]) == 1
    assert re.search(r"Figure 3 \(b\) +cost 70, mu 27 +- +DIFFERS", capsys.readouterr().out)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "Not everything agrees" in page and DIFFERS in page


def test_what_cannot_be_done_is_shown_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(out: Path) -> Study:
        raise PrefplanError("the town is <closed>")

    monkeypatch.setattr(reproduce_paper, "case_study_2", refuse)
    assert reproduce_paper.main(["--quick", "--out", str(tmp_path)]) == 1
    assert "Case Study 2: the town is <closed>" in capsys.readouterr().out
    assert "could not be done: the town is &lt;closed&gt;" in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("")
    assert reproduce_paper.main(["--quick", "--out", str(tmp_path / "taken")]) == 2
    assert "cannot be made" in capsys.readouterr().err


@pytest.mark.parametrize(("study", "figure"), [(case_study_1, "figure_3.svg"), (case_study_2, "figure_4.svg")])
def test_each_case_study_on_a_grid_is_a_script_of_its_own(
    study: ModuleType, figure: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert study.main() == 0
    assert capsys.readouterr().out.count("agrees\n") == len(study.PUBLISHED)
    name = study.__name__.rpartition(".")[2]
    assert Path("out", name, figure).exists()
    scenario = scenarios.find(name)
    assert [(task.name, task.formula, task.skip) for task in scenario.tasks] == [
        (task.name, task.formula, task.skip) for task in study.TASKS
    ]
    assert {region: list(boxes) for region, boxes in scenario.model.regions.items()} == case_study_1.TOWN


@pytest.mark.slow
def test_case_study_3_tells_how_many_states_a_fixed_base_would_leave(tmp_path: Path) -> None:
    (found,) = [one for one in case_study_3(tmp_path, simulate=False).findings if one.what == "states of the model"]
    assert (found.ours, found.verdict) == ("10009", AGREES) and "it has 729," in found.remark


def test_both_plans_of_case_study_3_are_carried_out(tmp_path: Path) -> None:
    study = case_study_3(tmp_path, simulate=True)
    assert verdicts(study) == [AGREES] * 5
    (picture, _), *rest = study.figures
    assert picture.read_bytes().startswith(b"\x89PNG") and not rest
