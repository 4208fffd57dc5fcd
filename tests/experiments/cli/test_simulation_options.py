"""Values of options that need the simulation."""

from __future__ import annotations

import re
from dataclasses import replace

import click
import mujoco
import pytest
from scenario_texts import cup_scenario

from experiments.cli import options
from experiments.cli.simulation_options import camera_of
from prefplan import PrefplanError
from prefplan.scenario.decode import loads
from sim.robots.arms.panda import PANDA
from sim.world.randomization import KEYS
from sim.world.scene import Scene, build_scene


def watched_scene() -> Scene:
    """Return a scene whose robot's MJCF has a camera."""

    def spec() -> mujoco.MjSpec:
        found = PANDA.mjcf()
        found.worldbody.add_camera(name="door", pos=[2.0, 0.0, 1.0])
        return found

    return build_scene(loads(cup_scenario()).model, robot=replace(PANDA, mjcf=spec))


def help_of(decorator: options.Decorator) -> str:
    command = click.command()(decorator(watched_scene))
    (option,) = command.params
    return str(option.help)


def test_a_camera_is_ours_or_the_scenes_or_anywhere() -> None:
    scene = watched_scene()
    assert [camera_of(name, scene) for name in ("wrist", "door", "156,-28,1.2")] == ["wrist", "door", "156,-28,1.2"]
    valid = "valid: fixed, orbit, wrist, top, door, or a view such as 156,-28,1.2)"
    for wrong, near in {"dor": "did you mean 'door'? ", "zzz": ""}.items():
        with pytest.raises(PrefplanError, match=re.escape(f"--camera: unknown name {wrong!r} ({near}{valid}")):
            camera_of(wrong, scene)


def test_a_wrong_view_and_the_help_give_the_same_example() -> None:
    told, scene = help_of(options.camera), watched_scene()
    with pytest.raises(PrefplanError) as error:
        camera_of("1,2", scene)
    example = str(error.value).rpartition(" ")[2]
    assert example in told and camera_of(example, scene) == example


def test_the_help_of_perturb_names_every_key_with_its_unit() -> None:
    told = help_of(options.perturb)
    clauses = re.findall(r"([a-z (),]+) (?:in|as a) (mm|degrees|ms|share)\b", told)
    found = {name: unit for names, unit in clauses for name in re.sub(r" \([a-z ]+\)|,| and", "", names).split()}
    assert found == {name: key.unit for name, key in KEYS.items()}
