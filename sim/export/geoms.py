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

TEXTURE_QUALITY = 80
"""JPEG quality of textures."""

UNSET = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour of a geom, in place of which it uses that of the material."""

DEFAULT_SHININESS = 0.5
"""MuJoCo's value for a geom without a material."""


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
        """Return the material without its colours: `encode_glb` sets those, which trimesh would round."""
        return PBRMaterial(
            name=self.name,
            metallicFactor=0.0,
            roughnessFactor=self.roughness,
            baseColorTexture=self.texture,
            alphaMode="OPAQUE" if self.colour[3] == 1 else "BLEND",
        )


def linear(colour: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    """Return an sRGB colour as linear RGB, as glTF needs it (IEC 61966-2-1); a fourth value, the opacity, is kept."""
    light = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour[:3]]
    return *map(float, light), *map(float, colour[3:])


def appearance_of(model: mujoco.MjModel, geom: int) -> Appearance:
    """Return the appearance of a geom."""
    material, rgba = int(model.geom_matid[geom]), model.geom_rgba[geom]
    if material < 0:
        name = "plain " + " ".join(f"{value:.3g}" for value in rgba)
        return Appearance(name, linear(rgba), (0.0, 0.0, 0.0), roughness=_roughness(DEFAULT_SHININESS))
    name = str(model.mat(material).name)
    if np.allclose(rgba, UNSET):
        rgba = model.mat_rgba[material]
    else:
        name += " " + " ".join(f"{value:.3g}" for value in rgba)
    emission = model.mat_emission[material] * np.array(linear(rgba[:3]))
    return Appearance(
        name,
        linear(rgba),
        tuple(emission.tolist()),
        roughness=_roughness(float(model.mat_shininess[material])),
        texture=_texture(model, material),
    )


def _roughness(shininess: float) -> float:
    """Return the roughness whose highlight is as wide as that of the Blinn-Phong exponent, 128 times `shininess`."""
    return float((2 / (2 + 128 * shininess)) ** 0.25)


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


def _texture(model: mujoco.MjModel, material: int) -> Image.Image | None:
    texture = int(model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture < 0 or model.tex_type[texture] != mujoco.mjtTexture.mjTEXTURE_2D:
        return None
    size = (model.tex_height[texture], model.tex_width[texture], model.tex_nchannel[texture])
    start = model.tex_adr[texture]
    pixels = model.tex_data[start : start + np.prod(size)].reshape(size)
    # MuJoCo stores rows from the bottom up.
    image, file = Image.fromarray(pixels[::-1, :, :3]), io.BytesIO()
    image.save(file, format="JPEG", quality=TEXTURE_QUALITY)
    return Image.open(file)


def _compiled(model: mujoco.MjModel, mesh: int) -> trimesh.Trimesh:
    """Return a compiled mesh; a vertex with several normals or texture coordinates is split."""

    def part(values: np.ndarray, starts: np.ndarray, counts: np.ndarray) -> np.ndarray:
        return np.array(values[starts[mesh] : starts[mesh] + counts[mesh]])

    faces = part(model.mesh_face, model.mesh_faceadr, model.mesh_facenum)
    normals = part(model.mesh_facenormal, model.mesh_faceadr, model.mesh_facenum)
    corners = [faces.ravel(), normals.ravel()]
    mapped = model.mesh_texcoordadr[mesh] >= 0
    if mapped:
        corners.append(part(model.mesh_facetexcoord, model.mesh_faceadr, model.mesh_facenum).ravel())
    unique, index = np.unique(np.stack(corners, axis=1), axis=0, return_inverse=True)
    solid = trimesh.Trimesh(
        part(model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum)[unique[:, 0]],
        index.reshape(-1, 3),
        vertex_normals=part(model.mesh_normal, model.mesh_normaladr, model.mesh_normalnum)[unique[:, 1]],
        process=False,
    )
    uv = part(model.mesh_texcoord, model.mesh_texcoordadr, model.mesh_texcoordnum)[unique[:, 2]] if mapped else None
    solid.visual = TextureVisuals(uv=uv)
    return solid
