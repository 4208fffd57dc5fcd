"""A kind of model of one's own, from outside: a lift between floors, whose cost is the square of the distance."""

from __future__ import annotations

from dataclasses import dataclass

import prefplan as pp


@dataclass(frozen=True)
class Lift:
    """Floors 0 .. n-1; `carries` says which guest gets in where."""

    floors: int
    guests: dict[str, int]

    def transition_system(self) -> pp.TransitionSystem:
        """Return the floors as states; a ride of k floors costs k * k."""
        rides = [
            (here, f"to {there}", there, (here - there) ** 2)
            for here in range(self.floors)
            for there in range(self.floors)
            if here != there
        ]
        labels = {
            floor: [name for name, where in self.guests.items() if where == floor] for floor in range(self.floors)
        }
        return pp.TransitionSystem.from_transitions(rides, start=0, labels=labels)


def test_a_model_from_outside_is_planned_on() -> None:
    model = Lift(5, {"ann": 4, "bob": 1})
    tasks = [pp.Task("fetch_ann", "F ann"), pp.Task("fetch_bob", "F bob")]
    front = pp.pareto_front(pp.Problem(model, tasks, pp.Order()))
    assert [(plan.cost, plan.preference) for plan in front] == [(4, 3), (9, 0)]
    assert front[0].actions == ("to 1", "to 2", "to 3", "to 4")
