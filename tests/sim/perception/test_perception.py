"""Perception: sensors, and the states grounded in their observations."""

from __future__ import annotations

import numpy as np
import pytest

from prefplan.models.manipulation.model import Object
from sim.execution.faults.blind import DropoutSensor
from sim.perception.sensors import (
    ExactSensor,
    NoisySensor,
    ObjectPose,
    ObservationTimeoutError,
    mean_pose,
    object_pose,
)
from sim.robots.arms.panda import PANDA
from sim.simulation.workcell import Workcell
from sim.world.scene import Scene, initial_state
from sim.world.shapes import about_z, shape_of


def test_an_exact_sensor_sees_what_is_and_a_noisy_one_repeats_itself_by_seed(scene: Scene) -> None:
    data = initial_state(scene, seed=1)
    true = object_pose(scene, data, "pink")
    sensors = (ExactSensor(), *(NoisySensor(0.001, seed=seed) for seed in (1, 1, 2)))
    exact, first, again, other = (sensor.observe(scene, data, "pink") for sensor in sensors)
    assert exact and first and again and other
    assert np.array_equal(exact.position, true.position) and exact.yaw == true.yaw
    assert np.array_equal(first.position, again.position) and not np.array_equal(first.position, other.position)
    biased = NoisySensor(0.0, seed=0, bias=np.array([0.001, 0.0, -0.002])).observe(scene, data, "pink")
    assert biased and np.allclose(biased.position - true.position, [0.001, 0.0, -0.002]) and biased.yaw == true.yaw


def test_noise_is_as_large_as_it_says_and_less_in_a_measurement(scene: Scene) -> None:
    data = initial_state(scene, seed=1)
    true = object_pose(scene, data, "pink")
    cell = Workcell(scene, data, sensor=NoisySensor(0.001, seed=5))
    poses = [cell.observe("pink") for _ in range(400)]
    errors = np.array([pose.position - true.position for pose in poses])
    assert np.allclose(errors.std(axis=0), 0.001, rtol=0.15) and np.all(np.abs(errors.mean(axis=0)) < 0.0002)
    means = np.array([mean_pose(poses[k : k + 10]).position - true.position for k in range(0, 400, 10)])
    assert np.allclose(means.std(axis=0), 0.001 / np.sqrt(10), rtol=0.4)
    turns = np.array([np.sin(2 * (pose.yaw - true.yaw)) / 2 for pose in poses])
    assert turns.std() == pytest.approx(0.001 / 0.0225, rel=0.15)


@pytest.mark.parametrize("turn", [0, 25, -70, 130])
def test_the_footprint_of_a_box_is_its_outline_however_it_is_turned(turn: int) -> None:
    shape = shape_of(Object("x", "spot", kind="box", size=(0.075, 0.045, 0.03)), PANDA.gripper)
    rotation = about_z(np.radians(turn))
    corners = ObjectPose(shape, np.array([0.5, 0.1, 0.015]), rotation).footprint.corners
    outline = [0.5, 0.1] + np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * shape.half[:2] @ rotation[:2, :2].T
    assert np.allclose(sorted(corners.round(9).tolist()), sorted(outline.round(9).tolist()))


def test_looks_of_a_noisy_sensor_take_time_and_those_of_an_exact_one_none(scene: Scene) -> None:
    for sensor, seconds in ((ExactSensor(), 0.0), (NoisySensor(0.001, seed=0), 0.09)):
        cell = Workcell(scene, initial_state(scene), sensor=sensor)
        cell.measure("pink")
        assert cell.data.time == pytest.approx(seconds)


def test_what_is_not_seen_is_waited_for_but_not_for_ever(scene: Scene) -> None:
    cell = Workcell(scene, initial_state(scene), sensor=DropoutSensor(ExactSensor(), until=1.0))
    assert cell.latest_pose("pink") is None
    cell.observe("pink")
    assert cell.data.time == pytest.approx(1.0, abs=0.011)
    cell.sensor = DropoutSensor(cell.sensor, until=np.inf)
    with pytest.raises(ObservationTimeoutError, match="nothing has been seen of pink for 5 s"):
        cell.observe("pink")
