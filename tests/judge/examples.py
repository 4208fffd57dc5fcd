"""Small problems on which judges and planner are compared."""

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


TRAPS = {
    "product": (
        graph(
            [("s0", 1, "s1"), ("s0", 2, "s2"), ("s1", 9, "s3"), ("s2", 1, "s3"), ("s3", 5, "s4")],
            {"s1": "a", "s2": "a", "s4": "b"},
            ["F a", "F b"],
            {"kind": "expression", "expression": "phi1 * phi2"},
        ),
        "componentwise",
        [(8, 16), (15, 15)],
    ),
    "capped sum": (
        graph(
            [("s", 1, "A"), ("A", 19, "P"), ("s", 10, "P"), ("P", 10, "B")],
            {"A": "a", "P": "a", "B": "b"},
            ["F a", "F b"],
            {"kind": "expression", "expression": "phi1 + min(phi2, 20)"},
        ),
        "componentwise",
        [(20, 30), (30, 21)],
    ),
    "maximum plus sum": (
        graph(
            [("s", 2, "x"), ("x", 8, "y"), ("y", 1, "P"), ("s", 2, "z"), ("z", 8, "w"), ("w", 1, "P"), ("P", 29, "Q")],
            {"x": "b", "y": "a", "z": "a", "w": "b", "Q": "c"},
            ["F a", "F b", "F c"],
            {"kind": "expression", "expression": "max(3 * phi1, phi3) + 2 * phi2"},
        ),
        "componentwise",
        [(40, 44)],
    ),
    # At y the vector (1, 3) dominates (2, 3), yet the later phi1 is the better one.
    "spread": (
        graph(
            [("s", 1, "x"), ("x", 2, "y"), ("s", 2, "z"), ("z", 1, "y")],
            {"x": "a", "z": "a", "y": "b"},
            ["F a", "F b"],
            {"kind": "expression", "expression": "max(phi1, phi2) - min(phi1, phi2)"},
        ),
        "additive",
        [(3, 1)],
    ),
    "loops that cost nothing": (
        graph(
            [("s", 0, "t"), ("t", 0, "s"), ("t", 0, "t"), ("s", 3, "u")],
            {"t": "a", "u": "b"},
            ["F(b & F b)", "F a"],
            {"kind": "order"},
        ),
        "additive",
        [(3, 3)],
    ),
}
"""Problems whose front loses a point if the search assumes a wrong contract: the problem, its contract, its front.

Componentwise ones lose it if labels are pruned by cost and mu, the additive one if by vectors of task costs.
"""
