"""Maps of graphs with coordinates: nodes in their places, and edges as lines or, where they are many, pixels."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scenario_texts import task_tables

from experiments.figures import maps, road_map
from experiments.figures.figures import POINTS_PER_INCH
from experiments.figures.road_map import RoadMap
from experiments.report import pictures
from prefplan import Scenario, load, pareto_front

SCENARIO = """
[model]
kind = "graph"
file = "square.csv"
nodes = "corners.csv"
start = "a"
""" + task_tables(shop="F bread", post="F stamps", preference='kind = "order"\norder = ["post", "shop"]')


@pytest.fixture
def square(tmp_path: Path) -> Scenario:
    """Four corners of a square, one way round."""
    (tmp_path / "square.csv").write_text("from,to,cost\na,b,1\nb,c,1\nc,d,1\nd,a,1\na,d,5\n")
    (tmp_path / "corners.csv").write_text("node,x,y,labels\na,10,60,\nb,12,60,bread\nc,12,62,\nd,10,62,stamps\n")
    (tmp_path / "square.toml").write_text(SCENARIO)
    return load(tmp_path / "square.toml")


@pytest.fixture
def busy(square: Scenario, tmp_path: Path) -> Scenario:
    """The same with another way from a to b, of so many edges that they are pixels."""
    between = [f"m{k}" for k in range(road_map.MOST_LINES)]
    with (tmp_path / "square.csv").open("a") as edges:
        edges.writelines(f"{one},{other},1\n" for one, other in pairwise(["a", *between, "b"]))
    with (tmp_path / "corners.csv").open("a") as nodes:
        nodes.writelines(f"{name},{10 + 2 * k / len(between)},60,\n" for k, name in enumerate(between))
    return load(square.path)


def found_map(scenario: Scenario) -> RoadMap:
    found = maps.map_of(scenario)
    assert isinstance(found, RoadMap)
    return found


def test_a_plan_lies_where_its_states_are(square: Scenario) -> None:
    front = pareto_front(square.problem())
    path = found_map(square).trail(front[0]).states
    assert [plan.cost for plan in front] == [3, 7]
    side = np.diff(path, axis=0)
    assert np.allclose(side, side[0, 0] * np.array([[1, 0], [0, 1], [-1, 0]]))
    assert len(found_map(square).lines) == 4, "an edge in both directions is one line"
    assert found_map(square).size[0] == pytest.approx(found_map(square).size[1])


def test_degrees_of_longitude_are_shorter_than_those_of_latitude(square: Scenario, tmp_path: Path) -> None:
    corners = [(10, 60), (12, 60), (12, 62), (10, 62)]
    lines = [f"v {i} {x * 10**6} {y * 10**6}" for i, (x, y) in enumerate(corners, start=1)]
    (tmp_path / "corners.co").write_text("\n".join(["p aux sp co 4", *lines]))
    (tmp_path / "square.gr").write_text("p sp 4 3\na 1 2 1\na 2 3 1\na 3 4 1\n")
    text = SCENARIO.replace("square.csv", "square.gr").replace("corners.csv", "corners.co").replace('"a"', "1")
    (tmp_path / "globe.toml").write_text(
        text.replace("[[tasks]]", '[model.labels]\n3 = ["bread", "stamps"]\n[[tasks]]', 1)
    )
    globe = load(tmp_path / "globe.toml")
    wide, high = np.ptp(found_map(globe).points, axis=0)
    assert wide / high == pytest.approx(np.cos(np.radians(61)))


def test_a_graph_without_all_coordinates_has_no_map(square: Scenario, tmp_path: Path) -> None:
    table = tmp_path / "corners.csv"
    table.write_text(table.read_text().replace("12,62", "12,"))
    assert maps.map_of(load(square.path)) is None


def test_dots_are_where_tasks_are_done_and_names_are_written(square: Scenario, tmp_path: Path) -> None:
    drawn = maps.svg(found_map(square), pareto_front(square.problem())[1], title="", folder=tmp_path)
    assert len(re.findall('class="goal"', drawn)) == 2
    names = [re.sub("<[^>]*>", "", text).strip() for text in re.findall(r"<text .*?</text>", drawn, re.DOTALL)]
    assert sorted(names) == ["post", "shop"]


def test_few_edges_are_lines(square: Scenario, tmp_path: Path) -> None:
    drawn = maps.svg(found_map(square), pareto_front(square.problem())[0], title="", folder=tmp_path)
    assert "<image" not in drawn


def test_many_edges_are_pixels_that_plans_of_a_report_share(busy: Scenario, tmp_path: Path) -> None:
    (tmp_path / "page").mkdir()
    drawn = pictures.plans(busy, pareto_front(busy.problem()), tmp_path / "page")
    (pixels,) = (tmp_path / "page").glob("*.png")
    for picture in drawn.values():
        assert re.findall(r'href="([^"#]*)"', picture) == [f"page/{pixels.name}"]


def test_pixels_are_dark_on_edges_and_clear_beside_them(busy: Scenario, tmp_path: Path) -> None:
    found = found_map(busy)
    drawn_map = maps.svg(found, pareto_front(busy.problem())[0], title="", folder=tmp_path)
    (image,) = re.findall("<image[^>]*>", drawn_map)
    x, width = (float(re.findall(f' {key}="(.*?)"', image)[0]) for key in ("x", "width"))
    points_per_unit = maps.SIDE_IN * POINTS_PER_INCH / max(found.size)
    ends = points_per_unit * (found.points[:, 0] + 0.5)
    assert (x, x + width) == pytest.approx((ends.min(), ends.max()), abs=1)
    (pixels,) = tmp_path.glob("*.png")
    drawn = np.asarray(Image.open(pixels))[..., 3]
    row, column = np.array(drawn.shape) // 2
    for side in (drawn[row, :4], drawn[row, -4:], drawn[:4, column], drawn[-4:, column]):
        assert side.max() > 0
    assert drawn[row, column] == 0
