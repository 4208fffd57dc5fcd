"""Table, pedestal, bins, pads, stoves and plates as MuJoCo bodies."""

from collections.abc import Sequence

import mujoco
import numpy as np

from sim.geometry.mjcf import HIDDEN, draw_solid, yaw_quat
from sim.geometry.rectangle import Rectangle, overlap
from sim.geometry.solids import dish, rounded, tray
from sim.robots.robot import Robot
from sim.world.fixtures import Block
from sim.world.materials import glow_of
from sim.world.places import FLOOR, Station
from sim.world.tabletop import TABLE_TOP, picture, text_size

TABLE_THICKNESS_M = 0.045
"""Thickness of the table's board, m."""

PLINTH_HEIGHT_M = 1.0
"""Height of the block that carries the board, m: it extends below the picture, which saves rendering a floor (a quarter
of the time)."""

PLINTH_INSET_M = 0.05
"""Distance from the edge of the board to this block, m."""

TABLE_MARGIN_M = 0.10
"""Least distance from what stands on the table to its edge, m."""

MIN_TABLE_SIDE_M = 0.35
"""Least half width of the table, m."""

FOOT_M = 0.22
"""Half side of the square of table top under a robot's foot, m; the Panda's foot reaches 0.155 m back."""

PEDESTAL = "robot pedestal"
"""Name of the body that carries a base above the table; no object's name contains a space."""

PEDESTAL_HALF_M = 0.14
"""Half width of the pedestal, m."""

BIN_WALL_M = 0.004
"""Thickness of a bin's walls, m."""

BIN_CORNER_M = 0.008
"""Radius of a bin's corners, m."""

BIN_HEIGHT_M = 0.036
"""Height of a bin's walls, m: below the palm, which is 6 cm above the table when the Panda holds a block's middle."""

NAME_GAP_M = 0.012
"""Distance from a location to its name on the table, m: a bin's wall fits between them."""

SPOT_MARGIN_M = 0.004
"""Distance from a spot to the line round it, m."""

SPOT_LINE_M = 0.0016
"""Width of the line round a spot, m."""

GLOW_INSET_M = 0.020
"""Distance from the edge of a pad or a bin to the inner side of the band that glows on it, m."""

EDGE_M = 0.003
"""Radius of rounded edges, m."""

BOX = mujoco.mjtGeom.mjGEOM_BOX
CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER


def table_for(stations: Sequence[Station], fixtures: Sequence[Block], robot: Robot) -> Rectangle:
    """Return a table that holds stations and fixtures, and the robot's foot unless that is on the floor.

    It is symmetric about a robot that faces +x.
    """
    outlines = [*(station.outline for station in stations), *(block.outline for block in fixtures)]
    points = np.array([outline.corners for outline in outlines]).reshape(-1, 2)
    foot = robot.position[:2]
    low = points.min(axis=0, initial=np.inf) - TABLE_MARGIN_M
    high = points.max(axis=0, initial=-np.inf) + TABLE_MARGIN_M
    if robot.floor_front_m is None:
        low, high = np.minimum(foot - FOOT_M, low), np.maximum(foot + FOOT_M, high)
    if not robot.yaw:
        side = max(MIN_TABLE_SIDE_M, float(foot[1] - low[1]), float(high[1] - foot[1]))
        low[1], high[1] = foot[1] - side, foot[1] + side
    return Rectangle((low + high) / 2, (high - low) / 2, 0.0)


def _plinth_for(table: Rectangle, robot: Robot) -> Rectangle:
    """Return the block that carries a table; the table overhangs the base of a robot on the floor."""
    low, high = table.centre - table.half + PLINTH_INSET_M, table.centre + table.half - PLINTH_INSET_M
    if robot.floor_front_m is not None:
        heading = np.array([np.cos(robot.yaw), np.sin(robot.yaw)])
        along = int(np.abs(heading).argmax())
        edge = robot.position[along] + np.sign(heading[along]) * robot.floor_front_m
        nearer = low if heading[along] > 0 else high
        nearer[along] = np.clip(edge, low[along], high[along])
    return Rectangle((low + high) / 2, (high - low) / 2, 0.0)


