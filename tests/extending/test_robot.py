"""A robot of one's own, from outside: a column turns a beam about the vertical, and the beam lowers the hand."""

import mujoco
import numpy as np
import pytest

import sim
from prefplan.models.manipulation.model import Location, ManipulationModel, Object

MJCF = """<mujoco>
  <default><default class="finger">
    <joint type="slide" axis="0 1 0" range="0 0.04" armature="0.1" damping="1"/>
    <geom type="box" size="0.01 0.01 0.05" pos="0 0.01 0.04" mass="0.02" contype="2" condim="4" priority="1"
      friction="1.2 0.02 0.0005" solref="0.004 1" solimp="0.95 0.99 0.001"/>
  </default></default>
  <worldbody>
    <body name="column" gravcomp="1">
      <joint name="turn" axis="0 0 1" range="-150 150"/>
      <geom type="box" size="0.05 0.05 0.4" pos="0 0 0.45" contype="2"/>
      <body name="beam" gravcomp="1">
        <joint name="lift" type="slide" axis="0 0 1" range="0 0.6"/>
        <geom type="box" size="0.25 0.03 0.1" pos="0.25 0 0.2" mass="2" contype="2"/>
        <site name="tool" pos="0.5 0 0" euler="180 0 0"/>
        <body pos="0.5 0 0" childclass="finger"><joint name="left"/><geom name="l"/></body>
        <body pos="0.5 0 0" euler="0 0 180" childclass="finger"><joint name="right"/><geom name="r"/></body>
    </body></body>
  </worldbody>
  <tendon><fixed name="width"><joint joint="left" coef="1"/><joint joint="right" coef="1"/></fixed></tendon>
  <equality><joint joint1="left" joint2="right" solref="0.005 1"/></equality>
  <actuator>
    <position name="turn" joint="turn" kp="4000" kv="400"/>
    <position name="lift" joint="lift" kp="4000" kv="400"/>
    <position name="hand" tendon="width" kp="1000" kv="50" ctrlrange="0 0.08"/>
  </actuator>
</mujoco>"""
CRANE = sim.Robot(
    "crane",
    lambda: mujoco.MjSpec.from_string(MJCF),
    base="column",
    joints=("turn", "lift"),
    velocity_limits=np.array([2.0, 1.0]),
    torque_limits=np.array([200.0, 400.0]),
    home=np.array([0.0, 0.4]),
    tool="tool",
    gripper=sim.Gripper("hand", ("left", "right"), ("l", "r"), 0.08, 0.015, 5, 0.022, 0.012, 0.012, 0.04, 0.024),
)


def test_a_robot_from_outside_carries_out_a_plan() -> None:
    costs = {"transit": 1, "grasp": 1, "transport": 1, "release": 1}
    places, cup = (Location("a", at=(0.5, 0.0)), Location("b", at=(0.3, 0.4))), Object("cup", "a")
    scene = sim.build_scene(ManipulationModel("home", costs, places, (cup,)), robot=CRANE)
    rollout = sim.execute(scene, ["transit a", "grasp cup", "transport cup b", "release cup b"])
    assert rollout.completed, rollout.reason
    first = scene.mujoco.joint("cup").qposadr[0]
    assert rollout.qpos[-1, first : first + 2] == pytest.approx([0.3, 0.4], abs=0.002)
