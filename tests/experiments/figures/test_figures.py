"""Figures: the right file for every ending, with its text as text, and what is drawn where."""

from __future__ import annotations

import json
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from experiments.commands.command_line import main
from experiments.figures import plans
from experiments.figures.figures import write_figure
from experiments.figures.front import draw, draw_front
from experiments.figures.maps import map_of
from prefplan import Front, Plan, PrefplanError, Scenario, pareto_front
from prefplan.scenario.decode import load, loads

MUDDY = """
[model]
kind = "grid"
size = [12, 8]
start = [0, 0]
cost = { time = 1, energy = 1 }
[model.terrain]
mud = { boxes = [[3, 0, 5, 5]], cost = { time = 1, energy = 4 } }
ridge = { boxes = [[8, 3, 8, 7]], cost = { time = 3, energy = 3 } }
[model.regions]
soil = [6, 1, 6, 1]
battery = [11, 6, 11, 7]
base = [0, 7, 0, 7]
[model.obstacles]
rock = [7, 2, 7, 5]
[[tasks]]
name = "sample"
formula = "F (soil & F base)"
[[tasks]]
name = "power"
formula = "F (battery & F base)"
[[tasks]]
name = "home"
formula = "F base"
[[preferences]]
name = "soon"
kind = "deadline"
deadlines = { sample = { by = 20, weight = 2 } }
of = "time"
[[preferences]]
name = "even"
kind = "expression"
expression = "abs(sample - power)"
of = "energy"
"""

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def axes() -> Axes:
    return Figure(figsize=(6, 4)).subplots()


def point(cost: float, preference: float) -> Plan:
    return Plan(cost, preference, {}, {}, (), ((0, 0),))


def texts(path: Path) -> set[str]:
    return {"".join(element.itertext()).strip() for element in ET.parse(path).iter(f"{SVG}text")}


