"""Answers to what the arm can do are kept on disk, and asked for again when anything changes on which they depend."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.description import Location, Object
from prefplan.models.manipulation.model import Fixture, ManipulationModel, RobotSetup
from sim.capability import answers
from sim.capability.answers import Capability
from sim.capability.place_check import PlaceCheck

HERE, THERE = Location("here", at=(0.45, 0.0)), Location("there", at=(0.45, 0.2))
CUP, JUG = Object("cup", "here"), Object("jug", "there")
MODEL = ManipulationModel(
    "home",
    {"transit": 1, "grasp": 1, "transport": 1, "release": 1},
    (HERE, THERE, Location("far", at=(0.6, 0))),
    (CUP,),
)
TRANSFERS = (("here", "far"), ()), (("far", "there"), ()), (("here", "far"), (("jug", "there"),))
ANSWER = PlaceCheck("cup", "there", "no room", take_unless=(("jug", "here"),), put_unless=(("jug", "far"),))


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Let an arm give one answer, and keep it in an empty cache; return the list of questions."""
    questions: list[Any] = []

    class Arm:
        def __init__(self, scene: object) -> None:
            pass

        def check(self, obj: str, location: str) -> PlaceCheck:
            questions.append((obj, location))
            return ANSWER

        def rehearse(self, transfer: Transfer) -> PlaceCheck | None:
            questions.append(transfer)
            return None if transfer.target == "far" else PlaceCheck("cup", "there", "a wall", not_from=transfer.source)

        def check_start(self) -> str:
            questions.append("start")
            return "too low"

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("sim.capability.feasibility.Feasibility", Arm)
    return questions


def test_an_answer_is_asked_for_once_and_read_as_it_was_written(asked: list[Any]) -> None:
    first, again = Capability(MODEL), Capability(MODEL)
    assert [arm.check("cup", "there") for arm in (first, first, again)] == [ANSWER] * 3
    assert [arm.check_start() for arm in (first, first)] == [Capability(MODEL).check_start()] * 2 == ["too low"] * 2
    assert asked == [("cup", "there"), "start"]


def test_a_transfer_is_rehearsed_once_for_each_arrangement(asked: list[Any]) -> None:
    arm, model = Capability(MODEL), replace(MODEL, objects=(CUP, replace(JUG, start="far")))
    out, back, beside = (Transfer("cup", *ends, others) for ends, others in TRANSFERS)
    assert [one.rehearse(out) for one in (arm, arm, Capability(MODEL))] == [None] * 3
    indirect = PlaceCheck("cup", "there", "a wall", not_from="far")
    assert {one.rehearse(back) for one in (arm, arm, Capability(MODEL))} == {indirect}
    assert Capability(model).rehearse(beside) is None and asked == [out, back, ("cup", "there"), beside]
    off = [out._replace(source="spot1"), out._replace(obj="unknown0"), out._replace(others=(("jug", "spot1"),))]
    assert not any(map(arm.rehearse, off)) and len(asked) == 4


def test_what_fails_whatever_stands_around_is_what_the_check_says(
    asked: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    never = PlaceCheck("cup", "there", "too low", take=False, put=False, crowded_by=(("jug", "far"),))
    monkeypatch.setattr(Capability, "check", lambda self, obj, location: never)
    refused = Capability(MODEL).rehearse(Transfer("cup", "far", "there", ()))
    assert refused is not None and refused.barred == [(frozenset(), "release cup there")]


def test_of_a_check_only_what_stands_there_counts() -> None:
    found = PlaceCheck(
        "cup", "here", "a jug", take_unless=(("jug", "far"),), crowded_by=(("jug", "far"), ("pot", "far"))
    )
    assert found.among((), grasped=False) is None and found.among((), grasped=True) is None
    taken, put = (found.among((("jug", "far"),), grasped=grasped) for grasped in (False, True))
    assert taken and taken.barred == [(frozenset({"cup_here", "jug_far"}), "grasp cup")]
    assert put and put.barred == [(frozenset({"jug_far"}), "release cup here")] and put.reason is None


def test_an_answer_that_was_cut_off_is_asked_for_again(asked: list[Any], tmp_path: Path) -> None:
    Capability(MODEL).check_start()
    Capability(MODEL).check("cup", "there")
    (kept,) = tmp_path.rglob("*.jsonl")
    kept.write_bytes(kept.read_bytes()[:-9])
    for arm in (Capability(MODEL), Capability(MODEL)):
        assert (arm.check("cup", "there"), arm.check_start()) == (ANSWER, "too low")
    assert asked == ["start", ("cup", "there"), ("cup", "there")]


@pytest.mark.parametrize(
    "other",
    [
        replace(MODEL, objects=(replace(CUP, rgba=(1.0, 0.0, 0.0, 1.0), label="mug"),)),
        replace(MODEL, locations=(*MODEL.locations[:2], replace(MODEL.locations[2], label="away"))),
        replace(MODEL, costs=dict.fromkeys(MODEL.kinds, 2), propositions=frozenset({"visitor"})),
    ],
)
def test_looks_and_costs_do_not_matter(asked: list[Any], other: ManipulationModel) -> None:
    Capability(MODEL).check("cup", "there")
    Capability(other).check("cup", "there")
    assert len(asked) == 1


@pytest.mark.parametrize(
    "other",
    [
        replace(MODEL, start="far"),
        replace(MODEL, begin=replace(MODEL.initial_state, places=(("cup", "far"),))),
        replace(MODEL, robot="panda_suction"),
        replace(MODEL, robot=RobotSetup("panda", yaw=10.0)),
        replace(MODEL, fixtures=(Fixture("wall", "box", at=(0.3, 0.3, 0.05), size=(0.1, 0.1, 0.1)),)),
        replace(MODEL, locations=(HERE, replace(THERE, at=(0.45, 0.21)), MODEL.locations[2])),
        replace(MODEL, objects=(CUP, JUG)),
        replace(MODEL, objects=(replace(CUP, size=(0.05,)),)),
    ],
)
def test_everything_else_of_a_scene_does(asked: list[Any], other: ManipulationModel) -> None:
    Capability(MODEL).check("cup", "there")
    Capability(other).check("cup", "there")
    assert len(asked) == 2


def test_the_robot_and_the_sources_do(asked: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    Capability(MODEL).check("cup", "there")
    Capability(MODEL, robot="panda_suction").check("cup", "there")
    monkeypatch.setattr(answers, "digest_of_sources", lambda: "changed")
    Capability(MODEL).check("cup", "there")
    monkeypatch.setattr(answers, "version", lambda library: "0")
    Capability(MODEL).check("cup", "there")
    assert len(asked) == 4
