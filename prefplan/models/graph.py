"""Explicit model: the transition system written out, edge by edge."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from prefplan.errors import ModelError, check_known, describe
from prefplan.models.costs import DEFAULT_COST, Cost, by_name, check_costs_agree
from prefplan.models.transition_system import TransitionSystem
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import Names, check_names


@dataclass(frozen=True)
class Transition:
    """One edge.

    Attributes:
        source: state that it leaves.
        target: state that it leads to.
        action: its action; None for the target's name.
        cost: >= 0, in the user's units.
    """

    source: str = field(metadata={"key": "from"})
    target: str = field(metadata={"key": "to"})
    action: str | None = None
    cost: Cost = 1


@dataclass(frozen=True)
class GraphModel:
    """Named states and the transitions between them.

    Attributes:
        start: the initial state, which some transition names.
        transitions: in the order in which a state's actions are tried.
        labels: propositions by state; states not listed have none.
        propositions: further names that formulas may use, although they hold in no state.

    Raises:
        ModelError: (on construction) for a start or label of no state, an action that leaves a state twice, a negative
            cost, or costs with different names.
    """

    kind: ClassVar[str] = "graph"

    start: str
    transitions: Annotated[
        tuple[Transition, ...],
        Form('a list such as [{ from = "a", to = "b", cost = 1 }]', 'a tuple such as (Transition("a", "b", cost=1),)'),
    ]
    labels: Mapping[str, Annotated[Sequence[str], Form('a list of propositions, such as ["shelf"]')]] = field(
        default_factory=dict
    )
    propositions: Names = frozenset()

    def __post_init__(self) -> None:
        """Check that every state named exists, and every transition is well formed."""
        check_fields(self, ModelError)
        for i, edge in enumerate(self.transitions):
            for key in ("source", "target", "action"):
                if not isinstance(name := getattr(edge, key), str) and (key != "action" or name is not None):
                    raise ModelError(f"transitions[{i}].{key}: must be a string, not {describe(name)}")
        states = dict.fromkeys(name for edge in self.transitions for name in (edge.source, edge.target))
        if self.transitions:
            check_known("start", "state", self.start, states)
        states[self.start] = None
        for name, label in self.labels.items():
            check_known("labels", "state", name, states)
            check_names(label, where=f"labels.{name}")
        leaving: set[tuple[str, str]] = set()
        for i, edge in enumerate(self.transitions):
            action = (edge.source, edge.action or edge.target)
            if action in leaving:
                raise ModelError(f"transitions[{i}]: action {action[1]!r} leaves state {edge.source!r} twice")
            leaving.add(action)
        check_costs_agree((f"transitions[{i}].cost", edge.cost) for i, edge in enumerate(self.transitions))

    @property
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""
        return tuple(by_name(self.transitions[0].cost)) if self.transitions else (DEFAULT_COST,)

    @property
    def valid_propositions(self) -> frozenset[str]:
        """Every name that a formula may use."""
        return self.propositions.union(*self.labels.values())

    def transition_system(self) -> TransitionSystem:
        """Return the graph as a weighted transition system."""
        return TransitionSystem.from_transitions(
            ((edge.source, edge.action or edge.target, edge.target, edge.cost) for edge in self.transitions),
            start=self.start,
            labels=self.labels,
            propositions=self.propositions,
        )
