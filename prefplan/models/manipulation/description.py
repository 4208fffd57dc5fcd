"""The parts of a manipulation model, locations and objects, and whether they fit together."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from prefplan.errors import ModelError, check_known
from prefplan.models.manipulation.surroundings import check_point, with_height
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import check_names

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel

MOST_OBJECTS = 10**9
"""Greatest capacity of a location."""


@dataclass(frozen=True)
class Location:
    """A place where objects rest.

    Attributes:
        name: its name.
        at: (x, y) or (x, y, height) of the surface that supports it, m; the default height is that of the table top, 0.
            None if it is on other locations, or at a `site`.
        site: name of the site in the user's MJCF scene where it is.
        on: locations that must all hold an object before one can be put here.
        capacity: number of objects that it holds.
        marks: mark that an object gets when it is released here: from then on `<object>_<marks>` holds.
        kind: its appearance in simulation; None for a plain spot.
        closed: whether nothing can be put here, such as where an object was left by accident.
        clear_of: locations that must be empty before an object is put here or, if this is closed, grasped here.
        label: name to display; None for `name`.
    """

    name: str = field(metadata={"key": None})
    at: Annotated[
        tuple[float, ...] | None, Form("[x, y] or [x, y, height] in metres", "(x, y) or (x, y, height) in metres")
    ] = None
    site: str | None = None
    on: Annotated[tuple[str, ...], Form('a list of locations, such as ["left", "right"]')] = ()
    capacity: int = 1
    marks: str | None = None
    kind: str | None = None
    closed: bool = field(default=False, metadata={"key": None})
    clear_of: tuple[str, ...] = field(default=(), metadata={"key": None})
    label: str | None = None

    @property
    def height(self) -> float:
        """Height of the surface that supports it above the table top, m; 0 if it is on other locations."""
        return with_height(self.at)[2] if self.at else 0.0


@dataclass(frozen=True)
class Object:
    """An object that the arm may move.

    Attributes:
        name: its name.
        start: name of its initial location.
        fixed: whether it is never grasped.
        rgba: colour in simulation, each in 0 .. 1; None for a default.
        kind: its shape in simulation, such as `cube`.
        size: its lengths, m; its kind determines which; None for a cube of the default size, and for a mesh.
        file: path of a mesh, relative to the scenario file.
        scale: length of a unit of `file`, m.
        body: name of its body in the user's MJCF scene.
        mass: its mass, kg; None for that of wood, limited to what the hand can carry.
        label: name to display; None for `name`.
    """

    name: str = field(metadata={"key": None})
    start: str
    fixed: bool = False
    rgba: tuple[float, float, float, float] | None = None
    kind: str = "cube"
    size: Annotated[
        tuple[float, ...] | None,
        Form("a length in metres, or a list of lengths", "a tuple of lengths in metres, such as (0.05,)"),
    ] = None
    file: str | None = None
    scale: float = 1.0
    body: str | None = None
    mass: float | None = None
    label: str | None = None


def check_locations(locations: tuple[Location, ...]) -> None:
    """Raise ModelError for an invalid location, or one that would rest on itself."""
    if not locations:
        raise ModelError("locations: at least one is needed")
    names = [place.name for place in locations]
    check_names(names, where="locations")
    for place in locations:
        where = f"locations.{place.name}"
        check_fields(place, ModelError, f"{where}.")
        if names.count(place.name) > 1:
            raise ModelError(f"{where}: defined twice")
        if place.site is not None:
            if place.at is not None or place.on:
                raise ModelError(f"{where}: needs only one of 'at', 'on' and 'site'")
        elif (place.at is None) == (not place.on):
            raise ModelError(f"{where}: needs exactly one of 'at' (a point on the table) and 'on' (its supports)")
        if repeated := [name for name, times in Counter(place.on).items() if times > 1]:
            raise ModelError(f"{where}.on: {repeated[0]!r} is listed twice")
        for support in place.on:
            check_known(f"{where}.on", "location", support, [name for name in names if name != place.name])
        for other in place.clear_of:
            check_known(f"{where}.clear_of", "location", other, names)
        if place.capacity < 1:
            raise ModelError(f"{where}.capacity: must be at least 1, not {place.capacity}")
        if place.capacity > MOST_OBJECTS:
            raise ModelError(f"{where}.capacity: must be at most {MOST_OBJECTS}")
        if place.marks is not None:
            check_names([place.marks], where=f"{where}.marks")
        if place.at is not None:
            check_point(place.at, f"{where}.at")
        if place.height < 0:
            raise ModelError(f"{where}.at: {-place.height:g} m below the table top; the height is at least 0")
    try:
        TopologicalSorter({place.name: place.on for place in locations}).prepare()
    except CycleError as error:
        name = next(name for name in names if name in error.args[1])
        raise ModelError(f"locations.{name}.on: it would rest on itself") from None


def check_objects(model: ManipulationModel) -> None:
    """Raise ModelError for an object without a valid start, or more of them at a location than it holds."""
    names = [obj.name for obj in model.objects]
    check_names(names, where="objects")
    resting: dict[str, list[str]] = {place.name: [] for place in model.locations}
    for obj in model.objects:
        where = f"objects.{obj.name}"
        check_fields(obj, ModelError, f"{where}.")
        if names.count(obj.name) > 1:
            raise ModelError(f"{where}: defined twice")
        check_known(f"{where}.start", "location", obj.start, resting)
        resting[obj.start].append(obj.name)
        capacity = model.location(obj.start).capacity
        if model.begin is None and len(resting[obj.start]) > capacity:
            there = " and ".join(resting[obj.start])
            raise ModelError(f"{where}.start: {there} start at {obj.start!r}, which has room for {capacity}")
    for obj in model.objects if model.begin is None else ():
        for support in model.location(obj.start).on:
            if not resting[support]:
                raise ModelError(
                    f"objects.{obj.name}.start: {obj.start!r} rests on {support!r}, where no object starts"
                )


def check_scene(model: ManipulationModel) -> None:
    """Raise ModelError for paths that are not relative, and references to the user's MJCF scene if there is none."""
    files = [("scene", model.scene), ("robot.mjcf", model.robot_setup.mjcf)]
    files += [(f"objects.{obj.name}.file", obj.file) for obj in model.objects]
    for where, path in files:
        # Logs store files by their paths relative to the scenario's folder.
        if path is not None and Path(path).is_absolute():
            raise ModelError(f"{where}: must be a path from the folder of the scenario file, not {path!r}")
    references = [(f"locations.{place.name}.site", place.site) for place in model.locations]
    references += [(f"objects.{obj.name}.body", obj.body) for obj in model.objects]
    for where, name in references if model.scene is None else ():
        if name is not None:
            raise ModelError(f"{where}: only with `scene`, a MJCF file beside the scenario")


def check_propositions(model: ManipulationModel) -> None:
    """Raise ModelError for two propositions of one name."""
    check_names(model.propositions, where="propositions")
    origin: dict[str, str] = {}
    for obj in model.objects:
        for name, meaning in model.propositions_of(obj.name):
            if name in origin:
                raise ModelError(
                    f"objects.{obj.name}: proposition {name!r} would mean both {origin[name]} and {meaning}"
                )
            origin[name] = meaning
