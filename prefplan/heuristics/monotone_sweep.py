"""Exact cost-to-go for task subsets whose DFAs never get worse by reading a label: a sweep without any Dijkstra.

Let no label lead an automaton to a state that is worse than the one before, as for `F (a & F b)`. Then the labels
passed on the way to a node do no harm, and from node s and automaton states q

    h(s, q) = min over nodes v whose label changes q of d(s, v) + h(v, delta(q, L(v))),

where d are least costs in the whole graph. The combinations of states are taken in the order of `dag_sweep`,
which must know the nodes that may be passed in each of them, and takes five to ten times as long.
"""

from __future__ import annotations

import numpy as np

from prefplan.heuristics.dag_sweep import Stages, relax, targets_of
from prefplan.limits import check_limits
from prefplan.product.kernels import INFINITE, NO_EDGE, UNREACHABLE, kernel
from prefplan.product.product_automaton import Product

LARGEST_SIMULATED = 1_000
"""Most states of an automaton of which all pairs are compared: 1 ms for each label and round."""


def never_lose(product: Product) -> bool:
    """Return whether reading a label never leads an automaton to a state that is worse than the one before.

    A state is no worse than another if it is an end whenever the other is, and every label leads from it to a state no
    worse than from the other (the greatest simulation). False also if an automaton is too large to try.
    """
    for i, size in enumerate(product.sizes.tolist()):
        if size > LARGEST_SIMULATED:
            return False
        after = product.delta[i, :size].astype(np.int64)
        ends = np.isin(np.arange(size), product.ends[i])
        no_worse, before = ends[:, None] >= ends[None, :], None
        while before is None or (no_worse < before).any():
            before = no_worse.copy()
            for label in after.T:
                check_limits()
                no_worse &= before[label[:, None], label[None, :]]
        if not no_worse[after, np.arange(size)[:, None]].all():
            return False
    return True


@kernel
def fill_monotone(stages: Stages, least: np.ndarray, tasks: np.ndarray, table: np.ndarray, stop: np.ndarray) -> None:
    """Fill a table with least costs until some tasks are satisfied or dropped; return early once `stop` is set.

    Args:
        stages: the product, for which `never_lose` holds.
        least: (S, S) int64, least costs from node to node, through any others, NO_EDGE for none.
        tasks: (k,) int64, which tasks.
        table: (S * Q_1 * ... * Q_k,) int32, to be filled, indexed node + S * (q_1 + Q_1 * (q_2 + ...)); costs are cut
            off at UNREACHABLE - 1.
        stop: (1,) bool.
    """
    nodes, k = stages.classes.shape[0], tasks.shape[0]
    matters = np.zeros(nodes, dtype=np.bool_)
    for j in range(k):
        matters |= stages.active[tasks[j]]
    changing = np.flatnonzero(matters)
    ahead, onto = least[:, changing].T.copy(), targets_of(stages, tasks, changing)
    # Sums over tasks from the j-th on: the combination's first entry, those after each label, how many tasks are done.
    here, done = np.zeros(k + 1, dtype=np.int64), np.zeros(k + 1, dtype=np.int64)
    there = np.zeros((k + 1, changing.shape[0]), dtype=np.int64)
    strides, ranks = np.empty(k, dtype=np.int64), np.zeros(k, dtype=np.int64)
    stride = nodes
    for j in range(k):
        strides[j] = stride
        stride *= stages.sizes[tasks[j]]
    costs = np.empty(nodes, dtype=np.int64)
    j = k - 1
    for _ in range(table.shape[0] // nodes):
        if stop[0]:
            return
        while j >= 0:
            q = stages.order[tasks[j], ranks[j]]
            here[j] = here[j + 1] + strides[j] * q
            done[j] = done[j + 1] + (q == stages.ends[tasks[j], 0] or q == stages.ends[tasks[j], 1])
            there[j] = there[j + 1] + onto[j, q]
            j -= 1
        costs[:] = 0 if done[0] == k else NO_EDGE
        for d in range(changing.shape[0]):
            if there[0, d] != here[0]:
                rest = np.int64(table[there[0, d] + changing[d]])
                if rest < UNREACHABLE:
                    relax(ahead[d], rest, costs)
        for node in range(nodes):
            table[here[0] + node] = UNREACHABLE if costs[node] >= INFINITE else min(costs[node], UNREACHABLE - 1)
        j = 0
        while j < k:
            ranks[j] += 1
            if ranks[j] < stages.sizes[tasks[j]]:
                break
            ranks[j] = 0
            j += 1
