"""`prefplan demo`: Case Study 3 of the paper, from its front to the videos and the page."""

from __future__ import annotations

import argparse
from pathlib import Path

from experiments.cli.arguments import Commands, add_command
from experiments.cli.browser import open_page
from experiments.cli.options import add_options
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import INTERRUPTED


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    more = "It takes about two minutes on two cores. Both videos and the page are in one folder."
    parser = add_command(commands, demo, "prefplan demo", "prefplan demo --no-open --out demo", more=more)
    add_options(parser, "--out", "--no-open", out="out/case_study_3")


def demo(options: argparse.Namespace) -> int:
    """Plan the paper's manipulation case study, carry out its cheapest and its preferred plan, and open their page."""
    with loading():
        from experiments import case_study_3
        from experiments.report.page import INDEX

    tell_if_compiling(quiet=options.quiet)
    out: Path = options.out or case_study_3.OUT
    status = case_study_3.main(out, quiet=options.quiet)
    if status != INTERRUPTED and not options.no_open:
        open_page((out / INDEX).absolute().as_uri())
    return status
