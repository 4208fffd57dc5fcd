"""Reports at every width: nothing is cut off or covered, all text is legible, and everything works by keyboard."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import inf
from pathlib import Path

import pytest
from report_browser import Page
from scenario_texts import shipped, shipped_front, task_tables
from selenium import webdriver

from experiments.report.page import write_page
from experiments.starters import starter
from prefplan import Front, Scenario, load
from prefplan.planner import Planner

WIDTHS = (390, 1280, 1920)
"""Of the window, px: a phone, a laptop, a large screen."""

AUDIT = Path(__file__).with_name("page_audit.js").read_text(encoding="utf-8")

MAX_COST = {"case_study_1": 70, "city": 3000, "crowded": 62, "kitchen_energy": 565, "rover": 73}
"""Bounds of fronts with many plans, as a page needs two plans to show all of its parts."""

CROWDED = """# Eight places on a map, some in single cells side by side, and six tasks with long names.
[model]
kind = "grid"
size = [15, 15]
start = [7, 7]
[model.regions]
post_office = [0, 0, 0, 0]
bakery = [14, 14, 14, 14]
swimming_pool = [13, 0, 14, 1]
town_hall = [6, 7, 6, 7]
library = [7, 8, 7, 8]
the_railway_station_of_the_capital_beside_its_botanical_garden = [8, 7, 8, 7]
pharmacy = [14, 7, 14, 7]
park = [2, 10, 5, 12]
[model.obstacles]
river = [[3, 3, 3, 8], [10, 5, 10, 11]]
""" + task_tables(
    collect_the_parcel="F post_office",
    buy_bread_then_sit="!park U (bakery & F park)",
    swim_in_the_municipal_swimming_pool_after_reading_in_the_library=(
        "!swimming_pool U library & F (swimming_pool & F (library & F (post_office | bakery)))"
    ),
    sign_at_the_town_hall="F town_hall & F (library & F park)",
    fetch_medicine="F (pharmacy & F town_hall)",
    visit_everything="F the_railway_station_of_the_capital_beside_its_botanical_garden & F library & F post_office"
    " & F bakery & F pharmacy & F park",
)

ONE_PLAN = """# One plan, whose costs are no integers.
[model]
kind = "graph"
start = "home"
transitions = [
  { from = "home", to = "shop", cost = 26.5 },
]
[model.labels]
shop = ["bread"]
""" + task_tables(buy="F bread", preference='kind = "expression"\nexpression = "2 * buy + 17.5"')

SHIPPED = ("example", "case_study_1", "case_study_2", "case_study_3", "kitchen_energy", "city", "rover")
"""Pages of every kind: maps with and without roads, what is relaxed, an arm, costs with a unit, several objectives."""

OWN = {"crowded": CROWDED, "town": starter("graph", file="town.toml"), "one_plan": ONE_PLAN}

Make = Callable[[str], Path]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """Return a function that makes the page of a scenario, once, of plans that are not carried out."""

    def planned(name: str, folder: Path) -> tuple[Scenario, Front]:
        if name not in OWN:
            front, most = shipped_front(name), MAX_COST.get(name, inf)
            return shipped(name), replace(front, plans=tuple(plan for plan in front if plan.cost <= most))
        (folder / f"{name}.toml").write_text(OWN[name])
        scenario = load(folder / f"{name}.toml")
        return scenario, Planner(scenario.problem()).front(max_cost=MAX_COST.get(name))

    @cache
    def once(name: str) -> Path:
        folder = tmp_path_factory.mktemp(name)
        return write_page(*planned(name, folder), {}, folder)

    return once


WISH = """for (const slider of document.querySelectorAll(".wish input")) {
  slider.value = slider.max / 2;
  slider.dispatchEvent(new Event("input"));
}"""


def opened(chrome: webdriver.Chrome, path: Path) -> Page:
    """Return a page with all its details, middling wishes and, if there are two plans, a comparison."""
    page = Page(chrome, path, still=True)
    page.wait(lambda: page.all("#chart [data-plan]"))
    chrome.execute_script(AUDIT)
    chrome.execute_script(WISH)
    chrome.execute_script("document.querySelectorAll('details').forEach((details) => { details.open = true; })")
    return page


def complaints(page: Page, *of: str) -> list[str]:
    """Return the complaints of parts of the audit about a page once it has stopped changing."""
    parts = ", ".join(f"...audit.{part}()" for part in of)
    script = f"const done = arguments[0]; audit.settled(() => done([{parts}]))"
    found: list[str] = page.browser.execute_async_script(script)
    return [*found, *unnamed(page)] if "access" in of else found


NAMED = {"article", "button", "combobox", "image", "region", "slider", "SvgRoot", "Video"}
"""Roles of what has a name, as the browser tells it to those who cannot see the page."""


def unnamed(page: Page) -> Iterator[str]:
    """Yield what those who cannot see the page would miss: names, the language, the order of headings."""
    for node in page.browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]:
        role, name = (node.get(key, {}).get("value", "") for key in ("role", "name"))
        if role in NAMED and not node["ignored"] and not name.strip():
            yield f"{role} has no name"
    if page.all("[role=group]:not([aria-label])"):
        yield "a group has no name"
    if not page.run("document.documentElement.lang"):
        yield "the page has no language"
    ids = Counter(page.run("[...document.querySelectorAll('[id]')].map((part) => part.id)"))
    yield from (f"the id {name} occurs twice" for name, count in ids.items() if count > 1)
    levels = page.run(
        "[...document.querySelectorAll('h1, h2, h3, h4, h5, h6')].map(({ tagName }) => Number(tagName[1]))"
    )
    for level, below in pairwise([0, *levels]):
        if below > level + 1:
            yield f"a heading of level {below} comes after one of level {level}"


def assert_ticks_are_exact(page: Page) -> None:
    """Check that ticks of the chart stand at the values that occur, and costs have their unit."""
    shown = page.run("JSON.parse(document.getElementById('data').textContent)")
    assert (shown["axes"][0]["name"] == "Total cost (energy, J)") == shown["scenario"].endswith("_energy")
    if shown["objectives"]:
        return  # tests of wishes look at parallel coordinates
    values = [{plan[of] for plan in shown["plans"]} for of in ("cost", "preference")]
    for anchor, tick, occurring in zip(("middle", "end"), ("v8", "h8"), values, strict=True):
        labels = {float(text.text) for text in page.all(f"#chart .labels [text-anchor={anchor}]")}
        assert {min(occurring), max(occurring)} <= labels <= occurring
        assert len(page.all(f"#chart .tick[d$={tick}]")) == len(occurring)
    assert f"{shown['axes'][0]['name']} →" in page.one("#chart").text
    if shown["scenario"] == "one_plan":
        assert values == [{26.5}, {70.5}]


BRIGHTNESS = "Number(getComputedStyle(document.body).backgroundColor.match(/[0-9]+/)[0])"
"""Of the page's red, 0 to 255."""


