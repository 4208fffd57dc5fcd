from __future__ import annotations

import copy
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from sim.errors import SimulationError
from sim.world.contacts import scale_friction
from sim.world.randomization import KEYS, NONE, Perturbation, camera_bias, perturbed, read_perturbation
from sim.world.scene import TIMESTEP_S, Scene, initial_state

EXTREME = ",".join(f"{name}={key.greatest}" for name, key in KEYS.items())
"""Every key at its greatest amount."""

BLOCKS = ("blue", "pink", "green")


def test_the_text_is_in_the_units_of_the_keys() -> None:
    read = read_perturbation("position=8, angle=10,friction=0.2,mass=0.1,latency=40,bias=2,noise=1")
    wanted = Perturbation(0.008, np.radians(10), friction=0.2, mass=0.1, latency=0.04, bias=0.002, noise=0.001)
    assert vars(read) == pytest.approx(vars(wanted))
    assert read_perturbation("noise=1") == replace(NONE, noise=0.001), "what is not named is not perturbed"
    assert read_perturbation("none") == NONE
    assert str(Perturbation()) == "position=5,angle=5", "by default, 5 mm and 5 degrees"
    assert list(KEYS) == list(vars(NONE))
    assert read_perturbation(EXTREME) == Perturbation(**{name: key.greatest * key.scale for name, key in KEYS.items()})


