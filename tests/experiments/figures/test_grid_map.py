"""Maps of grids: paths that do not overlap themselves, goals where tasks are satisfied, cells that a page can find."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scenario_texts import shipped, shipped_front

from experiments.figures.grid_map import MOST_CELLS, GridMap
from experiments.figures.maps import map_of, svg
from experiments.figures.plan_map import PlanMap
from experiments.figures.trail import LANE, LANES, trail
from prefplan import Order, Plan, Problem, Scenario, Task, cheapest_plan
from prefplan.models.grid import GridModel, Terrain


def drawn_map(scenario: Scenario) -> PlanMap:
    found = map_of(scenario)
    assert found is not None
    return found


def test_a_path_has_a_point_in_the_cell_of_every_state() -> None:
    cells = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (1, 0), (2, 0), (1, 0), (1, 1), (1, 2)]
    path = trail(cells)
    assert (abs(path.states - np.array(cells)) <= max(LANES) * LANE + 1e-9).all()
    assert (path.line[0] == path.states[0]).all() and (path.line[-1] == path.states[-1]).all()


def test_a_path_there_and_back_is_two_lines_and_that_of_a_plan_that_stays_a_point() -> None:
    path = trail([(0, 0), (1, 0), (2, 0), (1, 0), (0, 0)])
    there, back = path.line[:2], path.line[2:]
    assert there[:, 1].tolist() == [0, 0]
    assert back[:, 1].tolist() == [LANE, LANE]
    assert path.arrows[:, 2].tolist() == [1, -1]
    point = trail([(3, 4)])
    assert point.line.tolist() == [[3, 4]] and not len(point.arrows)


def test_parts_of_a_path_are_level_or_upright() -> None:
    rng = np.random.default_rng(0)
    cells = [(5, 5)]
    while len(cells) < 200:
        dx, dy = ((0, 1), (0, -1), (1, 0), (-1, 0))[rng.integers(4)]
        cells.append((cells[-1][0] + dx, cells[-1][1] + dy))
    assert (abs(np.diff(trail(cells).line, axis=0)).min(axis=1) < 1e-9).all()


def test_goals_are_where_the_tasks_are_satisfied(example: Scenario) -> None:
    plan = cheapest_plan(example.problem())
    found = drawn_map(example).goals(plan)
    assert sorted(task for tasks in found.values() for task in tasks) == ["phi1", "phi2", "phi3"]
    for step, tasks in found.items():
        for task in tasks:
            assert plan.task_costs[task] == step


def test_a_leader_goes_from_a_name_to_the_middle_of_what_it_names() -> None:
    found, plan = drawn_map(shipped("case_study_1")), shipped_front("case_study_1")[0]
    axes = Figure(figsize=(4.5, 4.5)).add_axes((0, 0, 1, 1))
    found.draw(axes, plan)
    found.label(axes, plan, font_size=9)
    leaders = [np.array(line.get_xydata()) for line in axes.lines if line.get_gid() == "leader"]
    path = found.trail(plan).states
    middles = [one.target.reshape(2, 2).mean(axis=0) for one in found.named] + [
        path[step] for step in found.goals(plan)
    ]
    boxes = [text.get_window_extent().padded(3) for text in axes.texts]
    assert leaders
    for start, end in leaders:
        assert any(end == pytest.approx(middle) for middle in middles)
        assert any(box.contains(*axes.transData.transform(start)) for box in boxes)


def test_a_page_finds_the_parts_of_a_map_by_class(example: Scenario, tmp_path: Path) -> None:
    plan = cheapest_plan(example.problem())
    root = ET.fromstring(svg(drawn_map(example), plan, title="", folder=tmp_path))
    classes = Counter(element.get("class") for element in root.iter())
    assert classes["path"] == classes["start"] == 1
    assert classes["region"] == classes["name"] == 4
    assert classes["goal"] == classes["task"] == len(drawn_map(example).goals(plan))
    assert not any(element.get("id") for element in root.iter())


def test_areas_cover_their_cells() -> None:
    boxes = {"region": (1, 2, 3, 2), "obstacle": (5, 0, 5, 4), "terrain": (0, 4, 2, 5)}
    ground, wall, mud = ([box] for box in boxes.values())
    model = GridModel((6, 6), (0, 0), 1, {"far": ground}, {"wall": wall}, terrain={"mud": Terrain(mud, 2)})
    axes = Figure().subplots()
    GridMap(Problem(model.transition_system(), [Task("go", "F far")], Order()), model)._draw_ground(axes)
    drawn = {patch.get_gid(): patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches}
    for kind, (x0, y0, x1, y1) in boxes.items():
        assert np.allclose(drawn[kind].extents, [x0 - 0.5, y0 - 0.5, x1 + 0.5, y1 + 0.5])


def test_single_cells_are_left_out_where_they_are_too_many(tmp_path: Path) -> None:
    side = int(MOST_CELLS**0.5)
    model = GridModel(
        (side + 1, side), (0, 0), regions={"far": [(side, 0, side, 0)]}, obstacles={"wall": [(3, 3, 4, 4)]}
    )
    problem = Problem(model.transition_system(), [Task("go", "F far")], Order())
    drawn = svg(GridMap(problem, model), Plan(0, 0, {}, {}, (), ((0, 0),)), title="", folder=tmp_path)
    assert 'class="grid"' not in drawn and 'class="obstacle"' in drawn and 'class="region"' in drawn
