"""Table, bins, sanitizers and objects as MuJoCo bodies."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from sim.geometry.mjcf import HIDDEN, VISIBLE, add_solid
from sim.geometry.rectangle import Rectangle, overlap
from sim.geometry.solids import Solid, dish, plate, rounded_box, rounded_cylinder, tray
from sim.world.materials import LAMP_GLOW, Rgba, glow_of
from sim.world.places import FLOOR, LAMP_HALF, Station
from sim.world.shapes import ObjectShape
from sim.world.tabletop import Marking, Table, picture, text_size

TABLE_THICKNESS = 0.045
"""Thickness of the table's board, m."""

PLINTH_HEIGHT, PLINTH_INSET = 1.0, 0.05
"""What carries the board, m: it leaves the picture below, which spares drawing a floor (a quarter of the time)."""

TABLE_MARGIN = 0.10
"""From what stands on the table to its edge, m."""

TABLE_LEAST = 0.35
"""Half the table's width at least, m."""

FOOT = 0.22
"""Half the square that the robot's foot needs on the table, m."""

BIN_WALL = 0.004
"""Thickness of a bin's walls, m."""

BIN_HEIGHT = 0.036
"""Height of a bin's walls, m: under the palm, which is 6 cm above the table when a block is held by its middle."""

LAMP_HEIGHT = 0.20
"""Height of a lamp's head above the table, m: the arm passes over it."""

NAME_GAP = 0.012
"""Between a location and its name on the table, m: a bin's wall stands within it."""

LAMP_FADING = [0.0, 0.0, 10.0]
"""Attenuation of a lamp's light: as it is at 0.32 m, and fading with the square of the distance."""

EDGE = 0.003
"""Rounding of edges, m."""

BOX = mujoco.mjtGeom.mjGEOM_BOX
CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE


def yaw_quat(yaw: float) -> np.ndarray:
    """Return the (4,) quaternion of a turn about z, rad."""
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])


def table_for(stations: Sequence[Station]) -> Table:
    """Return a table that holds the robot's foot and every station, the same to the left as to the right."""
    lamps = [s.lamp + d * LAMP_HALF for s in stations if s.lamp is not None for d in (-1, 1)]
    points = [*(corner for s in stations for corner in s.outline.corners), *lamps]
    side = max([TABLE_LEAST, *(abs(float(y)) + TABLE_MARGIN for _, y in points)])
    back = min([-FOOT, *(float(x) - TABLE_MARGIN for x, _ in points)])
    front = max([FOOT, *(float(x) + TABLE_MARGIN for x, _ in points)])
    return Table((back, front), (-side, side))


