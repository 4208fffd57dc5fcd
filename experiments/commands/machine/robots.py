"""`prefplan robots`: the robots that can carry plans out, and which of them are available on this machine."""

from typing import Any

from experiments.cli import options, output
from experiments.cli.command import command, is_quiet
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

    found: list[dict[str, Any]] = []
    reasons: dict[Any, str | None] = {}
    with Bars(quiet=is_quiet()) as bars:
        for number, robot in enumerate(ROBOTS.values()):
            bars("checking", number, len(ROBOTS), robot.name)
            if robot.unavailable_because not in reasons:  # several robots share the check for Menagerie
                reasons[robot.unavailable_because] = robot.unavailable_because()
            reason = reasons[robot.unavailable_because]
            found.append(
                {
                    "name": robot.name,
                    "title": robot.title,
                    "degrees_of_freedom": len(robot.joints),
                    "payload_kg": robot.payload_kg,
                    "available": reason is None,
                    "reason": reason,
                }
            )
    if as_json:
        output.print_json({"robots": found})
        return DONE
    rows = []
    for one in found:
        payload = "" if one["payload_kg"] is None else f"{one['payload_kg']:g} kg"
        available = "yes" if one["available"] else f"no: {one['reason']}"
        rows.append((one["name"], one["title"], str(one["degrees_of_freedom"]), payload, available))
    heads = ("robot", "what it is", "joints", "payload", "available here")
    Console(highlight=False).print(table("", heads, rows, right=(2, 3), bold=[0]))
    return DONE
