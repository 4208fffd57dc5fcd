"""A scene as MJCF, MuJoCo's own format: one XML file, and the files that it names."""

import io
import tempfile
from pathlib import Path
from zipfile import ZipFile

import mujoco
import numpy as np
from PIL import Image

from sim.world.scene import Scene, initial_state

ASSETS = "assets"
"""Folder of meshes and textures."""

START = "start"
"""Name of the keyframe with the arm at home and the objects at their start."""


def encode_mjcf(scene: Scene) -> dict[str, bytes]:
    """Return the files of a scene by their paths; `scene.xml` is the last, and names the others."""
    spec, made = scene.spec.copy(), {}
    # XML holds no textures in memory, and coordinates of meshes to 6 digits only.
    for i, mesh in enumerate(mesh for mesh in spec.meshes if len(mesh.uservert)):
        path = f"{ASSETS}/mesh_{i:03}.obj"
        made[path] = _obj(mesh)
        mesh.file, mesh.content_type = path, ""
        mesh.uservert, mesh.usernormal, mesh.usertexcoord = [], [], []
        mesh.userface, mesh.userfacenormal, mesh.userfacetexcoord = [], [], []
    for i, texture in enumerate(texture for texture in spec.textures if len(texture.data)):
        path = f"{ASSETS}/texture_{i:03}.png"
        made[path] = _png(texture)
        texture.file, texture.data, texture.content_type = path, b"", ""
    spec.assets = made
    start = initial_state(scene)
    spec.add_key(name=START, qpos=start.qpos, ctrl=start.ctrl)
    spec.compile()
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, "scene.zip"))
        spec.encode(path)
        with ZipFile(path) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
    (xml,) = (name for name in files if name.endswith(".xml"))
    return files | {"scene.xml": files.pop(xml)}


def _png(texture: mujoco.MjsTexture) -> bytes:
    """Return a texture in memory as a PNG file."""
    pixels = np.frombuffer(texture.data, dtype=np.uint8)
    pixels = pixels.reshape(texture.height, texture.width, texture.nchannel)
    file = io.BytesIO()
    Image.fromarray(pixels.squeeze()).save(file, format="PNG")
    return file.getvalue()


def _obj(mesh: mujoco.MjsMesh) -> bytes:
    """Return a mesh in memory as a Wavefront OBJ file, with its normals and texture coordinates."""
    vertices, normals = np.reshape(mesh.uservert, (-1, 3)), np.reshape(mesh.usernormal, (-1, 3))
    uv = np.reshape(mesh.usertexcoord, (-1, 2))
    corners = [np.reshape(mesh.userface, (-1, 3)) + 1]
    corners.append(np.reshape(mesh.userfacetexcoord, (-1, 3)) + 1 if len(uv) else np.zeros_like(corners[0]))
    corners.append(np.reshape(mesh.userfacenormal, (-1, 3)) + 1 if len(normals) else np.zeros_like(corners[0]))
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    # In MuJoCo, v points down.
    lines += [f"vt {u:.9g} {1 - v:.9g}" for u, v in uv]
    lines += [f"vn {x:.7g} {y:.7g} {z:.7g}" for x, y, z in normals]
    for triangle in np.stack(corners, axis=-1):
        lines.append("f " + " ".join("/".join(str(n) if n else "" for n in corner).rstrip("/") for corner in triangle))
    return ("\n".join(lines) + "\n").encode()
