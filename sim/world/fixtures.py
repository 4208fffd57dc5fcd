"""Fixtures: checks of their keys in the scenario, and the blocks that they are made of."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np

from prefplan.errors import check_known, prefixed
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.surroundings import Fixture, check_point
from prefplan.text.names import check_names
from sim.errors import SimulationError
from sim.geometry.mjcf import HIDDEN, draw_solid, yaw_quat
from sim.geometry.rectangle import Rectangle, overlap
from sim.geometry.solids import rounded
from sim.world.shapes import LARGEST_M, about_z

KINDS = ("box", "shelf")
"""Kinds of fixtures: a solid box, and boards between two sides and a back."""

PANEL_M = 0.012
"""Thickness of a shelf's boards, sides and back, m."""

MAX_CONTACT_M = 1e-6
"""Greatest overlap of two bodies that counts as mere contact, m."""


@dataclass(frozen=True, eq=False)
class Block:
    """A part of a fixture, or the space that a location needs.

    Attributes:
        name: of the fixture or location.
        outline: what it covers, seen from above.
        low: height of its underside over the table top, m.
        high: height of its upper side, m.
        carries: whether a location may lie on it: on a box, or on a shelf's board between the walls.
    """

    name: str
    outline: Rectangle
    low: float
    high: float
    carries: bool = False

    def meets(self, outline: Rectangle, low: float, high: float) -> bool:
        """Return whether the block reaches into the space over an outline between two heights, m."""
        return self.low < high - MAX_CONTACT_M and low + MAX_CONTACT_M < self.high and overlap(self.outline, outline)


def check_fixtures(model: ManipulationModel) -> None:
    """Raise `SimulationError`, which begins with the key, for invalid fixtures, or those whose names are taken."""
    with prefixed("", new=SimulationError):
        check_names([fixture.name for fixture in model.fixtures], where="fixtures")
    taken = {*(place.name for place in model.locations), *(obj.name for obj in model.objects)}
    for fixture in model.fixtures:
        where = f"fixtures.{fixture.name}"
        if fixture.name in taken:
            raise SimulationError(f"{where}: an object or a location has this name")
        check_known(f"{where}.kind", "kind", fixture.kind, KINDS, SimulationError)
        with prefixed("", new=SimulationError):
            check_point(fixture.at, f"{where}.at")
        if not all(math.isfinite(length) and length > 0 for length in fixture.size):
            raise SimulationError(f"{where}.size: must be positive lengths, not {list(fixture.size)}")
        for key in ("at", "size"):
            lengths = getattr(fixture, key)
            if max(map(abs, lengths)) > LARGEST_M:
                raise SimulationError(f"{where}.{key}: must be metres, at most {LARGEST_M}, not {list(lengths)}")
        if not math.isfinite(fixture.yaw):
            raise SimulationError(f"{where}.yaw: must be a finite number of degrees, not {fixture.yaw}")
        if fixture.rgba is not None and not all(0 <= part <= 1 for part in fixture.rgba):
            raise SimulationError(f"{where}.rgba: each part must lie between 0 and 1, not {list(fixture.rgba)}")
        _check_boards(fixture, f"{where}.boards")
        _check_foot(fixture, f"{where}.at")


def _check_boards(fixture: Fixture, where: str) -> None:
    if fixture.kind != "shelf":
        if fixture.boards:
            raise SimulationError(f"{where}: only a shelf has boards")
        return
    if not fixture.boards:
        raise SimulationError(f"{where}: missing; a shelf has one at least, as in boards = [0.0, 0.25]")
    height = fixture.size[2]
    for board in fixture.boards:
        if not 0 <= board <= height:
            raise SimulationError(f"{where}: {board:g} is not from 0 to {height:g} m, the height of the shelf")
    if min(_between(fixture).half) <= 0:
        raise SimulationError(
            f"fixtures.{fixture.name}.size: its sides and its back are {PANEL_M:g} m thick, so it must be longer "
            f"than {PANEL_M:g} m along x and {2 * PANEL_M:g} m along y, not {list(fixture.size)}"
        )


def _check_foot(fixture: Fixture, where: str) -> None:
    """Raise `SimulationError` if a fixture reaches into the table."""
    half = fixture.size[2] / 2 if fixture.kind == "box" else 0.0
    if fixture.at[2] < half - 1e-6:
        middle = "`at` is its centre, so its height is" if half else "`at` is the middle of its foot, so its height is"
        depth = half - fixture.at[2]
        raise SimulationError(f"{where}: it reaches {depth:.3f} m into the table; {middle} at least {half:g}")


def blocks_of(fixtures: Iterable[Fixture]) -> list[Block]:
    """Return the blocks that fixtures are made of."""
    found = []
    for fixture in fixtures:
        z = fixture.at[2]
        dx, dy, dz = fixture.size
        if fixture.kind == "box":
            found.append(Block(fixture.name, _outline(fixture, 0.0, 0.0, dx, dy), z - dz / 2, z + dz / 2, carries=True))
            continue
        back = _outline(fixture, (PANEL_M - dx) / 2, 0.0, PANEL_M, dy)
        sides = [
            _outline(fixture, PANEL_M / 2, side * (dy - PANEL_M) / 2, dx - PANEL_M, PANEL_M) for side in (-1.0, 1.0)
        ]
        found += [Block(fixture.name, outline, z, z + dz) for outline in (back, *sides)]
        # A board in or below the table top is left out: the table carries objects there.
        tops = [z + board for board in fixture.boards if z + board > 0]
        found += [Block(fixture.name, _between(fixture), max(0.0, top - PANEL_M), top, carries=True) for top in tops]
    return found


def add_fixture(spec: mujoco.MjSpec, fixture: Fixture) -> None:
    """Add a fixture: a body named by `body_name`."""
    name = body_name(fixture.name)
    body = spec.worldbody.add_body(name=name)
    material = f"{name}_finish"
    rgba = fixture.rgba or ((0.62, 0.64, 0.66, 1.0) if fixture.kind == "box" else (0.80, 0.69, 0.52, 1.0))
    spec.add_material(name=material, rgba=rgba, specular=0.25, shininess=0.35)
    for i, block in enumerate(blocks_of([fixture])):
        half = np.array([*block.outline.half, (block.high - block.low) / 2])
        middle = np.array([*block.outline.centre, (block.high + block.low) / 2])
        turn = yaw_quat(block.outline.yaw)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=middle, quat=turn, group=HIDDEN)
        edge = min(0.0015, float(half.min()) / 2)
        solid = rounded(half, corner=edge, edge=edge)
        draw_solid(spec, body, f"{name}_{i}", solid, material, pos=middle, quat=turn)


def body_name(fixture: str) -> str:
    """Return the name of a fixture's body; no object's name contains a space."""
    return f"fixture {fixture}"


def _outline(fixture: Fixture, x: float, y: float, dx: float, dy: float) -> Rectangle:
    """Return the outline of a part whose middle is at (x, y) in a fixture's frame, m."""
    yaw = float(np.radians(fixture.yaw))
    middle = np.array(fixture.at) + about_z(yaw) @ [x, y, 0.0]
    return Rectangle(middle[:2], np.array([dx, dy]) / 2, yaw)


def _between(fixture: Fixture) -> Rectangle:
    """Return the outline of the space inside the walls of a shelf."""
    dx, dy, _ = fixture.size
    return _outline(fixture, PANEL_M / 2, 0.0, dx - PANEL_M, dy - 2 * PANEL_M)
