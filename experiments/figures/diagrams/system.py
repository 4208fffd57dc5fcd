"""A transition system as a picture: a box for each state with its propositions, an arrow for each action."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from experiments.figures.diagrams.node_link import Diagram, Edge, Node
from prefplan.errors import PrefplanError
from prefplan.models.system import System
from prefplan.models.transition_system import TransitionSystem
from prefplan.text.layout import number

MOST_STATES = 40
"""Greatest number of states of a transition system that is drawn: larger ones are illegible."""

MOST_NAMES = 3
"""Greatest number of propositions shown in a state."""


class SystemSizeError(PrefplanError):
    """A transition system has more states than a picture can show."""


def diagram(system: System) -> Diagram:
    """Return a transition system as a diagram, without unreachable states; the start is node `s0`.

    Raises:
        SystemSizeError: it has too many states.
    """
    order = reachable(system)
    if order is None:
        size = system.size if isinstance(system, TransitionSystem) else "very many"
        raise SystemSizeError(
            f"the transition system has {size} states, and only one of up to {MOST_STATES} can be drawn "
            "so that it can be read"
        )
    system, number_of = system.listed, {state: i for i, state in enumerate(order)}
    nodes = [Node(f"s{i}", text_of(system, state)) for i, state in enumerate(order)]
    edges = []
    for state in order:
        actions: dict[int, list[str]] = defaultdict(list)
        for edge in system.edges(state):
            action = system.action_names[system.actions[edge]]
            cost = number(system.cost(edge))
            actions[int(system.targets[edge])].append(f"{action} {cost}")
        edges += [Edge(number_of[state], number_of[target], " | ".join(names)) for target, names in actions.items()]
    return Diagram(nodes, edges)


def reachable(system: System) -> list[int] | None:
    """Return the states that can be reached, the start first; None if they are too many to be drawn."""
    if not isinstance(system, TransitionSystem):
        return None
    order = [system.start]
    for state in order:
        targets = dict.fromkeys(int(system.targets[edge]) for edge in system.edges(state))
        order += [target for target in targets if target not in order]
        if len(order) > MOST_STATES:
            return None
    return order


def text_of(system: System, state: Any) -> tuple[str, ...]:
    """Return the lines of text in a state: its name and its propositions."""
    name = system.decode(state)
    label = sorted(system.label(state))
    shown = [*label[:MOST_NAMES], *(["..."] if len(label) > MOST_NAMES else [])]
    text = f"({', '.join(map(str, name))})" if isinstance(name, tuple) else str(name)
    return (text, "{" + ", ".join(shown) + "}") if shown else (text,)
