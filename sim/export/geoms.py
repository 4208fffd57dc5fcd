"""Geoms of a MuJoCo model as meshes with physically based materials."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import trimesh
from PIL import Image
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

from sim.geometry.mjcf import plain_solid
from sim.geometry.solids import smoothed
from sim.world.materials import Rgba


@dataclass(frozen=True)
class Appearance:
    """How the surface of a geom looks.

    Attributes:
        name: of the material, unique for each appearance.
        colour: (4,) linear RGB and opacity.
        emission: (3,) linear RGB.
        roughness: 0 .. 1.
        texture: multiplied with the colour, or None.
    """

    name: str
    colour: tuple[float, ...]
    emission: tuple[float, ...]
    roughness: float
    texture: Image.Image | None = None

    def glowing(self, colour: Rgba) -> Appearance:
        """Return the same appearance, glowing in a colour (sRGB)."""
        return replace(self, name=f"{self.name} on", colour=linear(colour), emission=linear(colour)[:3])

    def material(self) -> PBRMaterial:
        """Return the material without its colours: trimesh would round them, so `encode_glb` sets them."""
        return PBRMaterial(
            name=self.name,
            metallicFactor=0.0,
            roughnessFactor=self.roughness,
            baseColorTexture=self.texture,
            alphaMode="OPAQUE" if self.colour[3] == 1 else "BLEND",
        )


def linear(colour: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    """Return an sRGB colour as linear RGB, as glTF needs it; a fourth value, the opacity, is kept."""
    light = trimesh.visual.color.srgb_to_linear(np.array(colour[:3], dtype=float))
    return *light.tolist(), *map(float, colour[3:])


def appearance_of(model: mujoco.MjModel, geom: int) -> Appearance:
    """Return the appearance of a geom."""
    material, rgba = int(model.geom_matid[geom]), model.geom_rgba[geom]
    has_material = material >= 0
    name = str(model.mat(material).name) if has_material else "plain"
    if has_material and np.allclose(rgba, [0.5, 0.5, 0.5, 1]):  # MuJoCo's default, for which the material's is used
        rgba = model.mat_rgba[material]
    else:
        name += " " + " ".join(f"{value:.3g}" for value in rgba)
    glows, shines = (model.mat_emission[material], model.mat_shininess[material]) if has_material else (0.0, 0.5)
    return Appearance(
        name,
        linear(rgba),
        tuple((glows * np.array(linear(rgba[:3]))).tolist()),
        # The highlight is as wide as with the Blinn-Phong exponent, which is 128 times the shininess.
        roughness=float((2 / (2 + 128 * shines)) ** 0.25),
        texture=_texture(model, material) if has_material else None,
    )


def solid_of(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh | None:
    """Return the mesh of a geom in the geom's frame, m, or None for unbounded types, such as a plane."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        return _compiled(model, int(model.geom_dataid[geom]))
    shape = plain_solid(model, geom)
    if shape is None:
        return None
    solid = smoothed(shape)
    solid.visual = TextureVisuals()
    return solid


def pixels_of(model: mujoco.MjModel, texture: int) -> np.ndarray:
    """Return the pixels of a texture, (height, width, channels) uint8, or (height, width) of one channel."""
    size = [int(model.tex_height[texture]), int(model.tex_width[texture]), int(model.tex_nchannel[texture])]
    start = model.tex_adr[texture]
    return np.asarray(model.tex_data[start : start + np.prod(size)].reshape(size[:2] if size[2] == 1 else size))


def _texture(model: mujoco.MjModel, material: int) -> Image.Image | None:
    texture = int(model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture < 0 or model.tex_type[texture] != mujoco.mjtTexture.mjTEXTURE_2D:
        return None
    # MuJoCo stores rows from the bottom up.
    image, file = Image.fromarray(pixels_of(model, texture)[::-1]), io.BytesIO()
    image.convert("RGB").save(file, format="JPEG")
    return Image.open(file)


def _compiled(model: mujoco.MjModel, mesh: int) -> trimesh.Trimesh:
    """Return a compiled mesh; a vertex with several normals or texture coordinates is split."""
    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    corners = np.stack([model.mesh_face[faces], model.mesh_facenormal[faces], model.mesh_facetexcoord[faces]], axis=-1)
    unique, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    vertices, normals, texture = unique.T
    solid = trimesh.Trimesh(
        model.mesh_vert[model.mesh_vertadr[mesh] + vertices],
        index.reshape(-1, 3),
        vertex_normals=model.mesh_normal[model.mesh_normaladr[mesh] + normals],
        process=False,
    )
    start = model.mesh_texcoordadr[mesh]
    solid.visual = TextureVisuals(uv=None if start < 0 else model.mesh_texcoord[start + texture])
    return solid