@pytest.mark.parametrize("name", [*SHIPPED, *OWN])
def test_nothing_is_cut_covered_faint_without_a_name_or_out_of_reach(
    name: str, make: Make, chrome: webdriver.Chrome
) -> None:
    page = opened(chrome, make(name))
    assert_ticks_are_exact(page)
    for width in WIDTHS:
        page.resize(width)
        assert complaints(page, "layout", "playback") == [], width
    page.resize(1280)
    assert complaints(page, "access") == []
    for scheme in ("light", "dark"):
        page.set_scheme(scheme)
        assert complaints(page, "contrast") == [], scheme
        assert (page.run(BRIGHTNESS) > 200) == (scheme == "light")
    chrome.execute_script("document.documentElement.style.fontSize = '200%'")
    assert complaints(page, "layout") == []
    assert page.complaints() == []


PICTURES = """for (const view of document.querySelectorAll('.view')) {
  view.classList.remove("bare");
  view.querySelector(".watch .small").replaceWith();
  view.querySelector(".watch").prepend(document.createElement("video"));
}"""
"""Shows videos, as of plans that are carried out."""


@pytest.mark.parametrize(("name", "last"), [("case_study_1", ".map"), ("case_study_3", ".timeline")])
def test_a_laptop_shows_why_a_plan_costs_more_and_its_picture_above_the_player(
    name: str, last: str, make: Make, chrome: webdriver.Chrome
) -> None:
    page = Page(chrome, make(name), still=True)
    page.wait(lambda: page.all("#chart [data-plan]"))
    if last == ".timeline":
        chrome.execute_script(PICTURES)
        page.wait(lambda: not page.all(".bar.narrow"))
    player = page.one("#transport").rect["y"]
    for part in (".headline", last):
        seen = page.all(f"#views {part}")
        assert len(seen) == 2 and all(one.rect["y"] + one.rect["height"] <= player for one in seen), part


FAULTS = [
    ("layout", ".headline", "style", "margin-top: -3rem", "lies on"),
    ("layout", "h1", "style", "white-space: nowrap; width: 2rem; overflow: hidden", "is cut"),
    ("layout", ".map .name text", "transform", "translate(315 9)", "leaves its picture"),
    ("layout", ".points .scroll", "class", "bare", "the page is"),
    ("layout", ".points .scroll", "style", "mask: none", "there is more"),
    ("contrast", ".caption", "style", "color: #888888", "contrast of"),
    ("access", ".map", "aria-label", "", "has no name"),
    ("access", "html", "lang", "", "has no language"),
    ("access", "#play", "id", "plan", "occurs twice"),
    ("access", "#play", "style", "outline: none", "does not show its focus"),
    ("playback", "#transport", "style", "position: static", "out of sight"),
]
"""Part of the audit, element, attribute, its faulty value, and what is said of it."""


def test_the_audit_sees_faults(make: Make, chrome: webdriver.Chrome) -> None:
    page = opened(chrome, make("example"))
    page.resize(390)
    for of, selector, attribute, value, complaint in FAULTS:
        assert not any(complaint in told for told in complaints(page, of)), complaint
        element = page.all(selector)[0]
        right = element.get_dom_attribute(attribute) or ""
        chrome.execute_script("arguments[0].setAttribute(arguments[1], arguments[2])", element, attribute, value)
        assert any(complaint in told for told in complaints(page, of)), complaint
        chrome.execute_script("arguments[0].setAttribute(arguments[1], arguments[2])", element, attribute, right)
