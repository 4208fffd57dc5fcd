"""What the arm can do with one object at one location."""

from dataclasses import dataclass

from prefplan.models.manipulation.symbolic import at
from prefplan.models.system import Barred

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
        put_unless: the same, while they stand there it cannot be put down.
        crowded_by: the same: while any of them stands there, there is no room to put it down.
        not_from: a location from which it cannot be brought there directly; empty if none is known.
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
        """Why something cannot be done there; beside which objects there is no room, if that is all."""
        return self.reason or f"no room beside {' or '.join(f'{obj} at {place}' for obj, place in self.crowded_by)}"

    @property
    def barred(self) -> Barred:
        """The actions that the arm cannot do, as `System.without` takes them: the grasp there, the release there."""
        here = frozenset({at(self.obj, self.location)})
        entries = (
            (self.take, self.take_unless, here, f"grasp {self.obj}"),
            (self.put, self.put_unless, frozenset[str](), f"release {self.obj} {self.location}"),
        )
        found = [
            (conditions | ({at(*one) for one in unless} if possible else set()), action)
            for possible, unless, conditions, action in entries
            if unless or not possible
        ]
        return found + [(frozenset({at(*one)}), f"release {self.obj} {self.location}") for one in self.crowded_by]