def test_a_front_is_drawn_as_png_svg_and_pdf(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for ending in ("png", "svg"):
        assert main(["front", "example", "--plot", str(tmp_path / f"front.{ending}")]) == 0
        assert f"front.{ending}" in capsys.readouterr().out
    assert Image.open(tmp_path / "front.png").width > 1000
    assert {"total cost", "0: (6, 4)", "1: (9, 3)"} <= texts(tmp_path / "front.svg")
    assert main(["front", "example", "--json", "--plot", str(tmp_path / "front.PDF")]) == 0
    assert len(json.loads(capsys.readouterr().out)["front"]) == 2
    document = (tmp_path / "front.PDF").read_bytes()
    assert document.startswith(b"%PDF") and b"/FontFile2" in document
    assert not list(tmp_path.glob(".*"))


def test_the_same_picture_is_the_same_file(tmp_path: Path) -> None:
    for ending in ("png", "svg", "pdf"):
        for name in ("a", "b"):
            assert main(["automaton", "!a U b", "--plot", str(tmp_path / f"{name}.{ending}")]) == 0
        assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["front", "example", "--plot", "front.jpeg"], ".png, .svg, .pdf"),
        (["front", "example", "--plot", "nowhere/front.png"], "nowhere/front.png: cannot be written, since there is"),
        (["draw", "plans", "case_study_3", "plans.png"], "`prefplan report` shows those of any model"),
        (["automaton", " & ".join(f"F {name}" for name in "abcdef"), "--plot", "f.png"], "64 states"),
    ],
)
def test_what_cannot_be_drawn_is_said_in_a_sentence(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    printed, told = capsys.readouterr()
    assert message in told and len(told.splitlines()) == 1 and not printed
    assert not list(tmp_path.iterdir())


def test_every_point_is_drawn_and_what_it_dominates(axes: Axes, example: Scenario) -> None:
    draw_front(axes, example, Front((point(3, 9), point(5, 4), point(8, 0))))
    step, ideal, points = axes.get_lines()
    assert np.array(points.get_xydata()).tolist() == [[3, 9], [5, 4], [8, 0]]
    assert np.array(ideal.get_xydata()).tolist() == [[3, 0]]
    right, high = axes.get_xlim()[1], axes.get_ylim()[1]
    corners = np.array(step.get_xydata()).tolist()
    assert corners == [[3, high], [3, 9], [5, 4], [8, 0], [right, 0]]
    assert step.get_drawstyle() == "steps-post"


def test_a_front_of_one_point_is_no_trade_off(axes: Axes, example: Scenario) -> None:
    draw_front(axes, example, Front((point(4, 0),)))
    assert len(axes.get_lines()) == 2
    assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()


def test_a_front_with_values_beyond_all_floats_is_refused(axes: Axes, example: Scenario) -> None:
    with pytest.raises(PrefplanError, match="values beyond 1e308 cannot be drawn"):
        draw_front(axes, example, Front((point(10**309, 0),)))


def test_an_incomplete_front_shows_how_far_it_is_complete(axes: Axes, example: Scenario) -> None:
    draw_front(axes, example, Front((point(3, 9), point(5, 4)), ended="time", complete_below=4))
    assert "complete up to here" in axes.get_legend_handles_labels()[1]


def test_the_legend_lies_on_no_front(tmp_path: Path) -> None:
    scenario, drawn = load("case_study_3"), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", lambda figure, *args, **options: drawn.append(figure))
        draw(scenario, pareto_front(scenario.problem()), tmp_path / "front.png")
    (figure,) = drawn
    figure.draw_without_rendering()
    (legend,), (axes,) = figure.legends, figure.axes
    assert [text.get_text() for text in legend.get_texts()] == ["dominated", "ideal, out of reach", "plan"]
    assert not legend.get_window_extent().overlaps(axes.get_tightbbox())


def test_labels_of_points_never_overlap(axes: Axes, example: Scenario) -> None:
    draw_front(axes, example, Front(tuple(point(i, 60 - i) for i in range(60))))
    extents = [text.get_window_extent() for text in axes.texts]
    assert 2 < len(extents) < 60
    assert not any(a.overlaps(b) for i, a in enumerate(extents) for b in extents[:i])
    assert min(extent.x0 for extent in extents) > axes.get_window_extent().x0


def test_a_map_shows_regions_by_name_and_tasks_where_they_are_satisfied(axes: Axes, example: Scenario) -> None:
    plan = pareto_front(example.problem())[0]
    plan_map = map_of(example)
    assert plan_map is not None
    plan_map.draw(axes, plan)
    assert not axes.texts
    plan_map.label(axes, plan)
    assert {text.get_text() for text in axes.texts} == {"dirt", "plant", "rock", "charge", "phi1", "phi2", "phi3"}


def test_titles_lie_apart_and_a_name_keeps_off_an_obstacle_beside_what_it_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(plans, "write_figure", lambda figure, path: drawn.append(figure))
    scenario = loads(MUDDY, name="muddy")
    plans.draw(scenario, pareto_front(scenario.problem()), tmp_path / "plans.png")
    (figure,) = drawn
    one, other = (axes.title.get_window_extent() for axes in figure.axes[:2])
    assert not one.overlaps(other)
    for axes in figure.axes[:2]:
        (name,) = [text for text in axes.texts if text.get_text() == "ridge"]
        rocks = [patch for patch in axes.patches if patch.get_gid() == "obstacle"]
        assert rocks and not any(name.get_window_extent().overlaps(rock.get_window_extent()) for rock in rocks)


def test_plans_and_automata_are_drawn(tmp_path: Path) -> None:
    for what in ("plans", "automata"):
        assert main(["draw", what, "example", str(tmp_path / f"{what}.svg")]) == 0
    assert {"Pareto front", "0: cost 6, μ = 4", "phi2"} <= texts(tmp_path / "plans.svg")
    assert {"phi3: !plant U dirt", "dirt & !plant"} & texts(tmp_path / "automata.svg")


@pytest.mark.parametrize("label", ["咖啡", "مرحبا"])
def test_letters_that_a_font_lacks_are_told_once_where_they_are_not_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], label: str
) -> None:
    scenario = tmp_path / "cafe.toml"
    scenario.write_text(MUDDY.replace('name = "home"', f'name = "home"\nlabel = "{label}"'), encoding="utf-8")
    assert main(["draw", "plans", str(scenario), str(tmp_path / "cafe.svg")]) == 0
    assert capsys.readouterr().err == "" and any(label in text for text in texts(tmp_path / "cafe.svg"))
    assert main(["draw", "plans", str(scenario), str(tmp_path / "cafe.png")]) == 0
    assert capsys.readouterr().err.count("\n") == (1 if label == "咖啡" else 0)


def test_other_warnings_of_a_drawing_are_no_missing_letters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    figure = Figure()
    figure.savefig = lambda file, **options: warnings.warn("crowded", UserWarning, stacklevel=1)  # type: ignore[method-assign]
    with pytest.warns(UserWarning, match="crowded"):
        write_figure(figure, tmp_path / "a.png")
    assert capsys.readouterr().err == ""
