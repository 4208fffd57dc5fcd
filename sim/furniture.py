"""Table, bins, sanitizers and objects as MuJoCo bodies."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from sim.materials import GLOW_OFF, GLOW_ON, Rgba
from sim.panda import HIDDEN, VISIBLE
from sim.places import BLOCK_HALF, FLOOR, LAMP_HALF, Station
from sim.tabletop import Marking, Table, picture

BLOCK_MASS = 0.055
"""Mass of an object, kg: beech of the same size."""

TABLE_THICKNESS = 0.045
TABLE_HEIGHT = 0.74
"""The table's top above the floor, m."""

TABLE_MARGIN = 0.14
"""From what stands on the table to its edge, m."""

FOOT = 0.20
"""Half the square that the robot's foot needs on the table, m."""

BIN_WALL = 0.004
"""Thickness of a bin's walls, m."""

BIN_HEIGHT = 0.036
"""Height of a bin's walls, m: under the palm, which is 6 cm above the table when a block is held by its middle."""

LAMP_HEIGHT = 0.20
"""Height of a lamp's head above the table, m: the arm passes over it."""

RADIUS = 0.0025
"""Rounding of edges, m."""

BOX = mujoco.mjtGeom.mjGEOM_BOX
CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE
PLANE = mujoco.mjtGeom.mjGEOM_PLANE


def yaw_quat(yaw: float) -> np.ndarray:
    """Return the (4,) quaternion of a turn about z, rad."""
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])


def table_for(stations: Sequence[Station]) -> Table:
    """Return a table that holds the robot's foot and every station, the same to the left as to the right."""
    corners = np.concatenate([np.array([[-FOOT, -FOOT], [FOOT, FOOT]]), *(s.outline.corners for s in stations)])
    lamps = [s.lamp + d * LAMP_HALF for s in stations if s.lamp is not None for d in (-1, 1)]
    reach = np.concatenate([corners, *np.reshape(lamps, (-1, 1, 2))])
    side = float(np.abs(reach[:, 1]).max()) + TABLE_MARGIN
    return Table((float(reach[:, 0].min()) - 0.02, float(reach[:, 0].max()) + TABLE_MARGIN), (-side, side))


