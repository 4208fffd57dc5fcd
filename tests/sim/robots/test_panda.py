from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sim.errors import RobotError
from sim.robots.arms.panda import MJCF, PANDA, _spec, panda_spec

# Franka Control Interface documentation, "Denavit-Hartenberg parameters", Craig's convention.
DH_A = (0, 0, 0, 0.0825, -0.0825, 0, 0.088)
DH_D = (0.333, 0, 0.316, 0, 0.384, 0, 0)
DH_ALPHA = (0, -np.pi / 2, np.pi / 2, np.pi / 2, -np.pi / 2, np.pi / 2, np.pi / 2)
FLANGE = 0.107
HAND_TURN, TCP_OFFSET = -np.pi / 4, 0.1034


@pytest.fixture(scope="module")
def panda() -> mujoco.MjModel:
    return panda_spec().compile()


def dh_transform(a: float, d: float, alpha: float, theta: float) -> np.ndarray:
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array([[ct, -st, 0, a], [st * ca, ct * ca, -sa, -d * sa], [st * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]])


def dh_tool(q: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    for a, d, alpha, theta in zip(DH_A, DH_D, DH_ALPHA, q, strict=True):
        pose = pose @ dh_transform(a, d, alpha, theta)
    return pose @ dh_transform(0, FLANGE + TCP_OFFSET, 0, HAND_TURN)


def test_forward_kinematics_agree_with_the_published_parameters(panda: mujoco.MjModel) -> None:
    rng = np.random.default_rng(0)
    data = mujoco.MjData(panda)
    for q in rng.uniform(*PANDA.ranges(panda).T, size=(300, 7)):
        data.qpos[PANDA.qpos(panda)] = q
        mujoco.mj_kinematics(panda, data)
        expected = dh_tool(q)
        assert np.abs(data.site(PANDA.tool).xpos - expected[:3, 3]).max() < 1e-9
        assert np.abs(data.site(PANDA.tool).xmat.reshape(3, 3) - expected[:3, :3]).max() < 1e-9


def test_position_and_torque_limits_are_the_published_ones(panda: mujoco.MjModel) -> None:
    wide = 2.8973
    expected = [(-wide, wide), (-1.7628, 1.7628), (-wide, wide), (-3.0718, -0.0698)]
    expected += [(-wide, wide), (-0.0175, 3.7525), (-wide, wide)]
    for name, limits, torque in zip(PANDA.joints, expected, [87] * 4 + [12] * 3, strict=True):
        assert panda.joint(name).range == pytest.approx(limits)
        assert panda.actuator(name).ctrlrange == pytest.approx(limits)
        assert panda.actuator(name).forcerange == pytest.approx((-torque, torque))


def test_meshes_change_neither_inertia_nor_pads() -> None:
    dressed, plain = panda_spec().compile(), mujoco.MjSpec.from_file(str(MJCF)).compile()
    assert dressed.body_mass == pytest.approx(plain.body_mass)
    assert dressed.body_inertia == pytest.approx(plain.body_inertia)
    for pad in PANDA.gripper.pads:
        for field in ("pos", "size", "friction", "solref", "solimp"):
            assert getattr(dressed.geom(pad), field) == pytest.approx(getattr(plain.geom(pad), field))


def test_the_motors_give_no_more_than_they_can_whatever_they_are_told() -> None:
    """Bearing the hand's weight, 2.3 N m at joint 6, counts, whether it is with the command or against it."""
    model = PANDA.spec().compile()
    data = mujoco.MjData(model)
    PANDA.put(data, PANDA.home, width=PANDA.gripper.opening_m)
    motors = [model.actuator(name).id for name in PANDA.joints]
    dofs = PANDA.dofs(model)
    for direction, wrist in ((-1.0, -9.7), (1.0, 12.0)):
        data.ctrl[motors] = PANDA.home + direction
        mujoco.mj_forward(model, data)
        torques = data.qfrc_actuator[dofs]
        assert np.all(np.abs(torques) <= PANDA.torque_limits + 1e-9)
        assert torques[5] == pytest.approx(wrist, abs=0.1)
        assert not data.qfrc_passive[dofs].any(), "nothing else bears the arm"


def test_without_its_meshes_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    _spec.cache_clear()
    with pytest.raises(RobotError, match="pip install gymnasium-robotics"):
        panda_spec()
