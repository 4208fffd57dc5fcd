"""A run as binary glTF, read back by `glb_files` and compared with MuJoCo's forward kinematics."""

from __future__ import annotations

import io

import mujoco
import numpy as np
import pytest
import trimesh
from forged_logs import cut
from glb_files import GlbFile

from sim.evidence.log import Log
from sim.export.geoms import appearance_of
from sim.export.gltf import encode_glb
from sim.world.scene import Scene

TOLERANCE_M, TOLERANCE_RAD = 1e-4, 1e-4

UPRIGHT = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""From MuJoCo's axes, z upwards, to those of glTF, y upwards."""


@pytest.fixture(scope="module")
def data(arch_log: Log) -> bytes:
    return encode_glb({"whole": arch_log, "beginning": cut(arch_log, 8.0)})


@pytest.fixture(scope="module")
def file(data: bytes) -> GlbFile:
    return GlbFile(data)


def test_every_body_is_where_the_log_has_it_in_every_frame(file: GlbFile, scene: Scene, arch_log: Log) -> None:
    model, world = scene.mujoco, mujoco.MjData(scene.mujoco)
    bodies = {model.body(i).name: i for i in range(1, model.nbody) if model.body(i).name}
    for name, log in (("whole", arch_log), ("beginning", cut(arch_log, 8.0))):
        poses = file.poses(name, log.times)
        for k, qpos in enumerate(log.qpos):
            world.qpos[:] = qpos
            mujoco.mj_kinematics(model, world)
            for body, i in bodies.items():
                place, turn = UPRIGHT @ world.xpos[i], UPRIGHT @ world.xmat[i].reshape(3, 3)
                assert np.abs(poses[body][k, :3, 3] - place).max() < TOLERANCE_M, (body, k)
                # The norm of the difference of two rotations is sqrt(8) times the sine of half the angle between them.
                assert np.linalg.norm(poses[body][k, :3, :3] - turn) < np.sqrt(2) * TOLERANCE_RAD, (body, k)
        times = [channel[0] for channel in file.channels(name).values()]
        assert min(map(np.min, times)) == log.times[0]
        assert max(map(np.max, times)) == pytest.approx(log.times[-1], abs=1e-5)


def test_what_is_drawn_is_where_mujoco_draws_it(data: bytes, scene: Scene, arch_log: Log) -> None:
    model, world = scene.mujoco, mujoco.MjData(scene.mujoco)
    world.qpos[:] = arch_log.qpos[0]
    mujoco.mj_kinematics(model, world)
    loaded = trimesh.load_scene(io.BytesIO(data), file_type="glb")
    for geom in np.flatnonzero(model.geom_group <= 2):
        body = model.body(model.geom_bodyid[geom]).name
        nodes = [node for node in loaded.graph.nodes_geometry if node.startswith(f"{body}, geom {geom}")]
        matrix, mesh = loaded.graph[nodes[-1]]
        corners = trimesh.transform_points(loaded.geometry[mesh].vertices, matrix)
        middle, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        local = (corners @ UPRIGHT - world.geom_xpos[geom]) @ world.geom_xmat[geom].reshape(3, 3)
        assert np.allclose([local.min(axis=0), local.max(axis=0)], [middle - half, middle + half], atol=5e-4), nodes


def test_a_lamp_is_on_while_its_location_works(file: GlbFile, arch_log: Log) -> None:
    lamps = [node for node in file.nodes if node.endswith(" on")]
    # Keyframes have 32-bit times, up to a microsecond later than the log's.
    poses = file.poses("whole", arch_log.times + 1e-5)
    assert lamps and np.ptp(arch_log.glow) == 1 + arch_log.glow.max()
    for lamp in lamps:
        assert np.array_equal(np.linalg.det(poses[lamp][:, :3, :3]) > 0.5, arch_log.glow >= 0)
        off = poses[lamp.removesuffix("on") + "off"][:, :3, :3]
        assert np.array_equal(np.linalg.det(off) > 0.5, arch_log.glow < 0)
        material = file.tree["meshes"][file.nodes[lamp]["mesh"]]["primitives"][0]["material"]
        assert max(file.tree["materials"][material]["emissiveFactor"]) == 1


def test_the_file_obeys_the_specification_and_is_small(file: GlbFile, data: bytes) -> None:
    tree = file.tree
    assert tree["asset"]["version"] == "2.0" and tree["extensionsUsed"] == ["KHR_lights_punctual"]
    for index, accessor in enumerate(tree["accessors"]):
        values = file.array(index)
        assert np.isfinite(values).all()
        assert np.allclose(accessor["min"], values.min(axis=0)) and np.allclose(accessor["max"], values.max(axis=0))
    for mesh in tree["meshes"]:
        (part,) = mesh["primitives"]
        names = part["attributes"]
        points, normals = file.array(names["POSITION"]), file.array(names["NORMAL"])
        assert len(points) == len(normals) > file.array(part["indices"]).max()
        assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-3)
        assert 0 <= part["material"] < len(tree["materials"])
    for animation in tree["animations"]:
        for (node, path), (times, values, _) in file.channels(animation["name"]).items():
            assert len(times) == len(values) and (np.diff(times) > 0).all()
            assert "matrix" not in file.nodes[node]
            assert path != "rotation" or np.allclose(np.linalg.norm(values, axis=1), 1, atol=1e-6)
    assert len(data) < 2_000_000


def test_objects_have_their_colours_in_linear_light(file: GlbFile, scene: Scene) -> None:
    for obj in scene.model.objects:
        assert obj.rgba is not None
        (node,) = (node for name, node in file.nodes.items() if name.startswith(f"{obj.name}, geom"))
        material = file.tree["materials"][file.tree["meshes"][node["mesh"]]["primitives"][0]["material"]]
        geom = int(scene.mujoco.body(obj.name).geomadr[0])
        shininess = scene.mujoco.mat_shininess[scene.mujoco.geom_matid[geom]]
        roughness = material["pbrMetallicRoughness"]["roughnessFactor"]
        assert roughness == pytest.approx((1 + 64 * shininess) ** -0.25, rel=1e-3), "as wide a highlight"
        colour = material["pbrMetallicRoughness"]["baseColorFactor"]
        assert np.allclose(np.array(colour[:3]) ** (1 / 2.2), obj.rgba[:3], atol=0.03) and colour[3] == 1


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_a_texture_may_be_grey_or_transparent(channels: int) -> None:
    spec = mujoco.MjSpec()
    spec.add_texture(name="paper", type=mujoco.mjtTexture.mjTEXTURE_2D, width=2, height=2, nchannel=channels)
    spec.texture("paper").data = np.repeat(np.array([0, 80, 160, 240], np.uint8), channels).tobytes()
    spec.add_material(name="paper").textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "paper"
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.1, 0.1], material="paper")
    picture = appearance_of(spec.compile(), 0).texture
    assert picture is not None and picture.mode == "RGB" and picture.size == (2, 2)
