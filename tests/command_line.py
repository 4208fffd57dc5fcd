"""What tests of the command line share: a scenario, and how a mistake is told."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Run = Callable[..., Any]

DETOUR = """
[model]
kind = "graph"
start = "s"
propositions = ["never"]
transitions = [
  { from = "s", to = "shop", cost = 1 },
  { from = "shop", to = "bank", cost = 2.5 },
  { from = "s", to = "bank", cost = 3 },
  { from = "bank", to = "shop", cost = 2 },
]
[model.labels]
shop = ["bread"]
bank = ["money"]

[[tasks]]
name = "pay"
formula = "F money"

[[tasks]]
name = "buy"
formula = "F bread"

[preference]
kind = "order"
"""


def assert_is_error(result: Any, message: str) -> None:
    assert result.status == 2
    assert result.out == ""
    assert message in result.err
    assert "Traceback" not in result.err
