"""Do the paper's examples, case studies and benchmark again, and put all on one page beside what it printed.

The exit status is 0 if everything agrees (the paper's own errors, named as such, aside), 1 if something differs or
could not be done, 2 for a wrong call and 130 after Ctrl-C.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from experiments.benchmark import table1
from experiments.cli.console import Console
from experiments.cli.files import make_folder
from experiments.cli.start import tell_if_compiling
from experiments.cli.status import BAD_INPUT, DONE, INTERRUPTED
from experiments.paper.arm import case_study_3
from experiments.paper.findings import Study
from experiments.paper.grids import case_study_1, case_study_2, examples
from experiments.paper.page import write_page
from experiments.paper.show import DIFFERENT, show
from experiments.paper.table import table_1
from prefplan.errors import PrefplanError


def main(arguments: Sequence[str] | None = None) -> int:
    """Do everything, print each study as it is done, write the page, and return the exit status."""
    options = _options(arguments)
    console = Console(highlight=False)
    tell_if_compiling()
    try:
        make_folder(options.out)
        studies = []
        for title, work in _works(options).items():
            studies.append(attempt(title, work))
            show(console, studies[-1])
        page = options.out / "index.html"
        write_page(studies, page)
    except PrefplanError as error:
        print(f"reproduce_paper: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("reproduce_paper: interrupted", file=sys.stderr)
        return INTERRUPTED
    console.print(f"\n{sum(s.reproduced for s in studies)} of {len(studies)} reproduced: {page}", markup=False)
    return DONE if all(study.reproduced for study in studies) else DIFFERENT


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out", "paper"), help="folder (default: out/paper)")
    parser.add_argument("--quick", action="store_true", help="plan Case Study 3 but do not simulate it")
    parser.add_argument(
        "--benchmark", action="store_true", help="time the benchmark anew, which takes hours (with --quick a minute)"
    )
    return parser.parse_args(arguments)


def _works(options: argparse.Namespace) -> dict[str, Callable[[], Study]]:
    """Return what is to be done, by title."""
    return {
        "Examples 1 to 3": partial(examples, options.out),
        "Case Study 1": partial(case_study_1, options.out),
        "Case Study 2": partial(case_study_2, options.out),
        "Case Study 3": partial(case_study_3, options.out, simulate=not options.quick),
        "Table I": partial(_benchmark, options) if options.benchmark else partial(table_1, options.out),
    }


def _benchmark(options: argparse.Namespace) -> Study:
    """Return Table I from times that are taken now."""
    folder = options.out / "table_1"
    status = table1.main(["--out", str(folder), *(["--quick"] if options.quick else [])])
    if status == INTERRUPTED:
        raise KeyboardInterrupt
    if status != DONE:
        raise PrefplanError("the benchmark refused its own answers, see above")
    return table_1(options.out, folder)


def attempt(title: str, work: Callable[[], Study]) -> Study:
    """Return a study; one that cannot be done says why."""
    try:
        return work()
    except PrefplanError as error:
        return Study(title, "", failure=str(error))


if __name__ == "__main__":
    sys.exit(main())