def add_pedestal(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Add a pedestal if the robot's base is above the table."""
    height = float(robot.position[2])
    if height and robot.floor_front_m is None:
        half = np.array([PEDESTAL_HALF_M, PEDESTAL_HALF_M, height / 2])
        body = spec.worldbody.add_body(name=PEDESTAL, pos=[*robot.position[:2], height / 2], quat=yaw_quat(robot.yaw))
        body.add_geom(name=PEDESTAL, type=BOX, size=half, group=HIDDEN)
        draw_solid(spec, body, f"{PEDESTAL}_block", rounded(half, corner=0.02, edge=EDGE_M), "studio_plinth")


def name_places_of(stations: Sequence[Station], fixtures: Sequence[Block]) -> dict[str, np.ndarray]:
    """Return the (2,) place, m, of the name of each station on the table itself."""
    standing = [block.outline for block in fixtures if not block.low]
    on_table = [station for station in stations if not station.height]
    return {
        station.name: _name_place(station, [other.outline for other in on_table if other is not station] + standing)
        for station in on_table
    }


def add_table(spec: mujoco.MjSpec, table: Rectangle, robot: Robot) -> None:
    """Add the table."""
    image = picture(table, {})
    texture = spec.add_texture(name=TABLE_TOP, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width = image.shape[:2]
    texture.data = image.tobytes()
    material = spec.add_material(name=TABLE_TOP, specular=0.25, shininess=0.35)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = TABLE_TOP
    body = spec.worldbody.add_body(name="table", pos=[*table.centre, 0.0])
    size = np.array([*table.half, TABLE_THICKNESS_M / 2])
    body.add_geom(name="table", type=BOX, size=size, pos=[0, 0, -size[2]], group=HIDDEN)
    board = rounded(size, corner=0.006, edge=EDGE_M)
    draw_solid(spec, body, "table_board", board, TABLE_TOP, pos=[0, 0, -size[2]])
    # A side takes the colour of the rim above it.
    mesh = spec.mesh("table_board")
    mesh.usertexcoord = (0.5 + 0.5 * board.vertices[:, :2] / table.half).ravel()
    mesh.userfacetexcoord = board.faces.ravel()
    plinth = _plinth_for(table, robot)
    base = np.array([*plinth.half, PLINTH_HEIGHT_M / 2])
    at = [*plinth.centre - table.centre, -TABLE_THICKNESS_M - base[2]]
    body.add_geom(type=BOX, size=base, pos=at, material="studio_plinth")


def add_station(spec: mujoco.MjSpec, station: Station) -> None:
    """Add what stands at a location: the body `<location>_base`."""
    outline = station.outline
    place = [*outline.centre, station.height]
    body = spec.worldbody.add_body(name=f"{station.name}_base", pos=place, quat=yaw_quat(outline.yaw))
    if station.marks or station.kind == "stove":
        _add_glow(spec, body, station)
    add = {"spot": _add_spot, "bin": _add_bin, "pad": _add_pad, "stove": _add_stove, "plate": _add_plate}[station.kind]
    add(spec, body, station)


def _name_place(station: Station, others: Sequence[Rectangle]) -> np.ndarray:
    """Return a (2,) position for a station's name, m: beyond it (+x) if there is space, else on another side."""
    corners = station.outline.corners
    low, high, middle = corners.min(axis=0), corners.max(axis=0), station.outline.centre
    width, height = text_size(station.name)
    away = np.array([height, width]) / 2 + NAME_GAP_M
    sides = [
        np.array([high[0] + away[0], middle[1]]),
        np.array([middle[0], low[1] - away[1]]),
        np.array([middle[0], high[1] + away[1]]),
        np.array([low[0] - away[0], middle[1]]),
    ]
    # Deeper than the text: tall letters right in front of an object would hide it.
    half = np.array([height / 2 + NAME_GAP_M, width / 2])
    free = (side for side in sides if not any(overlap(Rectangle(side, half, 0.0), other) for other in others))
    return next(free, sides[0])


def _add_spot(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add the outline of a spot."""
    half = np.array([*station.outline.half + SPOT_MARGIN_M, SPOT_LINE_M / 4])
    line = tray(half, wall=SPOT_LINE_M, corner=0.001)
    draw_solid(spec, body, f"{station.name}_outline", line, "studio_outline")


def _add_bin(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    half = station.outline.half
    floor = np.array([*half + BIN_WALL_M / 2, FLOOR["bin"] / 2])
    body.add_geom(type=BOX, size=floor, pos=[0, 0, floor[2]], group=HIDDEN)
    inside = rounded(floor, corner=BIN_CORNER_M + BIN_WALL_M / 2, edge=FLOOR["bin"] / 4)
    draw_solid(spec, body, f"{station.name}_floor", inside, "studio_bin_floor", pos=[0, 0, floor[2]])
    for axis in (0, 1):
        for side in (-1, 1):
            size = np.array([*half + BIN_WALL_M, BIN_HEIGHT_M / 2])
            position = np.array([0.0, 0.0, BIN_HEIGHT_M / 2])
            size[axis], position[axis] = BIN_WALL_M / 2, side * (half[axis] + BIN_WALL_M / 2)
            body.add_geom(type=BOX, size=size, pos=position, group=HIDDEN)
    walls = tray(np.array([*half, BIN_HEIGHT_M]), wall=BIN_WALL_M, corner=BIN_CORNER_M)
    draw_solid(spec, body, f"{station.name}_walls", walls, "studio_bin")


def _add_pad(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add a sheet of metal."""
    size = np.array([*station.outline.half, FLOOR["pad"] / 2])
    body.add_geom(type=BOX, size=size, pos=[0, 0, size[2]], group=HIDDEN)
    top = rounded(size, corner=0.014, edge=0.001)
    draw_solid(spec, body, f"{station.name}_plate", top, "studio_pad", pos=[0, 0, size[2]])


def _add_stove(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add a hob: a sheet of dark glass in a steel frame, and rings on it that glow while it heats."""
    size = np.array([*station.outline.half, FLOOR["stove"] / 2])
    body.add_geom(type=BOX, size=size, pos=[0, 0, size[2]], group=HIDDEN)
    frame = rounded(size - [0, 0, 0.0005], corner=0.012, edge=0.0015)
    draw_solid(spec, body, f"{station.name}_frame", frame, "studio_steel", pos=[0, 0, size[2] - 0.0005])
    glass = rounded(np.array([*size[:2] - 0.004, 0.001]), corner=0.009, edge=0.0005)
    draw_solid(spec, body, f"{station.name}_glass", glass, "studio_glass", pos=[0, 0, 2 * size[2] - 0.001])
    for slot in station.slots:
        middle = station.outline.local(slot.position[:2])
        for k, radius in enumerate(np.arange(float(size[0]) - 0.010, 0.012, -0.010)):
            ring = tray(np.array([radius, radius, 0.0012]), wall=0.0055, corner=radius)
            name = f"{station.name}_ring{slot.index}_{k}"
            draw_solid(spec, body, name, ring, f"{station.name}_glow", pos=[*middle, FLOOR["stove"] - 0.0008])


def _add_plate(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add a dish: round, or elongated under a row of objects."""
    radius, length = station.outline.half
    height = FLOOR["plate"] / 2
    for end in {-1.0, 1.0} if length > radius else {0.0}:
        end_at = [0, end * (length - radius), height]
        body.add_geom(type=CYLINDER, size=[radius, height, 0], pos=end_at, group=HIDDEN)
    if length > radius:
        body.add_geom(type=BOX, size=[radius, length - radius, height], pos=[0, 0, height], group=HIDDEN)
    solid = dish(station.outline.half, floor=FLOOR["plate"], rim=FLOOR["plate"] + 0.0025)
    draw_solid(spec, body, f"{station.name}_dish", solid, "studio_porcelain")


def _add_glow(spec: mujoco.MjSpec, body: mujoco.MjsBody, station: Station) -> None:
    """Add the glow of a location: its material, a light above it and, unless it is a stove, a glowing band."""
    glow = f"{station.name}_glow"
    spec.add_material(name=glow, rgba=glow_of(station.kind).off, specular=0.4, shininess=0.6)
    light = body.add_light(name=glow, pos=[0, 0, 0.22], dir=[0, 0, -1], castshadow=False, active=False)
    light.type = mujoco.mjtLightType.mjLIGHT_SPOT
    light.specular, light.cutoff, light.exponent = [0.1] * 3, 40, 12
    if station.kind != "stove":
        inset, height = (0.0, 0.0) if station.kind in ("spot", "plate") else (GLOW_INSET_M, FLOOR[station.kind])
        inner = station.outline.half - inset
        corner = float(inner.min()) if station.kind == "plate" else 0.006
        band = tray(np.array([*inner, 0.0014]), wall=0.012, corner=corner)
        draw_solid(spec, body, f"{station.name}_band", band, glow, pos=[0, 0, height - 0.0009])
