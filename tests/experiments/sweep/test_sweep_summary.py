from __future__ import annotations

import io
from typing import Any

import pytest
from rich.console import Console

from experiments.sweep.job import failure_class
from experiments.sweep.summary import show_summary, summarise, wilson
from prefplan.models.manipulation.model import Location, ManipulationModel, Object

HEADER = {"scenario": "cup", "plan": "cost", "perturb": "position=5,angle=5"}


def record(number: int, *, kind: str | None = None, seconds: float = 10.0, error: float = 0.1) -> dict[str, Any]:
    return {
        "rollout": number,
        "seed": 100 + number,
        "replay": f"prefplan run cup --seed {100 + number}",
        "completed": kind is None,
        "class": kind,
        "reason": kind and f"{kind}, in detail",
        "certified": True,
        "agrees": True,
        "refuted": [],
        "proved": False,
        "wrongly_completed": False,
        "replans": number % 2,
        "happened": [],
        "sim_seconds": seconds,
        "cpu_seconds": 0.5,
        "placement_error_mm": error,
        "speed_share": 0.5,
        "torque_share": 0.4,
    }


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_the_interval_is_wilson_s(count: int, total: int, low: float, high: float) -> None:
    """Against Newcombe, Statistics in Medicine 17 (1998), Table I, score method."""
    assert wilson(count, total) == pytest.approx([low, high], abs=5e-5)
    assert wilson(total - count, total) == pytest.approx([1 - high, 1 - low], abs=5e-5)


def test_nothing_has_no_interval() -> None:
    summary = summarise(HEADER, [], rollouts=5)
    assert wilson(0, 0) is None
    assert (summary["done"], summary["success_rate"], summary["success_interval"]) == (0, None, None)
    assert "none yet" in shown(summary)


def shown(summary: dict[str, Any]) -> str:
    text = io.StringIO()
    show_summary(Console(file=text, width=200, highlight=False), summary)
    return text.getvalue()


def test_failures_are_counted_by_class_and_the_first_of_each_can_be_replayed() -> None:
    kinds = [None, "slipped", "slipped", "blocked", None, *["slipped"] * 5]
    summary = summarise(HEADER, [record(i, kind=kind, seconds=10 + i) for i, kind in enumerate(kinds)], rollouts=12)
    assert (summary["completed"], summary["done"], summary["rollouts"], summary["complete"]) == (2, 10, 12, False)
    assert [(kind["class"], kind["count"]) for kind in summary["failures"]] == [("slipped", 7), ("blocked", 1)]
    assert [entry["seed"] for entry in summary["failures"][0]["rollouts"]] == [101, 102, 105, 106, 107]
    assert summary["sim_seconds"] == {"median": 14.5, "max": 19}
    assert summary["real_time_factor"] == 29
    text = shown(summary)
    assert "2 of 10 (20.0%)" in text and "29.0 x real time a core" in text
    assert "7 x slipped" in text and "prefplan run cup --seed 101" in text


def test_rollouts_without_an_outcome_count_as_failures_only() -> None:
    kept = ("rollout", "seed", "replay", "completed", "class", "reason", "refuted", "wrongly_completed")
    crashed = {key: record(1, kind="crashed")[key] for key in kept} | {"certified": None, "agrees": None}
    summary = summarise(HEADER, [record(0), crashed], rollouts=2)
    assert (summary["completed"], summary["done"], summary["complete"]) == (1, 2, True)
    assert summary["sim_seconds"] == {"median": 10.0, "max": 10.0}
    assert summary["certificates"]["checked"] == summary["certificates"]["confirmed"] == 1
    assert "1 x crashed" in shown(summary)


def test_rollouts_whose_logs_say_otherwise_are_named() -> None:
    limits = record(1) | {"certified": False, "refuted": ["joint speeds: too fast"]}
    wrong = record(2) | {"certified": False, "agrees": False, "refuted": ["completed: tidy was never satisfied"]}
    wrong |= {"completed": False, "wrongly_completed": True, "class": "the log refutes it", "reason": "the log does"}
    summary = summarise(HEADER, [record(0), limits, wrong], rollouts=3)
    found = summary["certificates"]
    assert (found["checked"], found["agree"], found["confirmed"]) == (3, 2, 1)
    assert found["wrongly_completed"] == 1 and "wrongly called completed" in shown(summary)
    assert [entry["rollout"] for entry in found["refuted"]] == [1, 2]
    assert "completed: tidy was never satisfied" in shown(summary) and "2 of 3 (66.7%)" in shown(summary)


def test_findings_are_named_and_refute_nothing() -> None:
    failed = record(1, kind="touched") | {"findings": ["contacts: hand touched cup at 3.10 s, according to the log"]}
    summary = summarise(HEADER, [record(0), failed], rollouts=2)
    found = summary["certificates"]
    assert (found["confirmed"], found["refuted"]) == (2, [])
    assert [entry["rollout"] for entry in found["findings"]] == [1]
    assert "findings: contacts: hand touched cup" in shown(summary)


def test_completion_is_told_for_each_kind_of_fault_that_happened() -> None:
    both = record(1) | {"happened": ["slip@2", "slip@4", "move:cup@3"]}
    failed = record(2, kind="lost") | {"happened": ["move:cup@1"]}
    summary = summarise(HEADER, [record(0), both, failed], rollouts=3)
    assert summary["happened"] == {
        "move": {"rollouts": 2, "completed": 1},
        "slip": {"rollouts": 1, "completed": 1},
    }
    assert summary["replans"] == {"total": 1, "max": 1}
    assert "planned again" in shown(summary) and "completed with move" in shown(summary)


def test_failures_that_differ_in_names_and_numbers_alone_are_of_one_class() -> None:
    model = ManipulationModel(
        "home",
        {"transit": 1, "grasp": 1, "transport": 1, "release": 1},
        (Location("bin1", at=(0.4, 0.0)), Location("bin", at=(0.5, 0.2))),
        (Object("red", "bin1"), Object("red2", "bin")),
    )
    one = failure_class("after `transport red bin`: expected red in the hand, but it is at (0.65, -0.10) m", model)
    other = failure_class("after `transport red2 bin1`: expected red2 in the hand, but it is at (0.5, 0.31) m", model)
    assert one == other == ("after `transport OBJECT LOCATION`: expected OBJECT in the hand, but it is at (N, N) m")
    assert failure_class("the redness of bin 7", model) == "the redness of LOCATION N"
