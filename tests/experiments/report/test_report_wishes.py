"""Reports of three and more objectives: parallel coordinates, and the price of a wish, checked against the plans."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from report_browser import Page
from scenario_texts import shipped, shipped_front
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from experiments.report.data import page_data
from experiments.report.page import write_page
from prefplan import Front, pareto_front
from prefplan.exact_costs import Number
from prefplan.scenario.decode import loads
from prefplan.text.layout import number

NO_WISH = "No wish yet: move a slider to the left."

LARGE = 2**53
"""The next whole number is no double."""

YARD = """
[model]
kind = "grid"
size = [5, 3]
start = [0, 1]
cost = { time = 2, energy = 2 }
[model.terrain]
mud = { boxes = [[1, 0, 3, 1]], cost = { time = MUD, energy = 5 } }
[model.regions]
gate = [4, 1, 4, 1]
[[tasks]]
name = "leave"
formula = "F gate"
"""

SEA = f"""
[model]
kind = "graph"
start = "home"
transitions = [
  {{ from = "home", to = "motorway", cost = {{ time = 0.1, toll_in_euros = 9.5, fuel = 7 }} }},
  {{ from = "home", to = "road", cost = {{ time = 0.7, toll_in_euros = 0, fuel = 6 }} }},
  {{ from = "home", to = "track", cost = {{ time = 6, toll_in_euros = 0, fuel = 4 }} }},
  {{ from = "motorway", to = "coast", cost = {{ time = 0.2, toll_in_euros = 2, fuel = 1 }} }},
  {{ from = "road", to = "coast", cost = {{ time = 0.2, toll_in_euros = 0, fuel = 1 }} }},
  {{ from = "track", to = "coast", cost = {{ time = 1, toll_in_euros = 0, fuel = 1 }} }},
  {{ from = "coast", to = "beach", cost = {{ time = 1, toll_in_euros = 1, fuel = {LARGE} }} }},
  {{ from = "coast", to = "cliff", cost = {{ time = 1, toll_in_euros = 0, fuel = {LARGE + 1} }} }},
  {{ from = "coast", to = "cove", cost = {{ time = 4, toll_in_euros = 0, fuel = {LARGE} }} }},
]
[model.labels]
beach = ["sea", "sand"]
cliff = ["sea"]
cove = ["sea", "sand"]
[[tasks]]
name = "swim"
formula = "F sea"
[[tasks]]
name = "dig"
formula = "F sand"
skip = 3
[[preferences]]
name = "skipped"
kind = "weighted-sum"
over = "violation"
weights = {{ dig = 1 }}
"""

Make = Callable[[str], tuple[Front, Path]]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """Return a function that makes the page of a scenario, once."""

    @cache
    def once(name: str) -> tuple[Front, Path]:
        scenario = shipped(name) if name == "rover" else loads(SEA, name=name)
        front = shipped_front(name) if name == "rover" else pareto_front(scenario.problem())
        if name == "unfinished":
            front = replace(front, ended="time", complete_below=0)
        return front, write_page(scenario, front, {}, tmp_path_factory.mktemp(name))

    return once


def values(front: Front, name: str) -> list[Number]:
    return sorted({plan.objectives[name] for plan in front})


def meeting(front: Front, wished: Mapping[str, Number]) -> list[int]:
    return [i for i, plan in enumerate(front) if all(plan.objectives[name] <= most for name, most in wished.items())]


def sentence(front: Front, wished: Mapping[str, Number]) -> str:
    """Return what is to be said of wishes; of an unfinished front, less."""

    def least(name: str, plans: list[int]) -> Number:
        return min(front[i].objectives[name] for i in plans)

    if not wished:
        return NO_WISH
    words = ", ".join(f"{name} at most {number(most)}" for name, most in wished.items())
    left, everything = meeting(front, wished), meeting(front, {})
    at_least, found = ("at least ", "") if front.complete else ("", " among the plans found")
    if left:
        rises = [
            f"{name} from {number(least(name, everything))} to {at_least}{number(least(name, left))}"
            for name in front.objectives
            if least(name, left) > least(name, everything)
        ]
        if rises:
            return f"{words}{found and f',{found}'}: {', '.join(rises)}."
        free = "can still have its least" if front.complete else f"has its least{found}"
        return f"{words}: every other objective {free}."
    others = {name: meeting(front, {one: most for one, most in wished.items() if one != name}) for name in wished}
    alone = [f"{name} is {at_least}{number(least(name, plans))}{found}" for name, plans in others.items() if plans]
    instead = f" With the other wishes, {', '.join(alone)}." if alone else ""
    return f"{'No plan' if front.complete else 'None of the plans found'} has {words} at once.{instead}"


WISH = """return arguments[0].map((bounds) => {
  bounds.forEach((bound, k) => { document.getElementById(`wish-${k}`).value = bound; });
  document.getElementById("wish-0").dispatchEvent(new Event("input"));
  const all = (selector) => [...document.querySelectorAll(selector)], said = all("#wished")[0].textContent;
  const grey = (selector) => all(selector).map((part) => Number(part.dataset.plan)).sort((a, b) => a - b);
  const shown = all(".wish output").map((output) => output.textContent);
  return { said, shown, lines: grey(".line.beyond"), rows: grey("tr.beyond") };
});"""


@pytest.mark.parametrize("name", ["rover", "sea", "unfinished"])
def test_what_wishes_cost_is_what_the_plans_that_meet_them_say(name: str, make: Make, chrome: webdriver.Chrome) -> None:
    front, path = make(name)
    page, draw = Page(chrome, path, chosen="#plan=0", still=True), random.Random(5)
    found = {name: values(front, name) for name in front.objectives}
    most = [len(one) - 1 for one in found.values()]
    ends = [[*most[:k], 0, *most[k + 1 :]] for k in range(len(most))]
    drawn = [[draw.choice([k, draw.randint(0, k)]) for k in most] for _ in range(40)]
    tried = [most, [0] * len(most), *ends, *drawn]
    heard = set()
    for bounds, told in zip(tried, chrome.execute_script(WISH, tried), strict=True):
        wished = {
            name: one[bound] for (name, one), bound in zip(found.items(), bounds, strict=True) if bound < len(one) - 1
        }
        assert told["said"] == sentence(front, wished)
        beyond = sorted({*range(len(front))} - {*meeting(front, wished)})
        assert told["lines"] == told["rows"] == beyond
        assert [f"at most {number(most)}" in told["shown"] for most in wished.values()] == [True] * len(wished)
        heard.add(re.sub(r"[^A-Z].*", "", told["said"]) + str("With" in told["said"]))
    assert len(heard) >= 3, "each kind of sentence"
    page.click(page.one("#wishes button"))
    assert page.one("#wished").text == NO_WISH and not page.all(".beyond")
    page.press(Keys.ARROW_LEFT)
    assert page.all(".wish output")[0].text == f"at most {number(next(iter(found.values()))[-2])}"
    assert page.complaints() == []


def test_a_wish_in_words(make: Make, chrome: webdriver.Chrome) -> None:
    _, path = make("sea")
    page = Page(chrome, path, width=390)
    (told,) = chrome.execute_script(WISH, [[99, 0, 99, 99]])
    assert told["said"] == "toll_in_euros at most 0: time from 1.3 to at least 1.9."
    assert page.run("document.documentElement.scrollWidth") <= 390


def test_lines_stand_at_the_values_of_their_plans(make: Make, chrome: webdriver.Chrome) -> None:
    front, path = make("rover")
    page = Page(chrome, path, chosen="#plan=0", still=True)
    lines, axes, ticks = (
        page.run(f"[...document.querySelectorAll('.plot {part}')].map((path) => path.getAttribute('d'))")
        for part in (".line .stroke", ".barred + path", ".tick")
    )
    found = [values(front, name) for name in front.objectives]
    assert len(ticks) == sum(map(len, found))
    ends = [[float(part) for part in re.split("[MV ]", axis)[1:]] for axis in axes]
    drawn: dict[int, Any] = dict(zip(page.run(ORDER), lines, strict=True))
    for i, plan in enumerate(front):
        points = [[float(part) for part in point.split()] for point in drawn[i][1:].split("L")]
        for (x, y), (at, low, high), value, one in zip(points, ends, plan.objectives.values(), found, strict=True):
            share = float((value - one[0]) / (one[-1] - one[0]))
            assert (x, y) == pytest.approx((at, low + share * (high - low)))


ORDER = "[...document.querySelectorAll('.line')].map((line) => Number(line.dataset.plan))"


def test_a_line_is_chosen_by_keyboard_and_pointer(make: Make, chrome: webdriver.Chrome) -> None:
    front, path = make("rover")
    page = Page(chrome, path, chosen="#plan=0", still=True)
    lines = page.points(len(front))
    assert len(page.all(".line[tabindex='0']")) == 1, "a single stop for Tab"
    page.browser.execute_script("document.querySelector('.line[tabindex=\"0\"]').focus()")
    page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ENTER)
    assert page.one("#plan").text == "Plan 2"
    assert page.run("document.activeElement.dataset.plan") == "2" and page.run(ORDER)[-1] == 2
    page.press(Keys.ARROW_LEFT)
    ActionChains(chrome).key_down(Keys.SHIFT).send_keys(Keys.ENTER).key_up(Keys.SHIFT).perform()
    assert page.one("#plan").text == "Plans 2 and 1"
    page.wait(lambda: [k for k, line in enumerate(lines) if line.get_attribute("aria-pressed") == "true"] == [1, 2])
    page.click(page.one(".line.second text"))
    assert page.one("#plan").text == "Plan 1"
    page.click(page.one("tr[data-plan='4'] .choose"))
    page.wait(lambda: page.run("document.querySelector('.line.first').dataset.plan") == "4")
    assert page.complaints() == []


@pytest.mark.parametrize(
    ("mud", "ranks", "words"),
    [
        (1, ["least time", None, "least energy"], "3 plans: time from 5 to 12; energy from 12 to 17. Lower is better."),
        (9, ["least time, energy"], "One plan is best in all: none has less time or energy."),
    ],
)
def test_of_two_costs_without_a_preference_none_is_called_preferred(
    mud: int, ranks: list[str | None], words: str, tmp_path: Path
) -> None:
    scenario = loads(YARD.replace("MUD", str(mud)))
    front = pareto_front(scenario.problem())
    found = page_data(scenario, front, {})
    assert [plan["rank"] for plan in found["plans"]] == ranks
    assert words in " ".join(write_page(scenario, front, {}, tmp_path).read_text().split())
