"""Options that several commands have, by name."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from experiments.cli.arguments import (
    Bound,
    megabytes,
    named_number,
    number,
    picture_size,
    positive,
    seconds,
    which_plan,
    whole,
)
from experiments.cli.completion import complete, scenario_files
from prefplan.limits import Limits

LIMITS = ("--max-seconds", "--max-memory")
"""Limits of a search; `found` is what it returns when one is reached."""

PLAN = ("--plan", "--max-preference", "--max-cost")
"""The choice of a plan of the front; read by `experiments.cli.choice`."""

VIDEO = ("--no-video", "--quality", "--camera", "--inset", "--size")
"""Whether and how videos are rendered; read by `experiments.cli.simulation_options`."""

TEXTS = {"found": "what is known by then", "out": "out/SCENARIO", "starts": "at random by up to 5 mm and 5 degrees"}
"""Parts of the help of options that commands may replace, with their defaults."""

OPTIONS: dict[str, dict[str, Any]] = {
    "scenario": {
        "metavar": "SCENARIO",
        "help": "name of a scenario that `prefplan list` shows, or path of a TOML file",
    },
    "--json": {"action": "store_true", "help": "print one JSON object and nothing else"},
    "--plot": {"metavar": "FILE", "help": "draw a figure too; the file ends in .png, .svg or .pdf"},
    "--max-cost": {
        "type": number,
        "metavar": "C",
        "help": "greatest total cost of a plan; required if the preference's contract is general",
    },
    "--max-preference": {"type": number, "metavar": "M", "help": "greatest penalty of a plan"},
    "--at-most": {
        "action": Bound,
        "type": named_number,
        "metavar": "NAME=VALUE",
        "help": "upper bound on a cost or a preference by its name, such as energy=40; may be repeated",
    },
    "--max-seconds": {"type": seconds, "metavar": "S", "help": "stop after this time with {found}"},
    "--max-memory": {
        "type": megabytes,
        "metavar": "MiB",
        "help": "stop before the search uses more memory, with {found}",
    },
    "--plan": {
        "type": which_plan,
        "default": "cost",
        "metavar": "cost|preference|INDEX",
        "help": "which plan of the front: the cheapest, the preferred (these words do as well), or by its "
        "number from 0 (default: cost)",
    },
    "--fault": {
        "action": "append",
        "default": [],
        "metavar": "FAULT",
        "help": "inject a fault at action K, or at the next one where it is possible; may be repeated: slip@K, "
        "move:OBJECT@K, knock:OBJECT@K, miss:N@K, foreign:LOCATION@K, blind:SECONDS@K",
    },
    "--perturb": {
        "metavar": "KEY=VALUE,...",
        "help": "greatest random differences: position, centre (of mass), noise and bias (of the camera) in mm; angle "
        "in degrees; latency in ms; friction, pads, table, force and mass as a share of 1 (default: "
        "position=5,angle=5)",
    },
    "--robot": {
        "metavar": "NAME",
        "help": "one of those that `prefplan robots` lists (default: the scenario's, or panda)",
    },
    "--no-video": {"action": "store_true", "help": "render no video"},
    "--quality": {
        "metavar": "NAME",
        "default": "draft",
        "help": "draft: 1280 x 720; final: 1920 x 1080 with soft shadows, in ten times the time (default: draft)",
    },
    "--camera": {
        "metavar": "NAME",
        "default": "fixed",
        "help": "fixed: in front of the table; orbit: around its front; wrist: on the hand; top: from above; another "
        "camera of the scene's MJCF by its name; or azimuth and elevation in degrees and distance in m, such as "
        "156,-28,1.2 (default: fixed)",
    },
    "--inset": {
        "metavar": "NAME",
        "help": "a second, small view in a corner: wrist or top, as --camera (default: none)",
    },
    "--size": {"type": picture_size, "metavar": "WxH", "help": "width and height in pixels (default: the quality's)"},
    "--seed": {
        "type": whole,
        "metavar": "N",
        "help": "start each object off its nominal pose, {starts} (default: nominal poses)",
    },
    "--out": {"type": Path, "metavar": "DIR", "help": "folder for the results (default: {out})"},
    "--no-open": {"action": "store_true", "help": "print the address of the page, but open no browser"},
    "--jobs": {"type": positive, "metavar": "N", "help": "number of processes (default: one per core)"},
}


def add_options(parser: argparse._ActionsContainer, *names: str, **texts: str) -> None:
    """Add some of `OPTIONS` to a parser, in this order; `texts` replace some of `TEXTS` in their help."""
    for name in names:
        option = OPTIONS[name]
        told = option["help"].format(**TEXTS | texts)
        argument = parser.add_argument(name, **option | {"help": told})
        if name == "scenario":
            complete(argument, scenario_files())


def limits_of(options: argparse.Namespace) -> Limits:
    """Return the limits that `LIMITS` set, from now on; as a context, they hold for reading a scenario as well."""
    seconds, memory = options.max_seconds, options.max_memory
    return Limits(math.inf if seconds is None else seconds, math.inf if memory is None else memory)
