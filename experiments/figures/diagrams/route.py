"""A plan on the graph of its model: the edges that it takes, numbered in order."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from experiments.figures.diagrams import node_link
from experiments.figures.diagrams.node_link import Diagram, Edge, Node
from experiments.figures.diagrams.system import MOST_STATES, SystemSizeError, reachable, text_of
from prefplan.front import Front
from prefplan.models.system import System
from prefplan.models.transition_system import TransitionSystem
from prefplan.plan import Plan, objectives_text
from prefplan.text.layout import number

MOST_EDGES = 90
"""Greatest number of edges of a graph that is drawn whole."""

WIDEST_PT = 600.0
"""Greatest width of a left-to-right graph on a page, points: what half a page of 1280 pixels can show legibly."""


@dataclass(frozen=True)
class Route:
    """The drawn part of a graph with a plan on it.

    Attributes:
        nodes: the states that are drawn; the first is the start.
        edges: between them; those of the plan are of the kind `taken`.
        at: for each state of the plan, the index of its node, or of the last node before it if it is not drawn.
        note: which part of the graph is drawn; None if it is drawn whole.
    """

    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    at: tuple[int, ...]
    note: str | None


def route(system: System, plan: Plan) -> Route:
    """Return a small graph with a plan on it; of a large graph, only states that the plan visits.

    Raises:
        SystemSizeError: the plan visits too many states with labels.
    """
    visited, costs = [system.start], []
    for action in plan.actions:
        target, cost = system.step(visited[-1], action)
        visited.append(target)
        costs.append(cost)
    shown, note = _shown(system, visited)
    node_of = {state: i for i, state in enumerate(shown)}
    labels: dict[tuple[int, int], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    stops = [k for k, state in enumerate(visited) if state in node_of]
    for k, m in pairwise(stops):
        action = plan.actions[k] if m == k + 1 else f"{m - k} actions, cost"
        step = str(m) if m == k + 1 else f"{k + 1}-{m}"
        labels[node_of[visited[k]], node_of[visited[m]]][f"{action} {number(sum(costs[k:m]))}"].append(step)
    taken = set(labels)
    for state in shown if note is None else ():
        listed = system.listed
        for edge in listed.edges(state):
            action = listed.action_names[listed.actions[edge]]
            ends = node_of[state], node_of[int(listed.targets[edge])]
            _ = labels[ends][f"{action} {number(listed.cost(edge))}"]
    edges = tuple(
        Edge(*ends, " | ".join(map(_numbered, texts.items())), "taken" if ends in taken else "plain")
        for ends, texts in labels.items()
    )
    at = [0]
    for state in visited[1:]:
        at.append(node_of.get(state, at[-1]))
    return Route(tuple(Node(f"s{i}", text_of(system, state)) for i, state in enumerate(shown)), edges, tuple(at), note)


def svg(route: Route, *, title: str) -> str:
    """Return a route as inline SVG; node i has the class `s<i>`, and an edge of the plan `taken`."""
    return node_link.svg(Diagram(route.nodes, route.edges), title=title, widest=WIDEST_PT)


def draw(system: System, front: Front, path: Path) -> None:
    """Write every plan of a front on its graph, one below the other.

    Raises:
        PrefplanError: a plan visits too many states with labels, or the file cannot be written.
    """
    diagrams = {}
    for i, plan in enumerate(front):
        found = route(system, plan)
        title = f"{i}: {objectives_text(plan, penalty='μ =')}"
        diagrams[f"{title}. {found.note}" if found.note else title] = Diagram(found.nodes, found.edges)
    node_link.draw(diagrams, path)


def _shown(system: System, visited: Sequence[Any]) -> tuple[list[Any], str | None]:
    """Return the states to draw, the start first, and a note on what is drawn, None if the graph is drawn whole."""
    whole = reachable(system)
    if whole is not None and sum(len(system.listed.edges(state)) for state in whole) <= MOST_EDGES:
        return whole, None
    shown, which = list(dict.fromkeys(visited)), "those that the plan visits"
    if len(shown) > MOST_STATES:
        ends = (visited[0], visited[-1])
        shown = [state for state in shown if system.label(state) or state in ends]
        which = "those with propositions that the plan visits, its first and its last"
    if len(shown) > MOST_STATES:
        raise SystemSizeError(f"the plan visits {len(shown)} states with propositions, too many to draw")
    size = system.size if isinstance(system, TransitionSystem) else "very many"
    return shown, f"Drawn of {size} states: {which}."


def _numbered(text: tuple[str, Sequence[str]]) -> str:
    action, steps = text
    return f"{', '.join(steps)}. {action}" if steps else action
