"""Plans on graphs: a box for each state, an arrow for each action, numbered if the plan takes it."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from experiments.checks.propositions import reachable
from experiments.figures.diagrams import node_link
from experiments.figures.diagrams.node_link import Diagram, Edge, Node
from prefplan import Front, Plan, PrefplanError, TransitionSystem
from prefplan.models.system import System
from prefplan.plan import objectives_text
from prefplan.text.layout import number

MOST_STATES = 40
"""Greatest number of states that are drawn: more are illegible."""

MOST_EDGES = 90
"""Greatest number of edges of a graph that is drawn whole with a plan on it."""

MOST_NAMES = 3
"""Greatest number of propositions shown in a state."""

Labels = dict[tuple[int, int], dict[str, list[str]]]
"""The actions on each edge, given by the indices of its nodes, with the steps of a plan that take them."""


class SystemSizeError(PrefplanError):
    """A plan visits more states than a picture can show."""


@dataclass(frozen=True)
class Route:
    """The drawn part of a graph with a plan on it.

    Attributes:
        diagram: states, the first of which is the start, and edges; those of the plan are of the kind `taken`.
        at: for each state of the plan, the index of its node, or of the last node before it if it is not drawn.
        note: which part of the graph is drawn; None if it is drawn whole.
    """

    diagram: Diagram
    at: tuple[int, ...]
    note: str | None

    @property
    def words(self) -> str:
        """What is drawn, for readers who cannot see it."""
        visited = ", ".join(self.diagram.nodes[i].text[0] for i in dict.fromkeys(self.at))
        return f"Graph of {len(self.diagram.nodes)} states with the plan on it; it visits {visited}"


def route(system: System, plan: Plan) -> Route:
    """Return a small graph with a plan on it; of a large graph, only states that the plan visits.

    Raises:
        SystemSizeError: the plan visits too many states with labels.
    """
    system = system.small or system
    visited, costs = [system.start], []
    for action in plan.actions:
        target, cost = system.step(visited[-1], action)
        visited.append(target)
        costs.append(cost)
    shown, note = _shown(system, visited)
    node_of = {state: i for i, state in enumerate(shown)}
    labels: Labels = defaultdict(lambda: defaultdict(list))
    stops = [k for k, state in enumerate(visited) if state in node_of]
    for k, m in pairwise(stops):
        action = plan.actions[k] if m == k + 1 else f"{m - k} actions, cost"
        step = str(m) if m == k + 1 else f"{k + 1}-{m}"
        labels[node_of[visited[k]], node_of[visited[m]]][f"{action} {number(sum(costs[k:m]))}"].append(step)
    if note is None:
        listed = system.listed
        for state in shown:
            for edge in listed.edges(state):
                action = listed.action_names[listed.actions[edge]]
                _ = labels[node_of[state], node_of[int(listed.targets[edge])]][f"{action} {number(listed.cost(edge))}"]
    at = [0]
    for state in visited[1:]:
        at.append(node_of.get(state, at[-1]))
    nodes = [Node(f"s{i}", _text(system, state)) for i, state in enumerate(shown)]
    edges = []
    for ends, texts in labels.items():
        numbered = [f"{', '.join(steps)}. {action}" if steps else action for action, steps in texts.items()]
        edges.append(Edge(*ends, " | ".join(numbered), "taken" if any(texts.values()) else "plain"))
    return Route(Diagram(nodes, edges), tuple(at), note)


def draw(system: System, front: Front, path: Path) -> None:
    """Write every plan of a front on its graph, one below the other.

    Raises:
        PrefplanError: a plan visits too many states with labels, or the file cannot be written.
    """
    diagrams = {}
    for i, plan in enumerate(front):
        found = route(system, plan)
        title = f"{i}: {objectives_text(plan, penalty='μ =')}"
        diagrams[f"{title}. {found.note}" if found.note else title] = found.diagram
    node_link.draw(diagrams, path)


def _shown(system: System, visited: Sequence[Any]) -> tuple[list[Any], str | None]:
    """Return the states to draw, the start first, and a note on what is drawn, None if the graph is drawn whole."""
    if isinstance(system, TransitionSystem):
        states = reachable(system).tolist()
        if len(states) <= MOST_STATES and sum(len(system.edges(state)) for state in states) <= MOST_EDGES:
            return states, None
    shown, which = list(dict.fromkeys(visited)), "those that the plan visits"
    if len(shown) > MOST_STATES:
        ends = (visited[0], visited[-1])
        shown = [state for state in shown if system.label(state) or state in ends]
        which = "those with propositions that the plan visits, its first and its last"
    if len(shown) > MOST_STATES:
        raise SystemSizeError(f"the plan visits {len(shown)} states with propositions, too many to draw")
    size = system.size if isinstance(system, TransitionSystem) else "very many"
    return shown, f"Drawn of {size} states: {which}."


def _text(system: System, state: Any) -> tuple[str, ...]:
    """Return the lines of text in a state: its name and its propositions."""
    name = system.decode(state)
    label = sorted(system.label(state))
    shown = [*label[:MOST_NAMES], *(["..."] if len(label) > MOST_NAMES else [])]
    text = f"({', '.join(map(str, name))})" if isinstance(name, tuple) else str(name)
    return (text, "{" + ", ".join(shown) + "}") if shown else (text,)
