"""`prefplan demo`: Case Study 3 of the paper, from its front to the videos and the page."""

from pathlib import Path

from experiments.cli import options
from experiments.cli.command import command
from experiments.cli.files import only_writer
from experiments.cli.start import load_planner
from experiments.cli.status import INTERRUPTED


@command
@options.out("out/case_study_3")
@options.no_open
def demo(out: Path | None, no_open: bool) -> int:
    """Plan the paper's manipulation case study, carry out its cheapest and its preferred plan, and open their page.

    Examples:
      prefplan demo
      prefplan demo --no-open --out demo

    It takes about two minutes on two cores. Both videos and the page are in one folder.
    """
    from experiments import case_study_3
    from experiments.cli.browser import open_page
    from experiments.report.page import INDEX

    load_planner()
    folder = out or case_study_3.OUT
    with only_writer(folder):
        status = case_study_3.main(folder)
    if status != INTERRUPTED and not no_open:
        open_page((folder / INDEX).absolute().as_uri())
    return status
