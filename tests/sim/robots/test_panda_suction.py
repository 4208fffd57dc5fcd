"""The Panda with a suction cup."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from skill_runs import assert_good

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from sim.errors import SimulationError
from sim.execution.executor import execute
from sim.robots.arms.panda_suction import FORCE_N, PANDA_SUCTION
from sim.simulation.run import Run
from sim.world.grasps import grasps
from sim.world.places import extent
from sim.world.scene import build_scene
from sim.world.shapes import shape_of

COSTS = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}


@pytest.fixture(scope="module")
def rollout(arch_model: ManipulationModel) -> Run:
    actions = ["transit top", "grasp pink", "transport pink bin1", "release pink bin1"]
    return execute(build_scene(arch_model, robot="panda_suction"), actions, seed=1)


def test_it_takes_an_object_by_its_top_and_puts_it_down(rollout: Run) -> None:
    assert_good(rollout)
    assert rollout.placement_error < 0.002


def test_the_cup_draws_only_while_it_holds(rollout: Run) -> None:
    drawing = rollout.controls[:, -1] > 0
    grasp, release = rollout.steps[1], rollout.steps[3]
    steps = np.arange(len(drawing)) * 0.002
    assert drawing[(steps > grasp.end) & (steps < release.start)].all()
    assert not drawing[steps < grasp.start].any() and not drawing[steps > release.end].any()
    held = (rollout.times > grasp.end) & (rollout.times < release.start)
    assert rollout.pad_forces[held] == pytest.approx(FORCE_N, rel=0.2)


def test_its_pull_is_no_torque_of_the_arm(rollout: Run) -> None:
    """The arm's torques do not jump when the suction is switched on or off."""
    assert rollout.loads["torque_rates"].max() < 0.7 * PANDA_SUCTION.torque_rate_limits.min()


def test_a_heavy_object_is_taken_within_the_limits(arch_model: ManipulationModel) -> None:
    """The object does not pull the cup beyond its stop, and the payload compensation does not raise it too early."""
    objects = tuple(replace(obj, mass=1.5) if obj.name == "pink" else obj for obj in arch_model.objects)
    scene = build_scene(replace(arch_model, objects=objects), robot="panda_suction")
    rollout = execute(scene, ["transit top", "grasp pink", "transport pink bin1"])
    assert_good(rollout)
    assert rollout.load_shares["torque_rates"].max() < 0.8
    spring = int(scene.mujoco.joint("suction_cup").qposadr[0])
    assert np.abs(rollout.qpos[-1, spring]) < 5e-4


def test_the_cup_gives_way_and_springs_back() -> None:
    spec = PANDA_SUCTION.spec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = spec.compile()
    data = mujoco.MjData(model)
    PANDA_SUCTION.put(data, PANDA_SUCTION.home, width=PANDA_SUCTION.gripper.opening_m)
    data.xfrc_applied[model.body("suction_cup").id, 2] = 3.5
    mujoco.mj_step(model, data, 500)
    assert -0.005 < data.joint("suction_cup").qpos[0] < -0.002
    data.xfrc_applied[:] = 0
    mujoco.mj_step(model, data, 500)
    assert data.joint("suction_cup").qpos[0] > -1e-4


def test_only_flat_faces_that_the_cup_fits_on_are_taken() -> None:
    box = shape_of(Object("box", "desk", kind="box", size=(0.05, 0.04, 0.02)), PANDA_SUCTION.gripper)
    normals = {tuple(-np.round(grasp.rotation[:, 2]).astype(int)) for grasp in grasps(box, PANDA_SUCTION.gripper)}
    assert normals == {(0, 0, 1), (0, 0, -1)}
    can = shape_of(Object("can", "desk", kind="cylinder", size=(0.05, 0.12)), PANDA_SUCTION.gripper)
    assert {abs(round(float(grasp.rotation[2, 2]))) for grasp in grasps(can, PANDA_SUCTION.gripper)} == {1}
    with pytest.raises(SimulationError, match="0.02 m wide, but the hand grasps objects of at least 0.028 m wide"):
        shape_of(Object("rod", "desk", kind="cylinder", size=(0.02, 0.05)), PANDA_SUCTION.gripper)


def parcel_model(mass: float) -> ManipulationModel:
    """Return a box wider and longer than fingers can take, and a second place for it."""
    places = Location("dock", at=(0.48, 0.22)), Location("van", at=(0.48, -0.22), kind="pad")
    parcel = Object("parcel", "dock", kind="box", size=(0.15, 0.15, 0.10), mass=mass)
    return ManipulationModel("home", COSTS, places, (parcel,), robot="panda_suction")


def test_it_carries_what_is_too_large_for_fingers() -> None:
    actions = ["transit dock", "grasp parcel", "transport parcel van", "release parcel van"]
    assert_good(execute(build_scene(parcel_model(1.0)), actions, seed=1))


def test_what_would_be_torn_off_the_cup_is_refused_whatever_the_arm_can_carry() -> None:
    with pytest.raises(
        SimulationError, match=r"parcel\.mass: 1\.2 kg, but .* at most 1\.\d+ kg of an object 0\.1 m high"
    ):
        build_scene(parcel_model(1.2))


def test_the_space_round_an_object_does_not_depend_on_fingers_that_the_cup_does_not_have() -> None:
    box = Object("box", "desk", kind="box", size=(0.1, 0.1, 0.05))
    assert extent([shape_of(box, PANDA_SUCTION.gripper)]).opening == 0
