"""`prefplan robots`: the robots that can carry plans out, and which of them are available on this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from experiments.cli import options, output
from experiments.cli.command import command, is_quiet
from experiments.cli.console import Console, table
from experiments.cli.progress import Bars
from experiments.cli.status import DONE

if TYPE_CHECKING:
    from sim.robots.robot import ArmConstants


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
            found.append(_entry(robot, reasons[robot.unavailable_because]))
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


def _entry(robot: ArmConstants, reason: str | None) -> dict[str, Any]:
    """Return the entry of a robot; `reason` is why it is not available, or None."""
    return {
        "name": robot.name,
        "title": robot.title,
        "degrees_of_freedom": len(robot.joints),
        "payload_kg": robot.payload_kg,
        "available": reason is None,
        "reason": reason,
    }
