"""Small problems for the judges."""

from __future__ import annotations

from typing import Any

from judge import Edge, GraphProblem, JudgedTask, parse


def tasks(*formulas: str) -> tuple[JudgedTask, ...]:
    return tuple(JudgedTask(f"phi{k + 1}", parse(text)) for k, text in enumerate(formulas))


def graph(
    edges: list[tuple[str, int, str]], marked: dict[str, str], formulas: list[str], preference: dict[str, Any]
) -> GraphProblem:
    return GraphProblem(
        start=edges[0][0],
        edges=tuple(Edge(source, target, cost, target) for source, cost, target in edges),
        labels={state: frozenset(word) for state, word in marked.items()},
        tasks=tasks(*formulas),
        preference=preference,
    )
