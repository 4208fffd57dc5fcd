"""The documentation is built without a warning, and has all that the packages offer and every scenario that ships."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from scenario_texts import shipped_front

import prefplan
import sim
from experiments import scenarios
from prefplan.text.layout import number

inventory = pytest.importorskip("sphinx.util.inventory")
build_main = pytest.importorskip("sphinx.cmd.build").build_main

# Sphinx warns extensions of changes in its next version.
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::PendingDeprecationWarning")

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The pages, as `make docs` builds them, without those that show the sources and the index for searching."""
    folder: Path = tmp_path_factory.mktemp("site")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs" / "pictures")
        patch.setattr("sphinx.ext.viewcode.collect_pages", lambda app: iter(()))  # a quarter of the work
        patch.setattr("sphinx.builders.html.StandaloneHTMLBuilder.search", False)
        # The fronts are planned once, here and in other tests, which takes as long as all the rest.
        patch.setattr("gallery.front_of", lambda scenario: shipped_front(scenario.name))
        assert build_main(["--fail-on-warning", "--keep-going", "--quiet", str(ROOT / "docs"), str(folder)]) == 0
    return folder


@pytest.mark.slow
def test_the_reference_has_everything_that_the_packages_offer(site: Path) -> None:
    described = inventory.InventoryFile.loads((site / "objects.inv").read_bytes(), uri="").data
    names = {name for kind in described if kind.startswith("py:") for name in described[kind]}
    assert {f"prefplan.{name}" for name in prefplan.__all__} - names == set()
    assert {f"sim.{name}" for name in sim.__all__} - names == set()


@pytest.mark.slow
def test_a_reader_sees_from_where_a_name_is_imported(site: Path) -> None:
    shown = {"planning": "prefplan.pareto_front", "simulation": "sim.execute", "programs": "experiments."}
    for page, name in shown.items():
        text = (site / "reference" / f"{page}.html").read_text(encoding="utf-8")
        assert name in re.sub("<[^>]*>", "", text)


@pytest.mark.slow
def test_pages_need_nothing_from_the_network_and_the_first_leads_to_all_others(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert len(pages) > 12
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert 'src="http' not in text and '<link rel="stylesheet" href="http' not in text, page
    text = (site / "index.html").read_text(encoding="utf-8")
    for page in (ROOT / "docs").glob("*/*.md"):
        assert f'href="{page.parent.name}/{page.stem}.html"' in text


@pytest.mark.slow
@pytest.mark.parametrize("name", scenarios.names())
def test_the_gallery_has_each_scenario_with_its_picture_and_front(site: Path, name: str) -> None:
    page = (site / "gallery.html").read_text(encoding="utf-8")
    _, _, after = page.partition(f'<section id="{name.replace("_", "-")}">')
    section, _, _ = after.partition("</section>")
    rows = [re.findall(r"<td[^>]*><p>(.*?)</p></td>", row) for row in section.split("<tr")[2:]]
    expected = [list(map(number, plan.objectives.values())) for plan in shipped_front(name)]
    assert [row[1 : 1 + len(worth)] for row, worth in zip(rows, expected, strict=True)] == expected
    (picture,) = re.findall(r'<img [^>]*src="([^"]*)"', section)
    assert (site / picture).stat().st_size > 0


def test_the_pictures_of_the_gallery_are_light() -> None:
    pictures = list((ROOT / "docs" / "gallery").iterdir())
    assert sorted(picture.stem for picture in pictures) == scenarios.names()
    assert sum(picture.stat().st_size for picture in pictures) < 40_000 * len(pictures)
