"""A performance and its spectator, without a browser: pace, steps, recording, and what the panel says."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import viser
from scenario_texts import cup_scenario

from experiments.runs.carry_out import begin, scene_of
from experiments.viewer.control import Control, Stopped
from experiments.viewer.performance import LiveRun, Moment
from experiments.viewer.stage import Stage
from experiments.viewer.standing import Progress, Standing
from experiments.viewer.standing_html import standing_html
from prefplan import Plan, load, preferred_plan
from sim.execution.faults import Fault
from sim.world.scene import initial_state

CUP = cup_scenario("""
[[tasks]]
name = "lift"
formula = "F holding_cup"
[[tasks]]
name = "tidy"
formula = "F cup_tray"
[preference]
kind = "weighted-sum"
weights = { lift = 2, tidy = 1 }
""")

AT_ONCE = 1e6
"""A speed at which nothing is waited for."""

PATIENCE = 60.0
"""What takes longer than this, s, never happens."""

Perform = Callable[..., LiveRun]


@pytest.fixture
def control() -> Control:
    return Control()


@pytest.fixture
def perform(tmp_path: Path) -> Iterator[Perform]:
    """Return how to begin the performance of the only plan, with faults."""
    (tmp_path / "cup.toml").write_text(CUP)
    scenario = load(tmp_path / "cup.toml")
    problem = scenario.problem()
    plan = preferred_plan(problem)
    performances = []

    def start(*faults: Fault) -> LiveRun:
        scene = scene_of(scenario, faults=faults)
        performance = LiveRun(
            problem, lambda tell: begin(problem, scene, plan, faults=faults, tell=tell), speed=AT_ONCE
        )
        performances.append(performance)
        performance.start()
        return performance

    yield start
    for performance in performances:
        performance.stop()


def settled(performance: LiveRun, *, after: Moment | None = None) -> Moment:
    """Wait until a performance is paused at another moment than one, and return what is to be seen then."""
    waiting = threading.Event()
    for _ in range(round(PATIENCE / 0.01)):
        assert performance.failure is None, performance.failure
        if performance.control.mode == "paused" and performance.moment is not after:
            assert performance.moment is not None
            return performance.moment
        waiting.wait(0.01)
    raise AssertionError("never paused")


def in_thread(call: Callable[[], object]) -> threading.Thread:
    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    return thread


def test_nothing_goes_on_until_it_is_played(control: Control) -> None:
    waiting = in_thread(lambda: control.keep_time(0.0))
    waiting.join(0.05)
    assert waiting.is_alive()
    control.play()
    waiting.join(PATIENCE)
    assert not waiting.is_alive()


def test_a_moment_to_come_is_waited_for_unless_it_is_played_faster(control: Control) -> None:
    control.play()
    control.keep_time(0.0)
    waiting = in_thread(lambda: control.keep_time(1e6))
    waiting.join(0.05)
    assert waiting.is_alive()
    control.speed = 1e9
    waiting.join(PATIENCE)
    assert not waiting.is_alive()


def test_a_step_ends_with_its_action_and_playing_does_not(control: Control) -> None:
    control.step()
    control.end_action()
    assert control.mode == "paused"
    control.play()
    control.end_action()
    assert control.mode == "playing"


def test_who_stops_a_paused_performance_ends_it(control: Control) -> None:
    control.stop()
    with pytest.raises(Stopped):
        control.keep_time(0.0)


def test_a_moment_that_is_sought_is_held(control: Control) -> None:
    control.play()
    control.seek(2.5)
    assert control.keep_time(0.0) == 2.5
    assert control.mode == "paused"


def test_a_plan_is_carried_out_one_action_at_a_time(perform: Perform) -> None:
    performance = perform()
    first = settled(performance)
    assert (first.standing.done, first.standing.cost, first.time) == (0, 0, 0.0)
    seen = []
    for _ in first.standing.plan.actions:
        performance.control.step()
        moment = settled(performance)
        seen.append((moment.standing.done, moment.standing.cost, moment.standing.preference))
    # Lifted at cost 4, tidied at 10; what is open costs what was spent so far.
    assert seen == [(1, 3, 9), (2, 4, 12), (3, 9, 17), (4, 10, 18)]
    assert moment.standing.ended == "completed"
    assert [(task.name, task.cost) for task in moment.standing.tasks] == [("lift", 4), ("tidy", 10)]
    assert moment.standing.preference == moment.standing.plan.preference


def test_a_performance_that_has_ended_is_a_recording(perform: Perform) -> None:
    performance = perform()
    settled(performance)
    performance.control.play()
    end = settled(performance)
    assert end.length == end.time > 3
    performance.control.seek(0.0)
    start = settled(performance, after=end)
    assert (start.time, start.standing.done, start.sought) == (0.0, 0, True)
    assert not np.allclose(start.qpos, end.qpos)
    performance.control.step()
    assert settled(performance).standing.done == 1
    performance.control.play()
    again = settled(performance)
    np.testing.assert_array_equal(again.qpos, end.qpos)
    assert again.standing == end.standing
    assert not again.sought


def test_what_goes_wrong_is_told(perform: Perform) -> None:
    performance = perform(Fault("miss", 1, amount=1))
    settled(performance)
    performance.control.play()
    end = settled(performance)
    assert end.standing.ended == "completed"
    told = "\n".join(end.standing.news)
    assert re.search(r"s: fault: miss:1@1\n.* s: tried again: after `grasp cup`", told), told


def test_the_panel_marks_the_present_action_and_escapes_what_it_is_told() -> None:
    plan = Plan(4, 0, {"a": 4}, {"a": 0}, ("transit desk", "grasp cup"), ())
    tasks = (Progress("a", "F (holding_cup & !cup_tray)", None), Progress("b", "F x", 3))
    html = standing_html(Standing(1.0, plan, 1, 3, 0, tasks, ("1.0 s: fault: <b>",)), 1.25, state="running")
    assert '<li class="muted">transit desk</li>\n<li class="current">grasp cup</li>' in html
    assert "1 of 2 actions done, 1.2 s" in html
    assert "F (holding_cup &amp; !cup_tray)" in html
    assert "fault: &lt;b&gt;" in html


def test_what_works_glows(tmp_path: Path) -> None:
    (tmp_path / "washed.toml").write_text(
        CUP.replace("tray = { at", 'basin = { at = [0.45, 0.32], marks = "clean" }\ntray = { at')
    )
    scene = scene_of(load(tmp_path / "washed.toml"))
    plan = Plan(0, 0, {}, {}, (), ())
    rest = Moment(0.0, initial_state(scene).qpos, -1, Standing(0.0, plan, 0, 0, 0, ()))
    server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    try:
        stage = Stage(server, scene)

        def glowing() -> list[bool]:
            names = [f"/glow/basin/{scene.mujoco.body(body).id}" for body in ("basin_base", "basin_lamp_head")]
            lit = [server.scene.get_handle_by_name(f"{name}/on") for name in names]
            dark = [server.scene.get_handle_by_name(f"{name}/off") for name in names]
            assert all(on.visible != off.visible for on, off in zip(lit, dark, strict=True) if on and off)
            return [on.visible for on in lit if on]

        stage.show(rest)
        assert glowing() == [False, False]
        stage.show(replace(rest, glow=1))
        assert glowing() == [True, True]
        stage.show(replace(rest, glow=-1))
        assert glowing() == [False, False]
    finally:
        server.stop()
