"""A run and its playback without a browser: pace, steps, seeking, and what the panel says."""

from __future__ import annotations

import time
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import viser
from scenario_texts import cup_scenario, task_tables

from experiments.cli.browser import template
from experiments.runs.run_plan import begin, scene_of
from experiments.viewer.live_run import LiveRun, Status, news_of
from experiments.viewer.playback import Playback
from experiments.viewer.stage import Stage
from prefplan import Entry, Plan, Scenario, Task, preferred_plan
from prefplan.scenario.decode import loads
from prefplan.text.names import DisplayNames
from sim.execution.faults.fault import kinds
from sim.simulation.run import Event, Run
from sim.world.scene import build_scene, initial_state

CUP = cup_scenario(
    task_tables(
        lift="F holding_cup", tidy="F cup_tray", preference='kind = "weighted-sum"\nweights = { lift = 2, tidy = 1 }'
    )
)

AGES = 1e6
"""Longer than any run, s."""


def live_run(scenario: Scenario, *, until: float = AGES) -> LiveRun:
    problem, scene = scenario.problem(), scene_of(scenario)
    plan = preferred_plan(problem)
    return LiveRun(problem, lambda tell: begin(problem, scene, plan, tell=tell), until=until)


@pytest.fixture(scope="module")
def finished() -> LiveRun:
    """The run of the only plan, simulated to its end in this thread."""
    run = live_run(loads(CUP))
    run.run()
    assert run.failure is None and run.ended
    return run


@pytest.fixture
def playback(finished: LiveRun) -> Playback:
    return Playback([finished])


def test_the_costs_are_known_before_every_action_and_at_the_end(finished: LiveRun) -> None:
    seen = [(status.done, status.costs.cost, status.costs.preference) for status in finished.statuses]
    # Lifted at cost 4, tidied at 10; an unsatisfied task costs the total so far.
    assert seen == [(0, 0, 0), (0, 0, 0), (1, 3, 9), (2, 4, 12), (3, 9, 17), (4, 10, 18)]
    end = finished.statuses[-1]
    assert end.ended == "completed" and end.costs.task_costs == {"lift": 4, "tidy": 10}
    assert end.costs.preference == end.plan.preference


def test_a_run_that_touched_what_it_should_not_is_not_completed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Run, "objection", "hand touched cup at 2.00 s")
    run = live_run(loads(CUP))
    run.run()
    assert run.failure is None and run.statuses[-1].ended == "hand touched cup at 2.00 s"


def test_frames_follow_each_other_without_a_gap(finished: LiveRun) -> None:
    period = np.diff([frame["times"] for frame in finished.frames[:-1]])
    assert len(period) > 90 and period.min() > 1 / 32 and period.max() < 1 / 29
    assert not np.allclose(finished.frames[0]["qpos"], finished.frames[-1]["qpos"])


def test_nothing_moves_until_it_is_played(playback: Playback) -> None:
    playback.advance(1.0)
    assert playback.time == 0.0
    playback.play()
    playback.advance(0.5)
    playback.speed = 4.0
    playback.advance(0.25)
    assert playback.time == pytest.approx(playback.runs[0].frames[0]["times"] + 1.5)
    playback.pause()
    playback.advance(AGES)
    assert playback.time == pytest.approx(playback.runs[0].frames[0]["times"] + 1.5)


def test_a_step_ends_with_its_action_and_what_has_ended_can_be_played_again(playback: Playback) -> None:
    for done in (1, 2, 3, 4):
        playback.step()
        playback.advance(AGES)
        status = playback.runs[0].status_at(playback.time)
        assert status.done == done and not playback.playing
    assert status.ended == "completed"
    playback.play()
    playback.advance(0.1)
    assert 0 < playback.time < 1
    playback.load(playback.runs, playing=False)
    assert (playback.time, playback.playing, playback.sought) == (0.0, False, False)


def test_a_time_that_is_sought_is_held(playback: Playback) -> None:
    playback.play()
    playback.seek(2.5)
    playback.advance(AGES)
    assert (playback.time, playback.playing, playback.sought) == (2.5, False, True)
    assert abs(playback.runs[0].frame_at(2.5)["times"] - 2.5) < 1 / 29
    playback.play()
    assert not playback.sought


def test_the_playback_waits_for_the_simulation(finished: LiveRun) -> None:
    run = LiveRun(finished.problem, finished._begin)
    run.statuses, run.frames = finished.statuses[:2], finished.frames[:10]
    playback = Playback([run])
    playback.step()
    playback.advance(AGES)
    assert playback.playing and playback.time == run.latest
    run.statuses, run.frames = finished.statuses, finished.frames
    playback.advance(AGES)
    assert not playback.playing and run.status_at(playback.time).done == 1


