"""Several costs and several preferences: problems drawn at random, and their fronts by exhaustive search."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

from judge.enumerate import Move, Node, Product, cheapest_cost, undominated
from judge.preferences import Number, Values, random_preference, reference
from judge.problems import GraphProblem
from judge.random_problems import random_errands, random_problem
from judge.replay import replay

COST_NAMES = ("time", "energy", "noise")


class Wish(NamedTuple):
    """A named preference: its table, and the number of the cost in which it measures the tasks' costs."""

    name: str
    table: Mapping[str, Any]
    of: int


@dataclass(frozen=True, eq=False)
class SeveralProblem:
    """A problem with D costs and P preferences.

    Attributes:
        graph: states, tasks, and the edges with their first cost.
        costs: (D,) every cost of each edge by source and action.
        wishes: the preferences.
    """

    graph: GraphProblem
    costs: tuple[Mapping[tuple[str, str], Number], ...]
    wishes: tuple[Wish, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the objectives."""
        return (*COST_NAMES[: len(self.costs)], *(wish.name for wish in self.wishes))

    def with_cost(self, d: int) -> GraphProblem:
        """Return the graph with one of the costs alone."""
        edges = (replace(edge, cost=self.costs[d][edge.source, edge.action]) for edge in self.graph.edges)
        return replace(self.graph, edges=tuple(edges))

    def scenario(self) -> dict[str, Any]:
        """Return the content of a scenario file."""
        content = self.graph.scenario()
        for edge, written in zip(self.graph.edges, content["model"]["transitions"], strict=True):
            each = (costs[edge.source, edge.action] for costs in self.costs)
            written["cost"] = dict(zip(COST_NAMES, map(_decimal, each), strict=False))
        del content["preference"]
        content["preferences"] = [
            {**wish.table, "name": wish.name} | ({"of": COST_NAMES[wish.of]} if wish.of else {}) for wish in self.wishes
        ]
        return content

    def worth(self, spent: Sequence[Number], task_costs: Sequence[Values], violations: Values) -> Values:
        """Return the objectives, given the tasks' costs in every cost."""
        return (*spent, *(mu(task_costs[of], violations) for mu, of in self._functions))

    @property
    def _functions(self) -> list[tuple[Any, int]]:
        return [(reference(wish.table, self.graph.names), wish.of) for wish in self.wishes]


def _decimal(number: Number) -> Any:
    return int(number) if number == int(number) else float(number)


def random_several(seed: int) -> SeveralProblem:
    """Draw a problem with one to three costs and up to two preferences of all kinds; two objectives at the least."""
    rng = random.Random(f"several {seed}")
    costs = rng.choice((1, 2, 2, 2, 3))
    wishes = rng.choice((2, 2, 3)) if costs == 1 else rng.choice((0, 1, 1, 2))
    relaxed = wishes > 0 and rng.random() < 0.3
    if not relaxed and rng.random() < 0.3:
        graph = random_errands(seed, "order")
        graph = replace(graph, tasks=graph.tasks[: rng.choice((1, 2))], preference={"kind": "order"})
    else:
        graph = random_problem(
            seed, kind="max" if relaxed else "order", relaxed=relaxed, tasks=rng.choice((1, 2, 2, 3))
        )
    sizes = rng.choice(((0, 1, 1, 2, 3), (1, 1, 2, 5), (0, 1), (1,)))
    digits = rng.choice((1, 1, 2, 10))
    columns = [{(edge.source, edge.action): edge.cost for edge in graph.edges}]
    for _ in range(costs - 1):
        # What is dear in one cost is often cheap in the other.
        most, opposed = max(columns[0].values()), rng.random() < 0.5
        columns.append(
            {
                at: (most - cost if opposed else Fraction(rng.randrange(digits), digits)) + rng.choice(sizes)
                for at, cost in columns[0].items()
            }
        )
    return SeveralProblem(
        graph, tuple(columns), tuple(_random_wish(rng, graph, k, costs, relaxed) for k in range(wishes))
    )


def _random_wish(rng: random.Random, graph: GraphProblem, k: int, costs: int, relaxed: bool) -> Wish:
    if relaxed and k == 0:
        table = random_preference(rng, graph.names, rng.choice(("weighted-sum", "max", "sum")), "violation")
    else:
        kind = rng.choice(("order", "weighted-sum", "max", "deadline", "expression", "sum"))
        table = random_preference(rng, graph.names, kind)
    return Wish(f"wish{k}", table, rng.randrange(costs))


def bounds_of(problem: SeveralProblem) -> dict[str, Number] | None:
    """Return bounds of all costs that leave some plans; None if no plan exists."""
    least = [cheapest_cost(problem.with_cost(d)) for d in range(len(problem.costs))]
    if None in least:
        return None
    return {name: cost + max(cost / 2, 4) for name, cost in zip(COST_NAMES, map(Fraction, least), strict=False)}


def several_front(
    problem: SeveralProblem, bounds: Mapping[str, Number], *, max_labels: int = 30_000
) -> list[tuple[Number, ...]]:
    """Return every non-dominated vector of objectives, in rising order.

    Args:
        problem: the problem.
        bounds: inclusive, of every cost by name.
        max_labels: labels to make at the most.

    Raises:
        TooManyError: there would be more.
    """
    functions = problem._functions

    def worth(spent: Values, ends: Sequence[Values], paid: Values) -> Values:
        return (*spent, *(mu(tuple(end[of] for end in ends), paid) for mu, of in functions))

    def prices(node: Node, move: Move) -> Values:
        return tuple(costs[node[0], move.action] for costs in problem.costs)

    limits = tuple(bounds[name] for name in problem.names[: len(problem.costs)])
    return sorted(undominated(Product(problem.graph), worth, limits=limits, prices=prices, max_labels=max_labels))


def replayed(problem: SeveralProblem, actions: Sequence[str], relaxations: Sequence[Mapping[str, Any]]) -> Values:
    """Return the objectives of a plan, computed from its trace.

    Raises:
        ValueError: an action or a relaxation that the problem does not offer, or the plan does not end.
    """
    told = [replay(problem.with_cost(d), actions, relaxations) for d in range(len(problem.costs))]
    if not told[0].ends:
        raise ValueError("the plan does not end with its last action")
    return problem.worth([one.cost for one in told], [one.task_costs for one in told], told[0].violations)
