"""Scenes as MJCF: what MuJoCo reads is what is simulated."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image
from scenario_texts import cup_scenario

from prefplan.scenario.decode import loads
from sim.export.mjcf import encode_mjcf
from sim.world.scene import Scene, build_scene, initial_state

SHELF = """[model.fixtures]
shelf = { kind = "shelf", at = [0.7, 0.5, 0], size = [0.2, 0.3, 0.4], yaw = 180, boards = [0.2] }
[model.robot]
at = [0, 0.05, 0.1]
yaw = 10
[model.locations]"""

COUNTS = ("nq", "nv", "nu", "nbody", "ngeom", "nmesh", "ntex", "nmat", "nlight", "ncam", "npair", "nsite")

ARRAYS = (
    *(
        "body_mass",
        "body_pos",
        "body_quat",
        "body_inertia",
        "body_gravcomp",
        "dof_armature",
        "dof_damping",
        "jnt_range",
    ),
    *("geom_pos", "geom_quat", "geom_size", "geom_friction", "geom_contype", "geom_conaffinity", "geom_solref"),
    *("actuator_gainprm", "actuator_biasprm", "actuator_forcerange", "pair_friction", "jnt_actfrcrange"),
    *("mesh_vert", "mesh_texcoord", "mat_rgba", "geom_matid", "light_pos", "light_active", "tex_data", "site_pos"),
)


@pytest.fixture(scope="module", params=["panda", "fetch", "panda_suction"])
def exported(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, mujoco.MjModel]:
    text = cup_scenario().replace("[model.locations]", SHELF)
    scene = build_scene(loads(text).model, robot=request.param)  # type: ignore[arg-type]
    folder: Path = tmp_path_factory.mktemp("scene")
    for name, data in encode_mjcf(scene).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(data)
    return scene, mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


def test_it_is_the_same_model(exported: tuple[Scene, mujoco.MjModel]) -> None:
    ours, theirs = exported[0].mujoco, exported[1]
    assert {name: getattr(theirs, name) for name in COUNTS} == {name: getattr(ours, name) for name in COUNTS}
    for name in ARRAYS:
        assert np.allclose(getattr(theirs, name), getattr(ours, name), rtol=1e-5, atol=1e-5), name
    for name in ("timestep", "impratio", "integrator", "cone", "jacobian", "solver"):
        assert getattr(theirs.opt, name) == getattr(ours.opt, name)


def test_its_keyframe_is_the_start(exported: tuple[Scene, mujoco.MjModel]) -> None:
    scene, model = exported
    start = initial_state(scene)
    assert model.key("start").qpos == pytest.approx(start.qpos, abs=1e-5)
    assert model.key("start").ctrl == pytest.approx(start.ctrl, abs=1e-5)
    assert [model.joint(i).name for i in range(model.njnt)] == [scene.mujoco.joint(i).name for i in range(model.njnt)]


def test_what_is_drawn_in_a_scene_of_ones_own_comes_along(tmp_path: Path) -> None:
    for name in ("side", "top"):
        Image.new("RGB", (8, 8), "red").save(tmp_path / f"{name}.png")
    (tmp_path / "lab.xml").write_text(
        """<mujoco>
          <asset>
            <texture name="crate" type="cube" fileright="side.png" fileleft="side.png" fileup="top.png"
              filedown="top.png" filefront="side.png" fileback="side.png"/>
            <material name="crate" texture="crate"/>
            <mesh name="leaf" vertex="0 0 0 0.1 0 0 0 0.1 0 0 0 0.1" face="0 2 1 0 1 3 0 3 2 1 2 3"
              normal="-1 0 0 1 0 0 0 1 0 0 0 1" texcoord="0 0 0.2 0 0 0.3 0.4 0.5"/>
          </asset>
          <worldbody>
            <geom type="box" size="1 1 0.1" pos="0 0 -0.1"/>
            <geom type="box" size="0.1 0.1 0.1" pos="0.3 0.7 0.1" material="crate"/>
            <geom type="mesh" mesh="leaf" pos="0.3 -0.7 0.1"/>
          </worldbody>
        </mujoco>"""
    )
    text = cup_scenario().replace("[model]", '[model]\nscene = "lab.xml"')
    scene = build_scene(loads(text, path=tmp_path / "lab.toml").model)  # type: ignore[arg-type]
    files = encode_mjcf(scene)
    assert str(tmp_path) not in files["scene.xml"].decode()
    model = mujoco.MjModel.from_xml_string(files["scene.xml"].decode(), files)
    for name in ("tex_data", "mesh_normal", "mesh_texcoord"):
        assert np.allclose(getattr(model, name), getattr(scene.mujoco, name), atol=1e-5), name