def test_runs_in_step_wait_for_the_one_that_is_behind(finished: LiveRun) -> None:
    behind = LiveRun(finished.problem, finished._begin)
    behind.statuses, behind.frames = finished.statuses[:3], finished.frames[:20]
    playback = Playback([finished, behind])
    playback.play()
    playback.advance(AGES)
    assert playback.playing and playback.time == playback.latest == behind.latest
    behind.statuses, behind.frames = finished.statuses, finished.frames[:]
    playback.step()
    playback.advance(AGES)
    assert [run.status_at(playback.time).done for run in playback.runs] == [1, 1] and not playback.playing


def test_no_more_is_simulated_than_is_allowed() -> None:
    run = live_run(loads(CUP), until=0.0)
    run.start()
    run.allow(0.5)
    while not run.frames or run.latest < 0.45:
        time.sleep(0.001)
    run.stop()
    assert run.latest < 0.55 and not run.ended and run.failure is None


def test_a_run_that_is_stopped_ends_early() -> None:
    run = live_run(loads(CUP))
    run.stop()
    run.start()
    run.join(60)
    assert not run.is_alive() and not run.ended and run.failure is None


def test_what_the_arm_does_to_reach_an_object_is_told() -> None:
    events = ("drawn free", "grasped", "turned over")
    told = news_of([Event(1.0, kind, {"object": "cup"}) for kind in events], DisplayNames())
    assert [line.partition(": no")[0].partition(": the fingers")[0] for line in told] == [
        "   1.0 s  cup dragged free",
        "   1.0 s  cup turned over",
    ]


def test_a_new_plan_says_what_a_spot_is_that_the_scenario_does_not_have() -> None:
    detail = {"reason": "gone", "cost": 9, "preference": 0, "plan": ["transit spot1", "grasp cup"]}
    spots = {"spot1": {"object": "cup", "at": [0.45, -0.1]}}
    (told,) = news_of([Event(1.0, "replan", detail | {"spots": spots})], DisplayNames(objects={"cup": "red cup"}))
    assert told.splitlines()[1:] == ["    spot1: where red cup lies, off every location, at x 0.450, y -0.100 m"]
    assert "\n" not in news_of([Event(1.0, "replan", detail)], DisplayNames())[0]


def test_the_panel_marks_the_present_action_and_escapes_text() -> None:
    plan = Plan(4, 0, {"a": 4}, {"a": 0}, ("transit desk", "grasp cup"), ())
    tasks = (Task("a", "F (holding_cup & !cup_tray)"), Task("b", "F x"))
    costs = Entry(3, {"a": 3, "b": 2}, {"a": 0, "b": 0}, frozenset({"b"}), 0)
    status = Status(1.0, plan, 1, costs, ("1.0 s: fault: <b>",))
    run = SimpleNamespace(
        problem=SimpleNamespace(tasks=tasks),
        status_at=lambda time: status,
        waiting=[kinds()["knock"](1, "cup")],
        pull=SimpleNamespace(target=("<cup>", None)),
    )
    show = partial(template("experiments.viewer", "panel.html").render, time=1.25)
    html = show(runs=[(run, 0, "")], playing=True)
    assert '<li class="muted">transit desk</li>\n<li class="current">grasp cup</li>' in html
    assert "1 of 2 actions done, 1.2 s" in html and "playing" in html
    assert 'F (holding_cup &amp; !cup_tray)</td>\n<td class="number">open' in html
    assert 'F x</td>\n<td class="number">2' in html
    assert "fault: &lt;b&gt;" in html
    assert "knock cup: happens when the run continues" in html and "pull" not in html
    narrow = show(runs=[(run, 1, "#228be6"), (run, 0, "")], playing=False)
    assert '<div style="color: #228be6"><b>Plan 1</b>' in narrow and "cup_tray" not in narrow
    assert "knock cup: happens when you press Play" in narrow
    assert "pull &lt;cup&gt;: an object moves only while the plan plays" in narrow


def test_a_location_at_work_glows() -> None:
    washed = CUP.replace("tray = { at", 'basin = { at = [0.45, 0.32], marks = "clean" }\ntray = { at')
    scene = build_scene(loads(washed).model)
    qpos = initial_state(scene).qpos
    server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    try:
        stage = Stage(server, scene, lambda: pytest.fail("nothing is disturbed"))

        def colour() -> tuple[int, int, int]:
            mesh = server.scene.get_handle_by_name("/left/glow/basin/mesh")
            return mesh.color

        stage.show({"qpos": qpos, "glow": -1})
        dark = colour()
        stage.show({"qpos": qpos, "glow": 1})
        assert colour() != dark
        stage.show({"qpos": qpos, "glow": -1})
        assert colour() == dark
    finally:
        server.stop()
