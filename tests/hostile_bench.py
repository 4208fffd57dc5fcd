"""A run on a user's workbench, whose scene is of two MJCF files, and its log."""

from __future__ import annotations

from pathlib import Path

from forged_logs import log_of_run

from prefplan.scenario.decode import Scenario, load
from sim.evidence.log import Log

BENCH = """
<mujoco model="bench">
  <include file="light.xml"/>
  <worldbody>
    <geom name="floor" type="plane" size="3 3 0.1"/>
    <body name="bench" pos="0.3 0 0.35">
      <geom type="box" size="0.6 0.8 0.35"/>
      <site name="left" pos="0.2 0.1 0.35"/>
      <site name="right" pos="0.2 -0.1 0.35"/>
      <site name="aside" pos="0.15 -0.35 0.35"/>
    </body>
    <body name="cup" pos="0.5 0.1 0.72"><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="0.05"/></body>
    <body name="can" pos="0.45 -0.35 0.73"><freejoint/><geom type="cylinder" size="0.02 0.03" mass="0.1"/></body>
  </worldbody>
</mujoco>
"""

LIGHT = '<mujoco><worldbody><light name="lamp" pos="0 0 3"/></worldbody></mujoco>'

SCENARIO = """
[model]
kind = "manipulation"
start = "home"
scene = "bench.xml"
costs = { transit = 1, grasp = 1, transport = 1, release = 1 }
[model.robot]
at = [0, 0, 0.7]
[model.locations]
left = { site = "left" }
right = { site = "right" }
aside = { site = "aside" }
[model.objects]
cup = { start = "left", body = "cup" }
can = { start = "aside", body = "can" }

[[tasks]]
name = "tidy"
formula = "F cup_right"

[preference]
kind = "order"
"""


def write_bench(folder: Path, *, scene: str = BENCH) -> Scenario:
    """Write the scenario and its scene to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bench.xml").write_text(scene)
    (folder / "light.xml").write_text(LIGHT)
    (folder / "bench.toml").write_text(SCENARIO)
    return load(folder / "bench.toml")


def logged_bench(folder: Path, *, scene: str = BENCH) -> Log:
    """Return the log of its cheapest plan, carried out with seed 3."""
    return log_of_run(write_bench(folder, scene=scene), seed=3)
