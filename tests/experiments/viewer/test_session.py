"""A page without a browser: plans are chosen, and a user injects faults while they are carried out."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Callable, Iterator
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser
from scenario_texts import PLACES_NEARBY, cup_scenario

from experiments.runs.run_plan import begin
from experiments.viewer.session import Session, Show
from experiments.viewer.viewpoint import Viewpoint
from prefplan import pareto_front
from prefplan.scenario.decode import loads
from sim.world.scene import Scene, build_scene

SCENARIO = loads(cup_scenario(places=PLACES_NEARBY))

TIMEOUT_S = 120.0
"""Longest wait for an expected state of a run, s."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(SCENARIO.model)


@pytest.fixture
def session(scene: Scene) -> Iterator[Session]:
    """A page whose front has the only plan twice."""
    problem = SCENARIO.problem()
    plans = [*pareto_front(problem)] * 2
    server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    start = [partial(begin, problem, scene, plan) for plan in plans]
    session = Session(server, Show(problem, scene, plans, lambda i: lambda tell: start[i](tell=tell), "cup"))
    yield session
    session.close()
    server.stop()


def play(session: Session, until: Callable[[], bool]) -> None:
    """Play in small steps until something holds."""
    give_up = time.monotonic() + TIMEOUT_S
    while not until():
        assert time.monotonic() < give_up
        session.advance(0.05)
        time.sleep(0.001)


def pause(session: Session) -> None:
    """Pause, and wait until the simulations, which run ahead, have used up the time that they were allowed."""
    session.playback.pause()
    give_up = time.monotonic() + TIMEOUT_S
    while not all(run._changed._waiters for run in session.playback.runs):  # type: ignore[attr-defined]
        assert time.monotonic() < give_up
        time.sleep(0.001)


def news(session: Session, side: int = 0) -> str:
    return "\n".join(session.playback.runs[side].statuses[-1].news)


def drag(session: Session, side: int, phase: str, start: np.ndarray, end: np.ndarray) -> None:
    event = SimpleNamespace(
        phase=phase, start_position=tuple(start), end_position=tuple(end), target=cup(session, side), instance_index=0
    )
    asyncio.run(session.stages[side]._drag(event))  # type: ignore[arg-type]


def cup(session: Session, side: int = 0) -> Any:
    """Return the cup's node on the page."""
    nodes = session.stages[side]._tree.nodes
    return next(node for name, node in nodes.items() if name.startswith("/bodies/cup/") and node.visible)


def cup_at(session: Session, side: int = 0) -> np.ndarray:
    """Return where a browser has the cup, m."""
    stage = session.stages[side]
    return stage._data.body("cup").xpos + stage.offset


def test_a_page_plays_from_its_start_when_it_is_first_opened(session: Session) -> None:
    assert session.playback.time == 0.0 and not session.playback.playing
    session.open()
    assert session.playback.playing
    session.playback.pause()
    session.open()
    assert not session.playback.playing, "a second browser changes nothing"


def test_every_control_has_a_tooltip(session: Session) -> None:
    handles = session._server.gui._gui_input_handle_from_uuid.values()
    assert len(handles) >= 10
    assert [handle.label for handle in handles if not handle.hint] == []


def test_a_plan_is_carried_out_when_it_is_chosen_and_another_beside_it_in_step(session: Session) -> None:
    first = session.playback.runs
    play(session, lambda: bool(first[0].frames))
    session.choose(1)
    assert session.shown == (1,) and session.playback.playing
    play(session, lambda: session.playback.time > 1.0)
    first[0].join(TIMEOUT_S)
    assert not first[0].is_alive() and first[0].latest < 0.2

    session.beside(0)
    assert session.shown == (1, 0) and len(session.stages) == 2
    play(session, lambda: session.playback.ended and not session.playback.playing)
    left, right = session.playback.runs
    assert [run.statuses[-1].ended for run in (left, right)] == ["completed"] * 2
    assert right.statuses[-1].time == pytest.approx(left.statuses[-1].time)
    assert np.allclose(cup_at(session, 1) - cup_at(session), session.stages[1].offset, atol=1e-3)
    assert np.linalg.norm(session.stages[1].offset) > 1.0

    session.restart()
    assert session.shown == (1, 0) and session.playback.time == 0.0
    session.beside(None)
    assert session.shown == (1,) and len(session.playback.runs) == 1


def test_a_cup_that_is_knocked_over_is_seen_and_the_new_plan_is_told(session: Session) -> None:
    session.playback.play()
    play(session, lambda: session.playback.time > 0.5)
    pause(session)
    session.inject("slip")
    session.inject("knock", "cup")
    (run,) = session.playback.runs
    assert [fault.kind for fault in run.waiting] == ["slip", "knock"] and not news(session)
    session.advance(0.0)
    assert "knock cup: happens when you press Play" in session._panel._text.content
    run.pull.target = "cup", np.zeros(3)
    session.advance(0.0)
    assert "pull cup: an object moves only while the plan plays" in session._panel._text.content
    run.pull.target = None
    session.playback.play()
    play(session, lambda: session.playback.ended)
    told = news(session)
    assert "fault slip@1 is not possible now: nothing hangs in the hand" in told and "fault knock:cup@1" in told
    assert re.search(r"after `.*expected .*: (planned|tried) again", told), told
    assert run.statuses[-1].ended == "completed" and not run.waiting
    session.inject("knock", "cup")
    assert not run.waiting, "nothing happens after the end"


def test_a_cup_is_dragged_with_the_mouse_and_fetched_from_there(session: Session) -> None:
    session.beside(0)
    play(session, lambda: all(run.statuses for run in session.playback.runs) and session.playback.time > 0.2)
    start = cup_at(session, 1)
    edge, offset = start + [0.0, 0.0, 0.02], np.array([0.08, 0.06, 0.05])
    drag(session, 1, "start", edge, edge)
    drag(session, 1, "update", edge, edge + offset)
    play(session, lambda: bool(np.linalg.norm(cup_at(session, 1) - start - offset) < 0.01))
    drag(session, 1, "end", edge, edge + offset)
    assert np.linalg.norm(cup_at(session) - cup_at(session, 1) + session.stages[1].offset) > 0.05
    play(session, lambda: session.playback.ended)
    assert "fault pull:cup@1" in news(session, 1) and not news(session, 0)
    assert [run.statuses[-1].ended for run in session.playback.runs] == ["completed"] * 2


def test_a_click_with_shift_knocks_over_what_is_under_the_pointer(session: Session) -> None:
    play(session, lambda: bool(session.playback.runs[0].frames))
    eye = np.array([1.0, 0.5, 1.0])
    event = SimpleNamespace(target=cup(session), ray_origin=tuple(eye), ray_direction=tuple(cup_at(session) - eye))
    asyncio.run(session.stages[0]._click(event))  # type: ignore[arg-type]
    assert [(fault.kind, fault.argument) for fault in session.playback.runs[0].waiting] == [("knock", "cup")]


def test_the_page_starts_where_the_camera_is(scene: Scene) -> None:
    front, hand = Viewpoint.of(scene, "fixed"), Viewpoint.of(scene, "wrist")
    assert front.eye[0] > 0.6 and front.eye[2] > 0.3 and hand.field > front.field
    assert hand.target[2] < hand.eye[2] - 0.4
    far = Viewpoint.of(scene, "180,-45,2")
    assert np.allclose(far.eye - far.target, [np.sqrt(2), 0, np.sqrt(2)])
    two = far.beside(np.array([0.0, 1.2, 0.0]))
    assert np.allclose(two.target - far.target, [0, 0.6, 0]) and two.eye[0] > far.eye[0] + 0.3
