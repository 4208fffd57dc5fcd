"""Tests for the Panda's surface."""

import mujoco
import numpy as np
import pytest

from sim.geometry.mjcf import VISIBLE
from sim.robots.arms.panda import PANDA, panda_spec
from sim.robots.arms.panda_meshes import SEAMS_M

RADIUS_M = 0.055
"""Of the links where they meet."""


@pytest.fixture(scope="module")
def panda() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = panda_spec().compile()
    data = mujoco.MjData(model)
    data.qpos[:7] = PANDA.home
    mujoco.mj_kinematics(model, data)
    return model, data


@pytest.mark.parametrize("link", SEAMS_M)
def test_neither_a_slit_nor_an_end_shows_where_two_links_meet(
    link: str, panda: tuple[mujoco.MjModel, mujoco.MjData]
) -> None:
    model, data = panda
    frame, seen = data.body(link), [group == VISIBLE for group in range(mujoco.mjNGROUP)]
    turn = frame.xmat.reshape(3, 3)
    for angle in np.linspace(0, 2 * np.pi, 60, endpoint=False):
        outwards = np.array([np.cos(angle), np.sin(angle), 0.0])
        for height in np.linspace(-0.0005, 0.0005, 5):
            for slope in (-0.6, 0.0, 0.6):
                aim = RADIUS_M * outwards + [0, 0, SEAMS_M[link] + height]
                towards = -outwards + [0, 0, slope]
                start = aim - 0.02 * towards
                distance = mujoco.mj_ray(
                    model, data, frame.xpos + turn @ start, turn @ towards, seen, 1, -1, np.zeros(1, np.int32)
                )
                assert np.linalg.norm((start + distance * towards)[:2]) > RADIUS_M, (angle, height, slope)
