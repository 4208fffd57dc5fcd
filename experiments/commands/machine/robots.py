"""`prefplan robots`: the robots that can carry plans out, and which of them are available on this machine."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from rich.table import Table

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.console import Console
from experiments.cli.options import add_options
from experiments.cli.progress import Bars
from experiments.cli.status import DONE

if TYPE_CHECKING:
    from sim.robots.robot import Robot


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    more = '`--robot NAME`, or `robot = "NAME"` under `[model]` in a scenario file, chooses one.'
    parser = add_command(commands, robots, "prefplan robots", "prefplan robots --json", more=more)
    add_options(parser, "--json")


def robots(options: argparse.Namespace) -> int:
    """List the robots that can carry plans out, and which of them are available on this machine."""
    from sim.robots.catalogue import ROBOTS

    found: list[dict[str, Any]] = []
    reasons: dict[Any, str | None] = {}
    with Bars(quiet=options.quiet) as bars:
        for number, robot in enumerate(ROBOTS.values()):
            bars("checking", number, len(ROBOTS), robot.name)
            if robot.hindrance not in reasons:  # several robots share the check for Menagerie
                reasons[robot.hindrance] = robot.hindrance()
            found.append(_entry(robot, reasons[robot.hindrance]))
    if options.json:
        output.print_json({"robots": found})
        return DONE
    table = Table()
    table.add_column("robot", no_wrap=True, style="bold")
    table.add_column("what it is")
    table.add_column("joints", justify="right")
    table.add_column("payload", justify="right", no_wrap=True)
    table.add_column("available here")
    for one in found:
        payload = "" if one["payload_kg"] is None else f"{one['payload_kg']:g} kg"
        available = "yes" if one["available"] else f"no: {one['reason']}"
        table.add_row(one["name"], one["title"], str(one["degrees_of_freedom"]), payload, available)
    Console(highlight=False).print(table)
    return DONE


def _entry(robot: Robot, reason: str | None) -> dict[str, Any]:
    """Return the entry of a robot; `reason` is why it is not available, or None."""
    return {
        "name": robot.name,
        "title": robot.title,
        "degrees_of_freedom": len(robot.joints),
        "payload_kg": robot.payload_kg,
        "available": reason is None,
        "reason": reason,
    }
