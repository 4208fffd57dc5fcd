"""Random scenes: reproducible by seed, of all kinds, and reported with their results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scenario_texts import cup_scenario, task_tables

from experiments import random_scenes
from experiments.random_scenes import REFUSED, carry_out, markdown, scene_text
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import loads

SCENES = 60


def test_scenes_are_the_same_by_seed_and_of_all_kinds() -> None:
    texts = [scene_text(3, number) for number in range(SCENES)]
    assert texts == [scene_text(3, number) for number in range(SCENES)] and len(set(texts)) == SCENES
    models = [loads(text, name="drawn").model for text in texts]
    assert all(isinstance(model, ManipulationModel) for model in models)
    assert {len(model.objects) for model in models} == set(range(3, 9))
    assert {obj.kind for model in models for obj in model.objects} == {"cube", "box", "cylinder"}
    shelves = sum('kind = "shelf"' in text for text in texts)
    assert SCENES / 5 < shelves < SCENES / 2
    assert {text.count("\nwall") for text in texts} == {0, 1, 2, 3}


def record(number: int, **changes: Any) -> dict[str, Any]:
    done = {"scene": number, "completed": True, "class": None, "reason": None, "wrongly_completed": False}
    return done | {"contacts": 0, "certified": True, "refuted": [], "replay": f"prefplan run {number}.toml"} | changes


def test_the_page_counts_what_was_refused_completed_and_failed() -> None:
    page = markdown(
        [
            *map(record, range(6)),
            record(6, completed=False, reason="it slipped", **{"class": "it slipped"}),
            record(7, certified=False, refuted=["joints: too fast"]),
            {"scene": 8, "class": REFUSED, "reason": "no way", "replay": ""},
        ],
        seed=3,
    )
    for line in (
        "| scenes | 9 |",
        "| refused by `prefplan check` | 1 |",
        "| completed, of the others | 7 of 8 (87.5%) [52.9%, 97.8%] |",
        "| certificates that hold | 7 |",
        "- 1 x no way",
        "- it slipped: `prefplan run 6.toml`",
        "- joints: too fast: `prefplan run 7.toml`",
    ):
        assert line in page, page


def test_a_scene_is_checked_and_carried_out(tmp_path: Path) -> None:
    done = carry_out(0, 39, tmp_path)
    assert done["class"] is None and done["completed"] and done["certified"], done
    assert (tmp_path / "scene_39.toml").read_text() == scene_text(0, 39)


def test_a_scene_without_a_plan_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = cup_scenario(task_tables(never="F (cup_tray & false)"))
    monkeypatch.setattr(random_scenes, "scene_text", lambda seed, number: text)
    refused = carry_out(0, 3, tmp_path)
    assert refused["class"] == REFUSED and refused["reason"].endswith("cannot be satisfied")
