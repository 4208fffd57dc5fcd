"""A scene as MJCF, MuJoCo's own format: one XML file and the meshes and textures that it names."""

import io
import os
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image

from sim.export.geoms import pixels_of
from sim.world.scene import Scene, initial_state

ASSETS = "assets"
"""Folder of meshes and textures."""

START = "start"
"""Name of the keyframe with the arm at home and the objects at their start."""


def encode_mjcf(scene: Scene) -> dict[str, bytes]:
    """Return the files of a scene by their paths; `scene.xml` is the last, and names the others."""
    model, spec, files = scene.mujoco, scene.spec.copy(), {}
    for i, mesh in enumerate(spec.meshes):
        source = _source(model, model.mesh_pathadr[i])
        path = f"{ASSETS}/{i:03}_{_plain(mesh.name)}{source.suffix if source else '.obj'}"
        files[path] = source.read_bytes() if source else _obj(mesh)
        _move(mesh, path)
    for i, texture in enumerate(spec.textures):
        stem = f"{ASSETS}/{i:03}_{_plain(texture.name)}"
        source = _source(model, model.tex_pathadr[i])
        if any(texture.cubefiles):
            sides = np.split(pixels_of(model, i), len(texture.cubefiles))
            texture.cubefiles = [f"{stem}_{side}.png" for side in range(len(sides))]
            texture.hflip = texture.vflip = False
            files |= dict(zip(texture.cubefiles, map(_png, sides), strict=True))
        elif source or len(texture.data):
            path = f"{stem}{source.suffix if source else '.png'}"
            files[path] = source.read_bytes() if source else _png(pixels_of(model, i))
            texture.file, texture.data, texture.content_type = path, b"", ""
    for i, field in enumerate(spec.hfields):
        source = _source(model, model.hfield_pathadr[i])
        if source:
            field.file = f"{ASSETS}/{i:03}_{_plain(field.name)}{source.suffix}"
            files[field.file] = source.read_bytes()
    spec.meshdir = spec.texturedir = spec.modelfiledir = ""
    start = initial_state(scene)
    spec.add_key(name=START, qpos=start.qpos, ctrl=start.ctrl)
    spec.assets = files
    spec.compile()
    files["scene.xml"] = spec.to_xml().encode()
    return files


def _move(mesh: mujoco.MjsMesh, path: str) -> None:
    """Replace the data of a mesh in memory by the path of a file."""
    mesh.file, mesh.content_type = path, ""
    mesh.uservert, mesh.usernormal, mesh.usertexcoord = [], [], []
    mesh.userface, mesh.userfacenormal, mesh.userfacetexcoord = [], [], []


def _plain(name: str) -> str:
    """Return a name that is valid in every file system."""
    return "".join(letter if letter.isalnum() else "_" for letter in name) or "part"


def _source(model: mujoco.MjModel, place: int) -> Path | None:
    """Return the path that begins at a place in the model's array of paths; None for a part without a file."""
    return None if place < 0 else Path(os.fsdecode(model.paths[place : model.paths.index(b"\0", place)]))


def _png(pixels: np.ndarray) -> bytes:
    """Return a picture as a PNG file."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="PNG")
    return file.getvalue()


def _obj(mesh: mujoco.MjsMesh) -> bytes:
    """Return a mesh in memory as a Wavefront OBJ file, with the normals and texture coordinates of its vertices."""
    normals, uv = np.reshape(mesh.usernormal, (-1, 3)), np.reshape(mesh.usertexcoord, (-1, 2))
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in np.reshape(mesh.uservert, (-1, 3))]
    # In MuJoCo, v points down.
    lines += [f"vt {u:.9g} {1 - v:.9g}" for u, v in uv]
    lines += [f"vn {x:.7g} {y:.7g} {z:.7g}" for x, y, z in normals]
    corner = "/".join(["{0}", "{0}" if len(uv) else "", "{0}" if len(normals) else ""]).rstrip("/")
    for triangle in np.reshape(mesh.userface, (-1, 3)) + 1:
        lines.append("f " + " ".join(corner.format(n) for n in triangle))
    return ("\n".join(lines) + "\n").encode()
