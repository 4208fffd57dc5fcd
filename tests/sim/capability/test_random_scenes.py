"""Random scenes: reproducible by seed, of all kinds, and reported with the check's answers beside their outcomes."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from judge.random_scenes import __main__ as command
from judge.random_scenes import trial
from judge.random_scenes.generator import MASSES_KG, PITCHES_M, scene_text
from judge.random_scenes.page import markdown
from judge.random_scenes.trial import (
    COMPLETED,
    CRASHED,
    FAILED,
    NOT_BUILT,
    REFUTED,
    TIMED_OUT,
    Scenes,
    answer,
)
from scenario_texts import cup_scenario, task_tables

from experiments.checks.checkup import check
from experiments.sweep import workers
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import loads
from sim.errors import SimulationError
from sim.world.scene import build_scene

SCENES = 80


def test_scenes_are_the_same_by_seed_and_of_all_kinds() -> None:
    texts = [scene_text(3, number) for number in range(SCENES)]
    assert texts == [scene_text(3, number) for number in range(SCENES)] and len(set(texts)) == SCENES
    models = [loads(text, name="drawn").model for text in texts]
    assert all(isinstance(model, ManipulationModel) for model in models)
    objects = [obj for model in models for obj in model.objects]
    assert {len(model.objects) for model in models} == set(range(4, 15))
    assert {obj.kind for obj in objects} == {"cube", "box", "cylinder"}
    masses = np.array([obj.mass for obj in objects], dtype=float)
    assert masses.min() >= MASSES_KG[0] and masses.max() <= MASSES_KG[1]
    assert masses.min() < 0.01 and masses.max() > 2 and np.median(masses) < 0.3
    shelves = sum('kind = "shelf"' in text for text in texts)
    assert SCENES / 5 < shelves < SCENES / 2
    assert {text.count("\nwall") for text in texts} == {0, 1, 2, 3}
    assert max(fixture.size[2] for model in models for fixture in model.fixtures if fixture.kind == "box") > 0.45
    assert any(obj.start.startswith("top") for obj in objects)


def test_locations_are_drawn_as_close_together_as_the_pitch_allows() -> None:
    apart = []
    for number in range(SCENES):
        model = loads(scene_text(3, number), name="drawn").model
        at = np.array([place.at[:2] for place in model.locations if place.at and place.name not in ("low", "high")])
        distances = np.abs(at[:, None] - at).max(axis=2)
        apart.append(float(distances[np.triu_indices(len(at), 1)].min()))
    assert min(apart) > PITCHES_M[0] - 0.001  # written in millimetres
    assert min(apart) < PITCHES_M[0] + 0.005


TWO_BEAMS = """
[model]
kind = "manipulation"
start = "home"
costs = {{ transit = 3, grasp = 1, transport = 5, release = 1 }}
[model.locations]
near = {{ at = [0.45, 0.1] }}
beside = {{ at = [{x}, 0.1] }}
away = {{ at = [0.45, -0.25] }}
[model.objects]
oak = {{ start = "near", kind = "box", size = [0.03, 0.06, 0.05] }}
elm = {{ start = "beside", kind = "box", size = [0.03, 0.06, 0.05] }}
[[tasks]]
name = "oak"
formula = "F oak_away"
[preference]
kind = "order"
"""


def tried(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setattr(trial, "scene_text", lambda seed, number: text)
    return Scenes(1, folder, 600).record(3)


def test_an_allowed_scene_is_carried_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = tried(TWO_BEAMS.format(x=0.65), tmp_path, monkeypatch)
    assert done["allowed"] and done["outcome"] == COMPLETED and done["completed"], done
    assert 1 < done["longest_action_seconds"] < done["sim_seconds"]
    assert done["longest_action"].split()[0] in ("transit", "grasp", "transport", "release")
    assert (tmp_path / "scene_3.toml").read_text() == TWO_BEAMS.format(x=0.65)


def test_a_refused_scene_is_carried_out_without_the_test_that_refused_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = TWO_BEAMS.format(x=0.65).replace("[model.objects]", "unused = { at = [0.45, -0.26] }\n[model.objects]")
    done = tried(text, tmp_path, monkeypatch)
    assert not done["allowed"] and "they would touch" in done["refusals"][0]
    assert done["outcome"] == COMPLETED and done["refuted"] == [], done


def test_a_refused_scene_with_objects_inside_one_another_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = tried(TWO_BEAMS.format(x=0.46), tmp_path, monkeypatch)
    assert not done["allowed"] and done["outcome"] == FAILED and "inside one another" in done["reason"], done


@pytest.mark.parametrize("goal", ["away", "beside", "far"])
def test_a_plan_and_the_objects_that_tasks_name_tell_what_check_answers(goal: str) -> None:
    """The task can be achieved at once, once another object was moved, or not at all."""
    text = TWO_BEAMS.format(x=0.65).replace("oak_away", f"oak_{goal}")
    scenario = loads(text.replace("[model.objects]", "far = { at = [0.95, 0.0] }\n[model.objects]"), name="beams")
    assert isinstance(scenario.model, ManipulationModel)
    scene, faults = answer(scenario, scenario.model)
    assert scene is not None and faults == check(scenario)["faults"]
    assert bool(faults) == (goal == "far")


def test_a_scene_whose_objects_have_no_place_cannot_be_built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = tried(TWO_BEAMS.format(x=0.65).replace("[0.03, 0.06, 0.05]", "[0.2, 0.2, 0.05]"), tmp_path, monkeypatch)
    assert not done["allowed"] and done["outcome"] == NOT_BUILT


def test_a_scene_without_a_plan_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = tried(cup_scenario(task_tables(never="F (cup_tray & false)")), tmp_path, monkeypatch)
    assert not done["allowed"] and done["refusals"][0].endswith("cannot be satisfied")
    assert done["outcome"] == FAILED


def test_a_layout_that_is_not_judged_has_all_slots() -> None:
    model = loads(TWO_BEAMS.format(x=0.46), name="beams").model
    assert isinstance(model, ManipulationModel)
    with pytest.raises(SimulationError, match="too close: they would touch"):
        build_scene(model)
    with trial.unjudged():
        assert set(build_scene(model).slots) == {"near", "beside", "away"}


def record(number: int, outcome: str, *, allowed: bool | None = True, **changes: Any) -> dict[str, Any]:
    ran = {"sim_seconds": 30.0, "longest_action": "grasp o1", "longest_action_seconds": 4.0}
    heading = {"scene": number, "allowed": allowed, "refusals": [] if allowed else ["too near"], "outcome": outcome}
    ran |= {"check_cpu_seconds": 8.0, "run_cpu_seconds": 20.0}
    measures = ran | {"refuted": [], "wrongly_completed": False} if outcome in (COMPLETED, FAILED, REFUTED) else {}
    return heading | measures | changes


def test_the_page_has_the_answers_beside_the_outcomes() -> None:
    page = markdown(
        [
            *(record(number, COMPLETED) for number in range(5)),
            record(5, FAILED, reason="it slipped", longest_action="transport can out2", longest_action_seconds=61.0),
            record(6, REFUTED, refuted=["contacts: hand touches wall"], wrongly_completed=True),
            record(7, COMPLETED, allowed=False),
            *(record(number, FAILED, allowed=False, reason="no way") for number in (8, 9, 10)),
            record(11, NOT_BUILT, allowed=False),
            record(12, TIMED_OUT, allowed=None, refusals=[]),
        ],
        scenes=20,
        seed=3,
        about="MuJoCo 3",
    )
    for line in (
        "--scenes 20 --seed 3`, MuJoCo 3: 13 of 20 scenes finished.",
        "| yes | 7 | 5 | 1 | 1 | 0 | 0 | 0 | 0 |",
        "| no: carried out without the test that refused | 5 | 1 | 3 | 0 | 0 | 1 | 0 | 0 |",
        "| no answer in time | 1 | 0 | 0 | 0 | 0 | 0 | 1 | 0 |",
        "the run hits something or is refuted (asked: 0) | 1 |",
        "| of these, wrongly called completed | 1 |",
        "| allowed, and failed honestly | 1 of 7 (14.3%) |",
        "(asked: under 5 %) | 1 of 4 (25.0%) [4.6%, 69.9%] |",
        "| runs with an action over 10 s (asked: 0) | 1 |",
        "| longest action | 61.0 s: `transport can out2` of scene 5 |",
        "| median 8 s and median 20 s |",
        "| too near | 5 | 1 |",
        "- scene 5: failed honestly; it slipped",
        "- scene 6: refuted; contacts: hand touches wall",
        "- scene 7: completed; too near",
    ):
        assert line in page, page
    assert "- scene 8" not in page


def test_a_scene_whose_time_is_up_keeps_what_is_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def hangs(*arguments: Any, **options: Any) -> None:
        time.sleep(600)

    monkeypatch.setattr(trial, "run_plan", hangs)
    monkeypatch.setattr(trial, "answer", lambda scenario, model: (None, ["task oak cannot be satisfied"]))
    monkeypatch.setattr(trial, "scene_text", lambda seed, number: TWO_BEAMS.format(x=0.65))
    done = Scenes(1, tmp_path, 3).record(3)
    assert (done["scene"], done["allowed"], done["outcome"]) == (3, False, TIMED_OUT)
    crashed = Scenes(1, tmp_path, 3).crashed(4, "it ended")
    assert (crashed["scene"], crashed["allowed"], crashed["outcome"]) == (4, None, CRASHED)


def test_finished_scenes_are_kept_after_an_interruption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[int] = []

    def ends(batch: Scenes, numbers: list[int], **limits: Any) -> Any:
        for number in numbers:
            asked.append(number)
            if asked == [0, 1]:
                raise KeyboardInterrupt
            yield record(number, COMPLETED)

    monkeypatch.setattr(workers, "on_this_machine", ends)
    arguments = ["--scenes", "3", "--out", str(tmp_path), "--quiet"]
    assert command.main(arguments) == 130
    assert re.search("1 of 3 scenes finished", capsys.readouterr().out)
    assert command.main(arguments) == 0
    assert asked == [0, 1, 1, 2]
    assert re.search("3 of 3 scenes finished", capsys.readouterr().out)