def add_table(spec: mujoco.MjSpec, table: Table, stations: Sequence[Station]) -> None:
    """Add the table with its printed top, and the floor it stands on."""
    image = picture(table, [_marking(station) for station in stations])
    texture = spec.add_texture(name="tabletop", type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width = image.shape[:2]
    texture.data = image.tobytes()
    material = spec.add_material(name="tabletop", specular=0.25, shininess=0.35)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tabletop"
    body = spec.worldbody.add_body(name="table", pos=[*table.centre, 0.0])
    size = np.array([*table.half, TABLE_THICKNESS / 2])
    body.add_geom(name="table", type=BOX, size=size, pos=[0, 0, -size[2]], group=HIDDEN)
    _rounded(spec, body, "table_look", size + [RADIUS, RADIUS, 0], "table_edge", pos=[0, 0, -size[2] - 0.0005])
    body.add_geom(name="tabletop", type=PLANE, size=[*table.half, 1], material="tabletop", contype=0, conaffinity=0)
    leg = 0.03
    for x in (-1, 1):
        for y in (-1, 1):
            spot = (table.half - 3 * leg) * [x, y]
            height = (TABLE_HEIGHT - TABLE_THICKNESS) / 2
            body.add_geom(
                type=BOX, size=[leg, leg, height], pos=[*spot, -TABLE_THICKNESS - height], material="table_frame"
            )
    spec.worldbody.add_geom(name="floor", type=PLANE, size=[0, 0, 1], pos=[0, 0, -TABLE_HEIGHT], material="floor")


def add_station(spec: mujoco.MjSpec, station: Station) -> None:
    """Add a bin, a pad or nothing, and the lamp; bodies bear the location's name and `<location>_lamp`."""
    outline = station.outline
    body = spec.worldbody.add_body(name=f"{station.name}_base", pos=[*outline.centre, 0.0], quat=yaw_quat(outline.yaw))
    if station.kind == "bin":
        _add_bin(spec, body, outline.half)
    elif station.kind == "pad":
        size = np.array([*outline.half, FLOOR["pad"] / 2])
        body.add_geom(type=BOX, size=size, pos=[0, 0, size[2]], group=HIDDEN)
        _rounded(spec, body, f"{station.name}_look", size, "pad", pos=[0, 0, size[2]], radius=0.0015)
    if station.lamp is not None:
        _add_lamp(spec, station)


def add_block(spec: mujoco.MjSpec, name: str, position: np.ndarray, yaw: float, rgba: Rgba) -> None:
    """Add an object: a free body, its joint and its colliding geom all bear its name."""
    body = spec.worldbody.add_body(name=name, pos=position, quat=yaw_quat(yaw))
    body.add_freejoint(name=name)
    size = np.full(3, BLOCK_HALF)
    geom = body.add_geom(name=name, type=BOX, size=size, mass=BLOCK_MASS, group=HIDDEN)
    geom.friction, geom.condim = [0.8, 0.01, 0.0005], 4
    spec.add_material(name=name, rgba=rgba, specular=0.4, shininess=0.5)
    _rounded(spec, body, f"{name}_look", size, name, pos=[0, 0, 0])


def _marking(station: Station) -> Marking:
    corners = station.outline.corners
    front = float(corners[:, 0].max())
    outlines = ()
    if station.kind == "spot":
        outlines = (station.outline.grown(0.004).corners,)
    gap = 0.022 if station.kind == "bin" else 0.014
    return Marking(station.name, np.array([front + gap, station.outline.centre[1]]), outlines)


def _add_bin(spec: mujoco.MjSpec, body: mujoco.MjsBody, half: np.ndarray) -> None:
    floor = np.array([*half + BIN_WALL, FLOOR["bin"] / 2])
    body.add_geom(type=BOX, size=floor, pos=[0, 0, floor[2]], material="bin_floor")
    for axis in (0, 1):
        for side in (-1, 1):
            size = np.array([*half + 2 * BIN_WALL, BIN_HEIGHT / 2])
            position = np.array([0.0, 0.0, BIN_HEIGHT / 2])
            size[axis], position[axis] = BIN_WALL / 2, side * (half[axis] + BIN_WALL / 2)
            body.add_geom(type=BOX, size=size, pos=position, group=HIDDEN)
            _rounded(spec, body, f"{body.name}_wall{axis}{side}", size, "bin", pos=position, radius=0.0015)


def _add_lamp(spec: mujoco.MjSpec, station: Station) -> None:
    """Add a post whose head faces the station; its tubes share the material `<location>_glow`."""
    assert station.lamp is not None
    towards = station.outline.centre - station.lamp
    yaw = float(np.arctan2(towards[1], towards[0]))
    distance = float(np.hypot(*towards))
    glow = f"{station.name}_glow"
    spec.add_material(name=glow, rgba=GLOW_OFF, specular=0.4, shininess=0.6)
    body = spec.worldbody.add_body(name=f"{station.name}_lamp", pos=[*station.lamp, 0.0], quat=yaw_quat(yaw))
    body.add_geom(type=CYLINDER, size=[LAMP_HALF, 0.006, 0], pos=[0, 0, 0.006], material="lamp")
    body.add_geom(type=CAPSULE, size=[0.007, LAMP_HEIGHT / 2, 0], pos=[0, 0, LAMP_HEIGHT / 2], material="lamp")
    tilt = float(np.arctan2(LAMP_HEIGHT, distance))
    head = body.add_body(pos=[0, 0, LAMP_HEIGHT], quat=[np.cos(tilt / 2), 0, np.sin(tilt / 2), 0])
    size = np.array([0.010, 0.075, 0.020])
    head.add_geom(type=BOX, size=size, group=HIDDEN)
    _rounded(spec, head, f"{station.name}_head", size, "lamp", pos=[0, 0, 0], radius=0.006)
    for z in (-0.008, 0.008):
        head.add_geom(
            type=CAPSULE,
            size=[0.0045, 0.060, 0],
            pos=[0.010, 0, z],
            quat=[np.sqrt(0.5), np.sqrt(0.5), 0, 0],
            material=glow,
            contype=0,
            conaffinity=0,
        )
    light = head.add_light(name=glow, pos=[0.015, 0, 0], dir=[1, 0, 0], castshadow=False, active=False)
    light.type = mujoco.mjtLightType.mjLIGHT_SPOT
    light.diffuse, light.specular = np.multiply(GLOW_ON[:3], 0.9), [0.1] * 3
    light.cutoff, light.exponent, light.attenuation = 40, 8, [1, 0, 0]


def _rounded(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    name: str,
    half: np.ndarray,
    material: str,
    *,
    pos: np.ndarray | list[float],
    radius: float = RADIUS,
) -> None:
    """Draw a box with rounded edges, which catch the light; it collides with nothing."""
    vertices, normals, faces = rounded_box(half, radius)
    mesh = spec.add_mesh(name=name, uservert=vertices.ravel(), userface=faces.ravel())
    mesh.usernormal, mesh.userfacenormal = normals.ravel(), faces.ravel()
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=material, pos=pos)
    geom.contype = geom.conaffinity = geom.mass = 0
    geom.group = VISIBLE


def rounded_box(half: np.ndarray, radius: float, steps: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a box with rounded edges as vertices (V, 3), normals (V, 3) and faces (F, 3).

    Every face of the box is a grid, dense along its rim; a point at depth d inside the rim is pushed onto the
    sphere or cylinder of that radius about the inner box.
    """
    vertices, normals, faces = [], [], []
    ramp = np.linspace(0, radius, steps + 1)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        lines = [np.concatenate([ramp - half[a], half[a] - ramp[::-1]]) for a in (u, v)]
        for side in (-1, 1):
            grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
            points = np.empty((*grid.shape[:2], 3))
            points[..., axis], points[..., u], points[..., v] = side * half[axis], grid[..., 0], grid[..., 1]
            inner = np.clip(points, radius - half, half - radius)
            normal = (points - inner) / np.linalg.norm(points - inner, axis=-1, keepdims=True)
            rows, columns = grid.shape[:2]
            corner = np.arange(rows * columns).reshape(rows, columns)
            a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
            quads = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
            faces.append((quads if side > 0 else quads[:, ::-1]) + sum(len(known) for known in vertices))
            vertices.append((inner + radius * normal).reshape(-1, 3))
            normals.append(normal.reshape(-1, 3))
    return np.concatenate(vertices), np.concatenate(normals), np.concatenate(faces)
