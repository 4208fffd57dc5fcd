"""What the arm can do with one object at one location."""

from __future__ import annotations

from dataclasses import dataclass, replace

from prefplan.models.manipulation.symbolic import Barred, at, grasped_at

Neighbours = tuple[tuple[str, str], ...]
"""Objects, each with its location."""


@dataclass(frozen=True)
class PlaceCheck:
    """Whether an object can be grasped and put down at a location.

    Attributes:
        obj: name of the object.
        location: name of the location.
        reason: why it cannot be grasped or put down there, or not be brought there from its start; None if it can.
        take: whether it can be grasped there, perhaps after other objects were moved away.
        put: whether it can be put down there, likewise.
        take_unless: other objects with their locations: while all of them stand there, it cannot be grasped.
        put_unless: the same for putting it down.
        crowded_by: other objects with their locations: while any of them stands there, it cannot be put down beside it.
        not_from: a location from which it cannot be brought there directly, or not while all of `put_unless` stand
            there; empty if none is known.
    """

    obj: str
    location: str
    reason: str | None = None
    take: bool = True
    put: bool = True
    take_unless: Neighbours = ()
    put_unless: Neighbours = ()
    crowded_by: Neighbours = ()
    not_from: str = ""

    @property
    def words(self) -> str:
        """The reason; if there is none, beside which objects there is no room."""
        return self.reason or f"no room beside {' or '.join(f'{obj} at {place}' for obj, place in self.crowded_by)}"

    def among(self, others: Neighbours, *, grasped: bool) -> PlaceCheck | None:
        """Return what prevents putting the object down among others, or, if it is not `grasped` yet, grasping it.

        None if nothing does.
        """
        there = {*others}
        if not grasped:
            hindered = not self.take or (self.take_unless and there.issuperset(self.take_unless))
            return replace(self, put=True, put_unless=(), crowded_by=(), not_from="") if hindered else None
        if not self.put or (self.put_unless and there.issuperset(self.put_unless)):
            return replace(self, take=True, take_unless=(), crowded_by=(), not_from="")
        crowded_by = tuple(one for one in self.crowded_by if one in there)
        return PlaceCheck(self.obj, self.location, crowded_by=crowded_by) if crowded_by else None

    @property
    def barred(self) -> Barred:
        """What the arm cannot do, as `ManipulationSystem.without` takes it: the grasp there, the release there."""
        grasp, release = f"grasp {self.obj}", f"release {self.obj} {self.location}"
        here = frozenset({at(self.obj, self.location)})
        held = frozenset({grasped_at(self.obj, self.not_from)} if self.not_from else ())
        entries = ((self.take, self.take_unless, here, grasp), (self.put, self.put_unless, held, release))
        found = [
            (conditions | ({at(*one) for one in unless} if possible else set()), action)
            for possible, unless, conditions, action in entries
            if unless or not possible or (action == release and held)
        ]
        return found + [(frozenset({at(*one)}), f"release {self.obj} {self.location}") for one in self.crowded_by]
