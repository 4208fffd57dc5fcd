"""A task's automaton as a picture: a double circle accepts, from a dashed one nothing does any more."""

from __future__ import annotations

from experiments.pictures import node_link
from experiments.pictures.guards import labels
from experiments.pictures.node_link import Diagram, Edge, Node
from prefplan.automaton import Automaton


def diagram(automaton: Automaton) -> Diagram:
    """Return a laid out automaton; state i is node `qi`."""
    nodes = [Node(f"q{state}", (str(state),), *_kind(automaton, state)) for state in range(automaton.size)]
    edges = [
        Edge(state, target, text)
        for state in range(automaton.size)
        for target, text in labels(automaton, state).items()
        if not (state == target and state in (automaton.accepting, automaton.dead))
    ]
    return node_link.arrange(nodes, edges)


def svg(automaton: Automaton, *, prefix: str = "") -> str:
    """Return an automaton as inline SVG in the colour of the text around it.

    Args:
        automaton: the automaton.
        prefix: put before every id.

    Returns:
        The SVG. State i is the group `q<i>` of the class `node`, and `accepting` or `dead` if it is that; what leads
        from i to j is the group `q<i>-q<j>` of the class `edge`, which has a label unless it is the self-loop of an
        absorbing state, which is left out. Each is drawn in its `color`.
    """
    return node_link.svg(diagram(automaton), title=f"Automaton of {automaton.text}", prefix=prefix)


def _kind(automaton: Automaton, state: int) -> tuple[str, str]:
    if state == automaton.accepting:
        return "accepting", "the task is satisfied"
    if state == automaton.dead:
        return "dead", "the task cannot be satisfied any more"
    return "plain", ""