def add_table(spec: mujoco.MjSpec, table: Table, stations: Sequence[Station]) -> None:
    """Add the table with its printed top."""
    markings = [_marking(station, [other for other in stations if other is not station]) for station in stations]
    image = picture(table, markings).transpose(1, 0, 2)
    texture = spec.add_texture(name="tabletop", type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width = image.shape[:2]
    texture.data = image.tobytes()
    material = spec.add_material(name="tabletop", specular=0.25, shininess=0.35)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tabletop"
    body = spec.worldbody.add_body(name="table", pos=[*table.centre, 0.0])
    size = np.array([*table.half, TABLE_THICKNESS / 2])
    body.add_geom(name="table", type=BOX, size=size, pos=[0, 0, -size[2]], group=HIDDEN)
    board = plate(size, corner=0.006, bevel=EDGE)
    _draw(spec, body, "table_board", board, "tabletop", z=-size[2])
    # Columns of the image run along x, rows along y; a side takes the colour of the rim above it.
    mesh = spec.mesh("table_board")
    mesh.usertexcoord = (0.5 + 0.5 * board.vertices[:, :2] / table.half).ravel()
    mesh.userfacetexcoord = board.faces.ravel()
    base = np.array([*table.half - PLINTH_INSET, PLINTH_HEIGHT / 2])
    body.add_geom(type=BOX, size=base, pos=[0, 0, -TABLE_THICKNESS - base[2]], material="plinth")


def add_station(spec: mujoco.MjSpec, station: Station) -> None:
    """Add what stands at a location, and its lamp: bodies `<location>_base` and `<location>_lamp`."""
    outline = station.outline
    body = spec.worldbody.add_body(name=f"{station.name}_base", pos=[*outline.centre, 0.0], quat=yaw_quat(outline.yaw))
    if station.lamp is not None or station.kind == "stove":
        rgba = glow_of(station.kind).off
        spec.add_material(name=f"{station.name}_glow", rgba=rgba, specular=0.4, shininess=0.6)
    if station.lamp is not None:
        _add_lamp(spec, station)
    add = {"bin": _add_bin, "pad": _add_pad, "stove": _add_stove, "plate": _add_plate}.get(station.kind)
    if add is not None:
        add(spec, body, station)


def add_object(
    spec: mujoco.MjSpec, name: str, shape: ObjectShape, position: np.ndarray, yaw: float, rgba: Rgba
) -> None:
    """Add an object: a free body, its joint and its colliding geom all bear its name."""
    body = spec.worldbody.add_body(name=name, pos=position, quat=yaw_quat(yaw))
    body.add_freejoint(name=name)
    geom = body.add_geom(name=name, mass=shape.mass, group=HIDDEN)
    geom.friction, geom.condim = [0.8, 0.01, 0.0005], 4
    spec.add_material(name=name, rgba=rgba, specular=0.35, shininess=0.45)
    if shape.kind == "cylinder":
        # Rolling friction stops a cylinder that has fallen over.
        geom.type, geom.size, geom.condim = CYLINDER, [shape.half[0], shape.half[2], 0.0], 6
        _draw(spec, body, f"{name}_body", rounded_cylinder(shape.half[0], shape.half[2], EDGE), name)
    else:
        geom.type, geom.size = BOX, shape.half
        _draw(spec, body, f"{name}_body", rounded_box(shape.half, EDGE), name)


def _marking(station: Station, others: Sequence[Station]) -> Marking:
    """Return a station's outline and name: in front of it if that is free, else to its right, left or behind."""
    corners = station.outline.corners
    low, high, middle = corners.min(axis=0), corners.max(axis=0), station.outline.centre
    width, height = text_size(station.name)
    away = np.array([height, width]) / 2 + NAME_GAP
    sides = [
        np.array([high[0] + away[0], middle[1]]),
        np.array([middle[0], low[1] - away[1]]),
        np.array([middle[0], high[1] + away[1]]),
        np.array([low[0] - away[0], middle[1]]),
    ]
    # Deeper than the text: what stands right behind it would be hidden, what stands beside it is not.
    half = np.array([height / 2 + NAME_GAP, width / 2])
    free = (side for side in sides if not any(overlap(Rectangle(side, half, 0.0), o.outline) for o in others))
    outlines = (station.outline.grown(0.004).corners,) if station.kind == "spot" else ()
    return Marking(station.name, next(free, sides[0]), outlines)


def _add_bin(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    half = station.outline.half
    floor = np.array([*half + BIN_WALL / 2, FLOOR["bin"] / 2])
    body.add_geom(type=BOX, size=floor, pos=[0, 0, floor[2]], material="bin_floor")
    for axis in (0, 1):
        for side in (-1, 1):
            size = np.array([*half + BIN_WALL, BIN_HEIGHT / 2])
            position = np.array([0.0, 0.0, BIN_HEIGHT / 2])
            size[axis], position[axis] = BIN_WALL / 2, side * (half[axis] + BIN_WALL / 2)
            body.add_geom(type=BOX, size=size, pos=position, group=HIDDEN)
    walls = tray(np.array([*half, BIN_HEIGHT]), wall=BIN_WALL, corner=0.008)
    _draw(spec, body, f"{station.name}_walls", walls, "bin")


def _add_pad(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add a plate, with a band along its edge that glows if it has a lamp."""
    size = np.array([*station.outline.half, FLOOR["pad"] / 2])
    body.add_geom(type=BOX, size=size, pos=[0, 0, size[2]], group=HIDDEN)
    top = plate(size, corner=0.014, bevel=0.001)
    _draw(spec, body, f"{station.name}_plate", top, "pad", z=size[2])
    if station.lamp is not None:
        band = tray(np.array([*size[:2] - 0.014, 0.0014]), wall=0.006, corner=0.006)
        _draw(spec, body, f"{station.name}_band", band, f"{station.name}_glow", z=FLOOR["pad"] - 0.0009)


def _add_stove(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add a hob: a sheet of dark glass in a steel frame, and rings on it that glow at work."""
    size = np.array([*station.outline.half, FLOOR["stove"] / 2])
    body.add_geom(type=BOX, size=size, pos=[0, 0, size[2]], group=HIDDEN)
    frame = np.array([*size[:2], size[2] - 0.0005])
    _draw(spec, body, f"{station.name}_frame", plate(frame, corner=0.012, bevel=0.0015), "steel", z=frame[2])
    glass = np.array([*size[:2] - 0.004, 0.001])
    _draw(spec, body, f"{station.name}_glass", plate(glass, corner=0.009, bevel=0.0005), "glass", z=2 * size[2] - 0.001)
    glow = f"{station.name}_glow"
    for slot in station.slots:
        middle = station.outline.axes @ (slot.position[:2] - station.outline.centre)
        for k, radius in enumerate(np.arange(float(size[0]) - 0.010, 0.012, -0.010)):
            ring = tray(np.array([radius, radius, 0.0012]), wall=0.0055, corner=radius)
            _draw(spec, body, f"{station.name}_ring{slot.index}_{k}", ring, glow, xy=middle, z=FLOOR["stove"] - 0.0008)
    height = 0.22
    light = body.add_light(name=glow, pos=[0, 0, height], dir=[0, 0, -1], castshadow=False, active=False)
    light.type = mujoco.mjtLightType.mjLIGHT_SPOT
    light.specular, light.cutoff, light.exponent = [0.1] * 3, 40, 12


def _add_plate(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add a dish: round, or drawn out under a row of objects."""
    radius, length = station.outline.half
    height = FLOOR["plate"] / 2
    for end in {-1.0, 1.0} if length > radius else {0.0}:
        end_at = [0, end * (length - radius), height]
        body.add_geom(type=CYLINDER, size=[radius, height, 0], pos=end_at, group=HIDDEN)
    if length > radius:
        body.add_geom(type=BOX, size=[radius, length - radius, height], pos=[0, 0, height], group=HIDDEN)
    solid = dish(station.outline.half, floor=FLOOR["plate"], rim=FLOOR["plate"] + 0.0025)
    _draw(spec, body, f"{station.name}_dish", solid, "porcelain")


def _add_lamp(spec: mujoco.MjSpec, station: Station) -> None:
    """Add a post whose head faces the station; all that glows shares the material `<location>_glow`."""
    assert station.lamp is not None
    towards = station.outline.centre - station.lamp
    glow = f"{station.name}_glow"
    yaw = float(np.arctan2(towards[1], towards[0]))
    body = spec.worldbody.add_body(name=f"{station.name}_lamp", pos=[*station.lamp, 0.0], quat=yaw_quat(yaw))
    body.add_geom(type=CYLINDER, size=[LAMP_HALF, 0.005, 0], pos=[0, 0, 0.005], material="lamp")
    body.add_geom(type=CAPSULE, size=[0.006, LAMP_HEIGHT / 2, 0], pos=[0, 0, LAMP_HEIGHT / 2], material="lamp")
    tilt = np.pi / 2 + np.arctan2(LAMP_HEIGHT, np.hypot(*towards))
    head = body.add_body(
        name=f"{station.name}_lamp_head", pos=[0, 0, LAMP_HEIGHT], quat=[np.cos(tilt / 2), 0, np.sin(tilt / 2), 0]
    )
    size = np.array([0.026, 0.080, 0.010])
    head.add_geom(type=BOX, size=size, group=HIDDEN)
    _draw(spec, head, f"{station.name}_head", plate(size, corner=0.018, bevel=0.003), "lamp")
    for x in (-0.010, 0.010):
        tube = head.add_geom(type=CAPSULE, size=[0.0055, 0.058, 0], pos=[x, 0, size[2]], material=glow)
        tube.quat = [np.sqrt(0.5), np.sqrt(0.5), 0, 0]
        tube.contype = tube.conaffinity = 0
    light = head.add_light(name=glow, pos=[0, 0, 0.015], dir=[0, 0, 1], castshadow=False, active=False)
    light.type = mujoco.mjtLightType.mjLIGHT_SPOT
    light.diffuse, light.specular = LAMP_GLOW.light, [0.1] * 3
    light.cutoff, light.exponent, light.attenuation = 45, 6, LAMP_FADING


def _draw(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    name: str,
    solid: Solid,
    material: str,
    *,
    xy: np.ndarray | tuple[float, float] = (0.0, 0.0),
    z: float = 0.0,
) -> None:
    """Draw a solid that collides with nothing and weighs nothing."""
    add_solid(spec, name, solid)
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=material, pos=[*xy, z])
    geom.contype = geom.conaffinity = geom.mass = 0
    geom.group = VISIBLE
