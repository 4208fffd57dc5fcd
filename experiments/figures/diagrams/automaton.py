"""A task's automaton as a picture: the accepting state is a double circle, the dead state is dashed."""

from experiments.figures.diagrams.guards import AutomatonSizeError, labels
from experiments.figures.diagrams.node_link import Diagram, Edge, Node
from prefplan.logic.dfa import Automaton

MOST_STATES = 40
"""Greatest number of states of an automaton that is drawn: larger ones are illegible."""


def diagram(automaton: Automaton) -> Diagram:
    """Return an automaton as a diagram without self-loops of absorbing states; state i is node `q<i>`.

    Raises:
        AutomatonSizeError: it has too many states or propositions.
    """
    if automaton.size > MOST_STATES:
        raise AutomatonSizeError(
            f"the automaton of '{automaton.text}' has {automaton.size} states, and only one of up to {MOST_STATES} "
            "can be drawn so that it can be read"
        )
    kinds = {automaton.accepting: "accepting", automaton.dead: "dead"}
    nodes = [Node(f"q{state}", (str(state),), kinds.get(state, "plain")) for state in range(automaton.size)]
    edges = [
        Edge(state, target, text)
        for state in range(automaton.size)
        for target, text in labels(automaton, state).items()
        if not (state == target and state in (automaton.accepting, automaton.dead))
    ]
    return Diagram(nodes, edges)
