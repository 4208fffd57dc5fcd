"""Studies: results compared with the paper's, printed one by one and collected on one self-contained page."""

import base64
import mimetypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from experiments.cli.browser import template
from experiments.cli.console import Console, table
from experiments.cli.files import make_folder, write_bytes
from experiments.figures import plans
from experiments.regression.front_comparison import FrontPoint, compare
from prefplan import Front, PrefplanError, Scenario
from prefplan.text.layout import number

AGREES, DIFFERS, ERRATUM, MEASURED = "agrees", "DIFFERS", "erratum", "measured"
"""Verdicts. `ERRATUM`: the paper contradicts itself, and ours agrees with its other statement. `MEASURED`: a time."""


@dataclass(frozen=True)
class Finding:
    """One result: what is compared, the paper's value, ours, the verdict, and a remark for the reader."""

    what: str
    paper: str
    ours: str
    verdict: str
    remark: str = ""


@dataclass
class Study:
    """A part of the paper, reproduced.

    Attributes:
        title: its name in the paper.
        about: one sentence on what it is about.
        findings: results compared with the paper's.
        figures: files with pictures, each with its caption.
        texts: lines of text, such as plans.
        failure: why it could not be completed; None if it was.
    """

    title: str
    about: str
    findings: list[Finding] = field(default_factory=list)
    figures: list[tuple[Path, str]] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    failure: str | None = None

    @property
    def reproduced(self) -> bool:
        """Whether the study was completed and nothing differs from the paper except for errata."""
        return self.failure is None and all(finding.verdict != DIFFERS for finding in self.findings)

    def compare(
        self, what: str, paper: str, ours: str, *, agrees: bool = True, verdict: str = AGREES, remark: str = ""
    ) -> None:
        """Add a result with this verdict, or with `DIFFERS` if it does not agree."""
        self.findings.append(Finding(what, paper, ours, verdict if agrees else DIFFERS, remark))

    def compare_front(self, figure: str, published: Sequence[FrontPoint], front: Front) -> None:
        """Add every point that is published or found.

        Published points are in the order of the figure's panels, which have letters.
        """
        for row in compare(published, front):
            panel = f"{figure} ({'abcdefgh'[published.index(row.expected)]})" if row.expected else "not in the paper"
            paper, ours = (f"cost {number(p[0])}, mu {number(p[1])}" if p else "-" for p in (row.expected, row.found))
            self.compare(panel, paper, ours, agrees=row.same)

    def draw(self, scenario: Scenario, front: Front, figure: Path) -> None:
        """Add a figure of every plan of a front on a map, and the plans as text."""
        plans.draw(scenario, front, figure)
        self.figures.append((figure, "every plan of the front, and the front"))
        self.texts += [f"Plan {i}: {plan.steps}" for i, plan in enumerate(front)]

    def fill(self, reproduce: Callable[["Study", Path], None], out: Path, console: Console) -> None:
        """Reproduce the study, its figures in a folder, and print it; a PrefplanError is kept as its failure."""
        try:
            reproduce(self, out)
        except PrefplanError as error:
            self.failure = str(error)
        self.show(console)

    def show(self, console: Console) -> None:
        """Print a table of the findings, the paper and ours side by side, with remarks and figures below."""
        rows = [(one.what, one.paper, one.ours, one.verdict) for one in self.findings]
        if self.failure is None:
            console.print(table(self.title, ("", "paper", "ours", "verdict"), rows))
        else:
            console.print(f"{self.title}: {self.failure}")
        for finding in self.findings:
            if finding.remark:
                console.print(f"  {finding.what}: {finding.remark}", style="dim")
        for picture, _ in self.figures:
            console.print(f"  {picture}")
        console.print()


def show_alone(study: Study, reproduce: Callable[[Study, Path], None]) -> int:
    """Reproduce a study, its figures in a folder of its name; print it and return 0 if it is reproduced, else 1."""
    out = Path("out", study.title.lower().replace(" ", "_"))
    make_folder(out)
    console = Console()
    study.fill(reproduce, out, console)
    for text in study.texts:
        console.print(text)
    return 0 if study.reproduced else 1


def write_page(studies: Sequence[Study], path: Path) -> None:
    """Write a page with studies and their pictures.

    Raises:
        PrefplanError: it cannot be written.
    """
    page = template(__package__, "summary.html").render(
        studies=studies, data_url=_data_url, whole=all(study.reproduced for study in studies)
    )
    write_bytes(path, page.encode())


def _data_url(picture: Path) -> str:
    kind, _ = mimetypes.guess_type(picture)
    return f"data:{kind};base64,{base64.b64encode(picture.read_bytes()).decode()}"
