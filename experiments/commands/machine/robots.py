"""`prefplan robots`: the robots that can carry plans out, and which of them are available on this machine."""

from typing import Any

from experiments.cli import options, output
from experiments.cli.command import command
from experiments.cli.console import Console, table
from experiments.cli.progress import Bars
from experiments.cli.status import DONE


@command
@options.as_json
def robots(as_json: bool) -> int:
    """List the robots that can carry plans out, and which of them are available on this machine.

    Examples:
      prefplan robots
      prefplan robots --json

    `--robot NAME`, or `robot = "NAME"` under `[model]` in a scenario file, chooses one.
    """
    from sim.robots.catalogue import ROBOTS

    checks = dict.fromkeys(robot.unavailable_because for robot in ROBOTS.values())  # several robots share one
    with Bars() as bars:
        bars("checking", 0, 0, "")
        reasons = {check: check() for check in checks}
    found: list[dict[str, Any]] = [
        {
            "name": robot.name,
            "title": robot.title,
            "degrees_of_freedom": len(robot.joints),
            "payload_kg": robot.payload_kg,
            "available": reasons[robot.unavailable_because] is None,
            "reason": reasons[robot.unavailable_because],
        }
        for robot in ROBOTS.values()
    ]
    if as_json:
        output.print_json({"robots": found})
        return DONE
    rows = []
    for one in found:
        payload = "" if one["payload_kg"] is None else f"{one['payload_kg']:g} kg"
        available = "yes" if one["available"] else f"no: {one['reason']}"
        rows.append((one["name"], one["title"], str(one["degrees_of_freedom"]), payload, available))
    heads = ("robot", "what it is", "joints", "payload", "available here")
    Console().print(table("", heads, rows, right=(2, 3), bold=[0]))
    return DONE
