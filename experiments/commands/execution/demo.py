"""`prefplan demo`: Case Study 3 of the paper, from its front to the videos and the page."""

from __future__ import annotations

import argparse

from experiments.cli.arguments import Commands, add_command, add_no_open
from experiments.cli.browser import open_page
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import INTERRUPTED


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Plan the paper's manipulation case study, carry out both ends of its front, and open a page about it."
    more = "It takes about two minutes on two cores. The videos and the page are in out/case_study_3."
    parser = add_command(commands, demo, summary, "prefplan demo", "prefplan demo --no-open", more=more)
    add_no_open(parser)


def demo(options: argparse.Namespace) -> int:
    """Carry out `prefplan demo`."""
    with loading():
        from experiments import case_study_3

    tell_if_compiling(quiet=options.quiet)
    status = case_study_3.main(quiet=options.quiet)
    if status != INTERRUPTED and not options.no_open:
        open_page(case_study_3.PAGE.absolute().as_uri())
    return status
