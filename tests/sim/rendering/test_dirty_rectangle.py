"""Only what can have changed is rendered again, and the picture is the same as if all of it were."""

from __future__ import annotations

import copy
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from sim.geometry.mjcf import columns
from sim.rendering.cameras import Camera
from sim.rendering.dirty_rectangle import DirtyRectangle
from sim.rendering.quality import DRAFT
from sim.rendering.renderer import Painter
from sim.world.materials import KEY_LIGHT
from sim.world.scene import Scene, build_scene, initial_state

SIZE = (640, 310)


def states(scene: Scene, count: int, *, seed: int) -> list[np.ndarray]:
    """Return random positions of the arm, each with one object elsewhere, above the table, on it, or below it."""
    rng, qpos = np.random.default_rng(seed), initial_state(scene).qpos.copy()
    arm, rows = scene.robot.qpos(scene.mujoco), []
    for _ in range(count):
        low, high = scene.robot.ranges(scene.mujoco).T.clip(-3, 3)
        qpos = qpos.copy()
        qpos[arm] = low + rng.uniform(0.2, 0.8, len(low)) * (high - low)
        pose, _ = columns(scene.mujoco, scene.model.objects[rng.integers(len(scene.model.objects))].name)
        qpos[pose] = [*rng.uniform([-0.2, -0.6, -0.7], [0.7, 0.6, 0.5]), *rng.normal(size=4)]
        rows.append(qpos)
    return rows


@pytest.mark.parametrize(("camera", "samples"), [("fixed", 1), ("top", 1), ("40,-20,2", 1), ("fixed", 5)])
def test_pictures_are_those_of_a_renderer_that_keeps_nothing(scene: Scene, gl: None, camera: str, samples: int) -> None:
    quality, shown = replace(DRAFT, samples=samples), states(scene, 8, seed=samples)
    glows = [(), (), ("san",), ("san",), (), (), (), ()]
    pictures = []
    with Painter(scene, quality=replace(quality, size=SIZE), camera=camera) as keeping:
        pictures = [keeping.frame(qpos, glow=glow) for qpos, glow in zip(shown, glows, strict=True)]
    for qpos, glow, picture in zip(shown, glows, pictures, strict=True):
        with Painter(scene, quality=replace(quality, size=SIZE), camera=camera) as fresh:
            whole = fresh.frame(qpos, glow=glow)
        # The rasterizer may round a corner to another side of a pixel's middle.
        assert (np.abs(whole.astype(int) - picture).max(axis=2) > 12).mean() < 2e-4


def test_shadows_fall_on_a_base_that_stands_beside_the_table(scene: Scene, gl: None) -> None:
    fetch, camera = build_scene(scene.model, robot="fetch"), "40,-20,2"
    with (
        Painter(fetch, quality=replace(DRAFT, size=SIZE), camera=camera) as keeping,
        Painter(fetch, quality=replace(DRAFT, size=SIZE), camera=camera) as forgetting,
    ):
        forgetting._dirty = None
        for qpos in states(fetch, 20, seed=0):
            keeping._gl.make_current()
            picture = keeping.frame(qpos, glow=())
            forgetting._gl.make_current()
            whole = forgetting.frame(qpos, glow=())
            assert (np.abs(whole.astype(int) - picture).max(axis=2) > 12).mean() < 3e-4


@pytest.fixture
def seen(scene: Scene) -> tuple[DirtyRectangle, mujoco.MjData]:
    """A rectangle that has seen the start, and the state there."""
    return watch(scene, scene.mujoco)


def watch(scene: Scene, model: mujoco.MjModel) -> tuple[DirtyRectangle, mujoco.MjData]:
    data = mujoco.MjData(model)
    data.qpos[:] = initial_state(scene).qpos
    mujoco.mj_kinematics(model, data)
    dirty = DirtyRectangle(model, Camera(scene, "fixed", SIZE), model.light(KEY_LIGHT).id, scene.table)
    assert dirty.update(data, 0.0) == (0, 0, *SIZE)
    return dirty, data


def test_nothing_is_rendered_while_nothing_moves(seen: tuple[DirtyRectangle, mujoco.MjData]) -> None:
    dirty, data = seen
    assert dirty.update(data, 0.0) == (0, 0, 0, 0)


def test_little_is_rendered_when_an_object_moves(scene: Scene, seen: tuple[DirtyRectangle, mujoco.MjData]) -> None:
    dirty, data = seen
    pose, _ = columns(scene.mujoco, scene.model.objects[0].name)
    data.qpos[pose.start] += 0.01
    mujoco.mj_kinematics(data.model, data)
    left, top, right, bottom = dirty.update(data, 0.0)
    assert 0 < (right - left) * (bottom - top) < 0.05 * SIZE[0] * SIZE[1]


def test_slow_motions_add_up(scene: Scene, seen: tuple[DirtyRectangle, mujoco.MjData]) -> None:
    dirty, data = seen
    pose, _ = columns(scene.mujoco, scene.model.objects[0].name)
    boxes = []
    for _ in range(5):
        data.qpos[pose.start] += 4e-6
        mujoco.mj_kinematics(data.model, data)
        boxes.append(dirty.update(data, 0.0))
    assert [any(box) for box in boxes] == [False, False, True, False, False]


@pytest.mark.parametrize("change", ["mirror", "shadows", "moving lamp"])
def test_all_is_rendered_where_a_motion_may_be_seen_anywhere(scene: Scene, change: str) -> None:
    model = copy.copy(scene.mujoco)
    if change == "mirror":
        model.mat_reflectance[0] = 0.2
    elif change == "shadows":
        model.light_castshadow[:] = True
    else:
        model.light_bodyid[0] = model.body(scene.model.objects[0].name).id
    dirty, data = watch(scene, model)
    assert dirty.update(data, 0.0) == (0, 0, *SIZE)
