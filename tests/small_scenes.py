"""Scenarios of one cup and few places, which take seconds to simulate."""

from __future__ import annotations

from collections.abc import Mapping

COSTS = "{ transit = 3, grasp = 1, transport = 5, release = 1 }"

PLACES = {"desk": "{ at = [0.45, 0.10] }", "tray": '{ at = [0.45, -0.25], kind = "bin" }'}

PLACES_NEARBY = PLACES | {"tray": "{ at = [0.45, -0.10] }"}
"""Places between which the arm is soon."""

TIDY = """
[[tasks]]
name = "tidy"
formula = "F cup_tray"

[preference]
kind = "order"
"""


def cup_scenario(tasks: str = TIDY, *, costs: str = COSTS, places: Mapping[str, str] = PLACES) -> str:
    """Return a scenario file of a cup that begins on the desk.

    Args:
        tasks: The tables of the tasks and of the preference.
        costs: The value of `model.costs`.
        places: The values of `model.locations`, in their order.
    """
    lines = "\n".join(f"{name} = {place}" for name, place in places.items())
    return f"""
[model]
kind = "manipulation"
start = "home"
costs = {costs}
[model.locations]
{lines}
[model.objects]
cup = {{ start = "desk" }}
{tasks}"""


CUP = cup_scenario()

RELAXED_CUP = cup_scenario(
    """
[[tasks]]
name = "serve"
formula = "F (cup_clean & cup_tray)"
relax = [{ assume = "cup_clean", when = "cup_tray", cost = 4 }]

[[tasks]]
name = "wash"
formula = "F cup_clean"
skip = 5

[preference]
kind = "weighted-sum"
over = "violation"
weights = { serve = 1, wash = 1 }
""",
    costs="{ transit = 0.5, grasp = 0.1, transport = 0.7, release = 0.2 }",
    places={"desk": PLACES["desk"], "tub": '{ at = [0.45, 0.32], marks = "clean" }', "tray": PLACES["tray"]},
)
"""A cup that may be served unwashed, for a price."""
