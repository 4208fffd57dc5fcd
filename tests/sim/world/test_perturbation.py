from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.errors import SimulationError
from sim.world.randomization import NONE, Perturbation, perturbed, read_perturbation
from sim.world.scene import Scene, initial_state

BLOCKS = ("blue", "pink", "green")


def test_the_text_is_in_millimetres_degrees_and_shares() -> None:
    read = read_perturbation("position=8, angle=10,friction=0.2,mass=0.1,noise=1")
    assert np.allclose(list(vars(read).values()), [0.008, np.radians(10), 0.2, 0.1, 0.001])
    assert read_perturbation("noise=1") == replace(NONE, noise=0.001), "what is not named is not perturbed"
    assert read_perturbation("none") == NONE
    assert str(Perturbation()) == "position=5,angle=5", "by default, 5 mm and 5 degrees"


@pytest.mark.parametrize("text", ["position=5,angle=5", "position=8,angle=10,friction=0.2,mass=0.2,noise=1", "none"])
def test_a_perturbation_is_written_as_it_is_read(text: str) -> None:
    assert str(read_perturbation(text)) == text
    assert read_perturbation(str(read_perturbation(text))) == read_perturbation(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("positon=5", r"unknown perturbation 'positon' \(did you mean 'position'\?\)"),
        ("colour=1", r"valid: position, angle, friction, mass, noise"),
        ("", "unknown perturbation ''"),
        ("angle", "angle: '' is not a number"),
        ("angle=wide", "angle: 'wide' is not a number"),
        ("position=-1", "position: -1 is not an amount"),
        ("position=nan", "position: nan is not an amount"),
        ("mass=1.5", "mass: 1.5 is not a share below 1"),
        ("mass=0.1,mass=0.2", "mass: given twice"),
    ],
)
def test_a_text_that_says_none_is_refused(text: str, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        read_perturbation(text)


def test_friction_and_mass_stay_within_their_shares_and_follow_the_seed(scene: Scene) -> None:
    amounts = Perturbation(friction=0.2, mass=0.1)
    shares = []
    for seed in range(30):
        model, again = (perturbed(scene, amounts, seed=seed).mujoco for _ in range(2))
        assert np.array_equal(model.geom_friction, again.geom_friction)
        assert np.array_equal(model.body_mass, again.body_mass)
        geoms = (*BLOCKS, *scene.robot.gripper.pads)
        friction = [model.geom(name).friction[0] / scene.mujoco.geom(name).friction[0] for name in geoms]
        mass = [model.body(name).mass[0] / scene.mujoco.body(name).mass[0] for name in BLOCKS]
        inertia = [model.body(name).inertia[0] / scene.mujoco.body(name).inertia[0] for name in BLOCKS]
        assert np.allclose(mass, inertia)
        shares.append([*friction, *mass])
    off = np.abs(np.array(shares) - 1)
    assert (off <= [0.2] * 5 + [0.1] * 3).all() and (off.max(axis=0) > [0.15] * 5 + [0.075] * 3).all()
    assert np.allclose(off[:, 3], off[:, 4]), "both pads are of one make"


def test_the_nominal_scene_stays_as_it_is_and_so_do_the_robot_and_the_start_poses(scene: Scene) -> None:
    before = scene.mujoco.geom_friction.copy(), scene.mujoco.body_mass.copy()
    other = perturbed(scene, Perturbation(friction=0.2, mass=0.2), seed=1)
    assert np.array_equal(before[0], scene.mujoco.geom_friction) and np.array_equal(before[1], scene.mujoco.body_mass)
    robot = scene.robot.bodies(scene.mujoco)
    assert np.array_equal(other.mujoco.body_mass[robot], before[1][robot])
    assert np.array_equal(initial_state(scene, seed=1).qpos, initial_state(other, seed=1).qpos)
    assert perturbed(scene, Perturbation(), seed=1) is scene


def test_objects_never_start_inside_one_another(scene: Scene) -> None:
    for seed in range(100):
        data = initial_state(scene, seed=seed, position=0.008, angle=np.radians(10))
        assert min(data.contact.dist, default=0) > -0.001


def test_objects_without_room_for_the_perturbation_are_told(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.world.scene.MAX_DRAWS", 1)
    told = []
    for seed in range(20):
        try:
            initial_state(scene, seed=seed, position=0.03, angle=0.5)
        except SimulationError as error:
            told.append(str(error))
    assert 0 < len(told) < 20
    assert set(told) == {"objects moved by up to 30 mm stand inside one another or fall; move them by less"}