@pytest.mark.parametrize(
    "text", ["position=5,angle=5", "position=8,angle=10,friction=0.2,mass=0.2,noise=1", EXTREME, "none"]
)
def test_a_perturbation_is_written_as_it_is_read(text: str) -> None:
    assert str(read_perturbation(text)) == text
    assert read_perturbation(str(read_perturbation(text))) == read_perturbation(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("positon=5", r"unknown perturbation 'positon' \(did you mean 'position'\?\)"),
        ("colour=1", r"valid: position, angle, friction, pads, table, force, mass, centre, latency, noise, bias"),
        ("", "unknown perturbation ''"),
        ("angle", "angle: '' is not a number"),
        ("angle=wide", "angle: 'wide' is not a number"),
        ("position=-1", "position: -1 is not from 0 to 50 mm"),
        ("position=nan", "position: nan is not from 0 to 50 mm"),
        ("latency=inf", "latency: inf is not from 0 to 200 ms"),
        ("mass=1.5", "mass: 1.5 is not from 0 to 0.99, a share: 0.2 for 20 %"),
        ("mass=0.1,mass=0.2", "mass: given twice"),
    ],
)
def test_a_text_that_says_none_is_refused(text: str, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        read_perturbation(text)


def test_friction_and_mass_stay_within_their_shares_and_follow_the_seed(scene: Scene) -> None:
    amounts = Perturbation(friction=0.2, pads=0.3, mass=0.1)
    shares = []
    for seed in range(30):
        model, again = (perturbed(scene, amounts, seed=seed).mujoco for _ in range(2))
        assert np.array_equal(model.geom_friction, again.geom_friction)
        assert np.array_equal(model.pair_friction, again.pair_friction)
        assert np.array_equal(model.body_mass, again.body_mass)
        geoms = (*BLOCKS, *scene.robot.gripper.pads)
        friction = [model.geom(name).friction[0] / scene.mujoco.geom(name).friction[0] for name in geoms]
        mass = [model.body(name).mass[0] / scene.mujoco.body(name).mass[0] for name in BLOCKS]
        inertia = [model.body(name).inertia[0] / scene.mujoco.body(name).inertia[0] for name in BLOCKS]
        assert np.allclose(mass, inertia)
        shares.append([*friction, *mass])
    off = np.abs(np.array(shares) - 1)
    bounds = np.array([0.2] * 3 + [0.3] * 2 + [0.1] * 3)
    assert (off <= bounds).all() and (off.max(axis=0) > 0.75 * bounds).all()
    assert np.allclose(off[:, 3], off[:, 4]), "both pads are of one make"


def test_declared_contacts_have_the_friction_that_mujoco_gives_them_and_follow_both_partners(scene: Scene) -> None:
    model = scene.mujoco
    pads = [model.geom(name).id for name in scene.robot.gripper.pads]
    pairs = np.column_stack([model.pair_geom1, model.pair_geom2])
    grips = np.isin(pairs, pads).any(axis=1)
    assert (grips.sum(), len(pairs)) == (6, 9)
    assert np.allclose(model.pair_friction[grips], [1.2, 1.2, 0.02, 0.0005, 0.0005])
    assert np.allclose(model.pair_friction[~grips], [0.8, 0.8, 0.01, 0.0005, 0.0005])
    assert np.allclose(model.pair_solref[grips], model.geom_solref[pads[0]]) and set(model.pair_dim) == {4}
    other = perturbed(scene, Perturbation(friction=0.5, pads=0.5), seed=1).mujoco
    factors = other.geom_friction[:, 0] / np.maximum(model.geom_friction[:, 0], 1e-6)
    assert np.allclose(other.pair_friction[:, :2] / model.pair_friction[:, :2], factors[pairs].prod(axis=1)[:, None])


def test_an_object_slides_as_far_as_its_own_friction_and_that_of_the_table_say(scene: Scene) -> None:
    far = []
    for factor, table in ((1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (0.5, 0.5)):
        model = copy.copy(scene.mujoco)
        scale_friction(model, {"pink": factor}, pads={}, table=table)
        data = initial_state(scene)
        slider = data.joint("pink")
        slider.qpos[:], slider.qvel[0] = [0.35, 0.0, 0.0225, 1, 0, 0, 0], 0.3
        mujoco.mj_step(model, data, nstep=200)
        far.append(slider.qpos[0] - 0.35)
    assert far == pytest.approx(np.array([1, 2, 2, 4]) * 0.3**2 / (2 * 9.81), rel=0.1)


def test_force_centres_latency_and_bias_stay_within_their_amounts(scene: Scene) -> None:
    amounts = read_perturbation("force=0.5,centre=8,latency=100,bias=3,table=0.5")
    found = []
    for seed in range(20):
        other = perturbed(scene, amounts, seed=seed)
        motors = [one.mujoco.actuator(scene.robot.gripper.actuator) for one in (other, scene)]
        force = motors[0].forcerange[1] / motors[1].forcerange[1]
        assert motors[0].gainprm[0] / motors[1].gainprm[0] == pytest.approx(force)
        assert other.latency / TIMESTEP_S == pytest.approx(round(other.latency / TIMESTEP_S))
        bias = camera_bias(amounts, seed=seed)
        table = (other.mujoco.geom("pink").friction / scene.mujoco.geom("pink").friction)[0]
        centre = other.mujoco.body("pink").ipos / 0.008
        found.append([force * 2 - 2, table * 2 - 2, other.latency / 0.1 * 2 - 1, *centre, *bias / 0.003])
    assert (np.abs(found) <= 1 + 1e-9).all()
    assert (np.min(found, axis=0) < -0.5).all() and (np.max(found, axis=0) > 0.5).all()


def test_an_object_tips_over_its_edge_when_its_centre_of_mass_is_beyond(scene: Scene) -> None:
    other = perturbed(scene, read_perturbation("centre=8"), seed=1)
    offset = other.mujoco.body("pink").ipos
    data = mujoco.MjData(other.mujoco)
    mujoco.mj_forward(other.mujoco, data)
    body = data.body("pink")
    assert np.allclose(body.xipos - body.xpos, body.xmat.reshape(3, 3) @ offset) and np.abs(offset).max() > 0.001
    for beyond, tips in ((0.003, True), (-0.003, False)):
        # Pink's left edge hangs over blue's, so that its centre of mass is `beyond` it.
        data = initial_state(other)
        data.joint("green").qpos[:2] = [0.3, 0.3]
        edge = data.joint("blue").qpos[:3] - [0.0, 0.0225, -0.0225]
        data.joint("pink").qpos[:3] = edge + [0.0, -beyond - offset[1], 0.0226]
        mujoco.mj_step(other.mujoco, data, nstep=250)
        assert (data.body("pink").xmat[8] < 0.9) == tips


def test_the_nominal_scene_stays_as_it_is_and_so_do_the_robot_and_the_start_poses(scene: Scene) -> None:
    kept = ("geom_friction", "pair_friction", "body_mass", "body_ipos", "actuator_gainprm")
    before = {name: getattr(scene.mujoco, name).copy() for name in kept}
    other = perturbed(scene, replace(read_perturbation(EXTREME), position=0.005, angle=0.1), seed=1)
    assert all(np.array_equal(before[name], getattr(scene.mujoco, name)) for name in kept)
    robot = scene.robot.bodies(scene.mujoco)
    assert np.array_equal(other.mujoco.body_mass[robot], before["body_mass"][robot])
    assert np.array_equal(initial_state(scene, seed=1).qpos, initial_state(other, seed=1).qpos)
    assert perturbed(scene, Perturbation(), seed=1) is scene


def test_a_key_draws_the_same_whatever_the_others_are(scene: Scene) -> None:
    one = perturbed(scene, read_perturbation("table=0.3,friction=0.2"), seed=3)
    all_keys = perturbed(scene, replace(read_perturbation(EXTREME), table=0.3, friction=0.2), seed=3)
    assert one.mujoco.geom("blue").friction[0] == pytest.approx(all_keys.mujoco.geom("blue").friction[0])
    assert (one.latency, one.mujoco.body("blue").mass[0]) == (0.0, scene.mujoco.body("blue").mass[0])


def test_objects_never_start_inside_one_another(scene: Scene) -> None:
    for seed in range(100):
        data = initial_state(scene, seed=seed, position=0.008, angle=np.radians(10))
        assert min(data.contact.dist, default=0) > -0.001


def test_objects_without_room_for_the_perturbation_are_told(scene: Scene) -> None:
    told = []
    for seed in range(20):
        try:
            initial_state(scene, seed=seed, position=0.03, angle=0.5, draws=1)
        except SimulationError as error:
            told.append(str(error))
    assert 0 < len(told) < 20
    assert set(told) == {"objects moved by up to 30 mm stand inside one another or fall; move them by less"}
