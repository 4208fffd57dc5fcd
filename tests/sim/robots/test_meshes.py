"""Tests for the Panda's surface."""

import mujoco
import numpy as np
import pytest

from sim.robots.meshes import mesh_folder, surfaces
from sim.robots.panda import panda_spec


@pytest.mark.parametrize(("before", "after"), [("link0", "link1"), ("link2", "link3"), ("link4", "link5")])
def test_links_leave_no_slit_at_the_seams_along_the_arm(before: str, after: str) -> None:
    folder = mesh_folder()
    if folder is None:
        pytest.skip("the meshes are not installed")
    shells = {one.link: one.solid for one in surfaces(folder) if one.finish == "shell"}
    joint = panda_spec(meshes=False).body(after)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, joint.quat / np.linalg.norm(joint.quat))
    along = turn.reshape(3, 3)[:, 2]
    end = (shells[before].vertices @ along).max()
    start = joint.pos @ along + shells[after].vertices[:, 2].min()
    assert 0 < end - start < 0.001
