"""The run and the checker of its log, which share no code, ground each state in the same way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import mujoco
import numpy as np
import pytest
from forged_logs import telling
from observers import Before
from scenario_texts import CUP

from prefplan import ManipulationModel
from prefplan.claims import Claims
from prefplan.scenario.decode import loads
from sim.evidence.log import Log, log_of
from sim.evidence.replay import RecordedWorld
from sim.execution.executor import Execution
from sim.execution.faults.slip import SLIP_DURATION_S, SLIP_GAP_M
from sim.perception.grounding import observe
from sim.perception.sensors import true_poses
from sim.world.scene import Scene, build_scene, initial_state
from sim.world.shapes import CUBE_EDGE_M

ARRANGEMENTS = 100


def arrangements(scene: Scene) -> Iterator[dict[str, np.ndarray]]:
    """Yield positions for three blocks without overlap, close to the slots of some locations."""
    rng = np.random.default_rng(1)
    slots = [slot.position for name in ("table", "right", "left", "bin1") for slot in scene.slots[name]]
    made = 0
    while made < ARRANGEMENTS:
        centres = [slots[rng.integers(len(slots))]] * 2 + [slots[rng.integers(len(slots))]]
        points = [centre + [*rng.uniform(-0.055, 0.055, 2), CUBE_EDGE_M / 2] for centre in centres]
        if all(np.abs(a - b)[:2].max() > CUBE_EDGE_M + 0.001 for a, b in combinations(points, 2)):
            made += 1
            yield dict(zip(("blue", "pink", "green"), points, strict=True))


@pytest.mark.parametrize("bias", [0, 5])
def test_they_agree_on_what_rests_where_however_crowded_and_crooked_it_is(
    scene: Scene, arch_log: Log, bias: float
) -> None:
    """Blocks are tilted by up to 25 degrees, and the camera shows all of them aside and too high or too low."""
    setting = {"seed": 4, "perturbation": f"position=5,angle=5,bias={bias}"}
    off = RecordedWorld(telling(arch_log, setting=setting)).bias
    assert np.abs(off).max() <= bias / 1000 and np.all(off != 0) == (bias > 0)
    data, rng = initial_state(scene), np.random.default_rng(2)
    seen: list[Mapping[str, str]] = []
    rows = []
    for points in arrangements(scene):
        for obj, point in points.items():
            tilt = rng.choice([0, rng.uniform(0, np.radians(25))])
            rise = CUBE_EDGE_M / 2 * (np.cos(tilt) + np.sin(tilt) - 1)
            data.joint(obj).qpos[:] = [*point[:2], point[2] + rise, np.cos(tilt / 2), np.sin(tilt / 2), 0, 0]
        mujoco.mj_forward(scene.mujoco, data)
        poses = {obj: replace(pose, position=pose.position + off) for obj, pose in true_poses(scene, data).items()}
        seen.append(observe(scene, data, poses, hand="home", held=None).place)
        rows.append(data.qpos.copy())
    frames = np.array(rows)
    width, still = arch_log.qpos.shape[1], np.zeros((len(frames), arch_log.qvel.shape[1]))
    log = replace(arch_log, qpos=frames[:, :width], qvel=still, times=np.arange(len(frames)) / 30)
    world = RecordedWorld(telling(log, setting=setting))
    shown = []
    for frame in range(len(frames)):
        world.show(frame)
        shown.append(world.resting(None))
    assert shown == seen
    assert {len(places) for places in seen} == {0, 1, 2, 3}
    assert all(list(places.values()).count(name) <= 1 for places in seen for name in ("table", "right", "left"))


@pytest.mark.parametrize("before", [-0.02, 0.01, 0.05, 0.12])
def test_they_agree_on_what_is_held_whenever_it_begins_to_slip(before: float) -> None:
    """The hand opens for a moment, this many seconds before the grasp would have ended."""
    model = loads(CUP).model
    assert isinstance(model, ManipulationModel)
    scene = build_scene(model)
    plain = Execution(scene, initial_state(scene))
    assert plain.step("transit desk") and plain.step("grasp cup")
    begin = plain.steps[-1].end - before
    run = Execution(scene, initial_state(scene))

    def slip() -> None:
        if begin <= run.cell.data.time < begin + SLIP_DURATION_S:
            run.cell.width = CUBE_EDGE_M + SLIP_GAP_M

    Before(run.cell, slip)
    assert run.step("transit desk")
    assert run.step("grasp cup") == (before < 0)
    if before > 0:
        assert "expected cup in the hand" in str(run.reason)
    claims = Claims(completed=False, cost=4, task_costs={"tidy": 4}, violation_costs={}, preference=None)
    world = RecordedWorld(log_of(scene, run.record(), claims, scenario="cup", text=CUP))
    world.pad_forces[:] = run.record().pad_forces
    step = run.steps[-1]
    world.show(world.frame_at(step.end))
    assert world.held() == step.observed.held == ("cup" if before < 0 else None)
    assert world.resting(world.held()) == step.observed.place
