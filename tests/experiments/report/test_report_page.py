"""Reports as a reader sees them, in headless Chromium."""

from __future__ import annotations

import base64
import io
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from report_browser import Page
from report_pages import ERRANDS, pictures_for_tests
from scenario_texts import task_tables
from selenium import webdriver
from selenium.webdriver.common.keys import Keys

from experiments.commands.command_line import main
from experiments.starters import starter
from sim.evidence.log import read_log
from sim.evidence.replay import RecordedWorld
from sim.rendering.cameras import Camera

CUPS = """# Two cups; the hand begins over the one that should be cleared away last.
[model]
kind = "manipulation"
start = "near"
costs = { transit = 3, grasp = 1, transport = 5, release = 1 }
[model.locations]
near = { at = [0.45, 0.10] }
far  = { at = [0.60, 0.10] }
tray = { at = [0.45, -0.25], capacity = 2, kind = "bin" }
[model.objects]
red = { start = "far" }
yellow = { start = "near" }
""" + task_tables(red_first="F red_tray", then_yellow="F yellow_tray")

POINTS = 22


def many() -> str:
    """Return a scenario whose front has many points: a longer path is relaxed for less."""
    steps = "\n".join(f'  {{ from = "home", to = "s{i}", cost = {i} }},' for i in range(POINTS))
    labels = "\n".join(f's{i} = ["p{i}"]' for i in range(POINTS))
    relax = "\n".join(f'  {{ assume = "goal", when = "p{i}", cost = {POINTS - 1 - i} }},' for i in range(POINTS))
    return f"""[model]
kind = "graph"
start = "home"
propositions = ["goal"]
transitions = [
{steps}
]
[model.labels]
{labels}
[[tasks]]
name = "reach"
formula = "F goal"
relax = [
{relax}
]
[preference]
kind = "weighted-sum"
over = "violation"
weights = {{ reach = 1 }}
"""


TOUR = f"""[model]
kind = "graph"
start = "stop0"
transitions = [
{"".join(f'  {{ from = "stop{i}", to = "stop{i + 1}", cost = 2 }},{chr(10)}' for i in range(11))}]
[model.labels]
stop11 = ["view"]
[[tasks]]
name = "look"
formula = "F view"
[preference]
kind = "order"
"""
"""A chain of twelve states."""

Make = Callable[[str, str], Path]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """Return a function that makes a report of a scenario, once."""
    made: dict[str, Path] = {}

    def once(name: str, text: str) -> Path:
        if name not in made:
            folder = tmp_path_factory.mktemp(name)
            (folder / f"{name}.toml").write_text(text)
            with pictures_for_tests():
                main(["report", str(folder / f"{name}.toml"), "--out", str(folder / "out"), "--size", "160x90"])
            made[name] = folder / "out" / "index.html"
        return made[name]

    return once


def here(page: Page, panel: str, task: str) -> str:
    """Return the class of the automaton's node that is lit."""
    return page.one(f"{panel} .task[data-task={task}] .node.here").get_attribute("class") or ""


def test_every_point_of_a_grid_shows_its_plan(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("errands", ERRANDS))
    wanted = [
        ("Cost 7, penalty 5", "No plan costs less.", "7 moves"),
        (
            "Cost 8, penalty 0",
            "1 more than the cheapest: it goes first to bank instead of post, so that",
            "8 moves",
        ),
    ]
    for i in (1, 0):
        page.click(page.points(2)[i])
        page.wait(lambda i=i: page.one("#plan").text == f"Plan {i}")  # type: ignore[misc]
        title, headline, moves = wanted[i]
        assert title in page.one(".view h3").text
        assert page.one(".view .headline").text.startswith(headline)
        assert moves in (page.one(".panel .map").get_attribute("aria-label") or "")
        assert len(page.all(".panel .bar")) == int(moves[0])
        assert page.one(f"#points tr[data-plan='{i}'] .choose").get_attribute("aria-pressed") == "true"
        assert page.one(".panel .certificate summary").text.startswith("Certified: ")
        assert [lane.get_attribute("data-task") for lane in page.all(".panel .lane")] == ["pay", "send"]
    assert page.complaints() == []


def test_the_path_and_the_automata_go_along(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("errands", ERRANDS), chosen="#plan=0")
    page.click(page.points(2)[1])
    page.wait(lambda: page.one("#plan").text == "Plan 1")
    begin = page.run("document.querySelector('.robot').getAttribute('cx')")
    assert "accepting" not in here(page, ".panel", "pay")
    page.click(page.one("#play"))
    page.wait(lambda: page.one(".panel [data-task=pay] .status").text.startswith("done"))
    assert page.run("document.querySelector('.robot').getAttribute('cx')") != begin
    page.wait(lambda: page.one("#play").text == "Play")
    assert "accepting" in here(page, ".panel", "pay") and "accepting" in here(page, ".panel", "send")
    assert page.one(".caption").text == "the end · spent 8 of 8"
    assert page.one("#time").text == "2.0 s of 2.0 s"
    page.scrub(0.1)
    assert page.one(".panel [data-task=pay] .status").text == "open · state 0"
    assert page.complaints() == []


def test_everything_can_be_done_by_keyboard(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("errands", ERRANDS), chosen="#plan=0")
    point = page.points(2)[1]
    page.browser.execute_script("arguments[0].focus()", point)
    page.press(Keys.ENTER)
    page.wait(lambda: page.one("#plan").text == "Plan 1")
    page.browser.execute_script("document.activeElement.blur()")
    page.press(Keys.ARROW_RIGHT)
    assert page.one(".caption").text.startswith("2 of 8: ")
    page.press(Keys.ARROW_LEFT)
    assert page.one(".caption").text.startswith("1 of 8: ")
    # So slowly that on no machine the end comes between the two keys.
    page.run("[document.querySelector('#speed option:checked')].forEach((option) => { option.value = '0.001'; })")
    page.run("document.querySelector('#speed').dispatchEvent(new Event('change'))")
    page.press(Keys.SPACE)
    assert page.one("#play").text == "Pause"
    page.press(Keys.SPACE)
    assert page.one("#play").text == "Play"
    page.browser.execute_script("document.querySelector('.bar').focus()")
    page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert page.run("document.activeElement.dataset.action") == "2"
    assert page.one(".caption").text.startswith("3 of 8: ")
    button = page.one("tr[data-plan='0'] .compare")
    page.browser.execute_script("arguments[0].focus()", button)
    page.press(Keys.ENTER)
    assert page.one("#plan").text == "Plans 1 and 0"
    assert page.complaints() == []


def test_the_present_state_of_a_graph_goes_along(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("town", starter("graph", file="town.toml")), chosen="#plan=1")
    plan = page.run("JSON.parse(document.getElementById('data').textContent).plans[1]")
    shown = []
    for k in range(len(plan["plan"]) + 1):
        page.scrub(k + 0.01)
        shown.append(page.one(".graph .node.here").get_attribute("class"))
    assert shown == [f"node plain s{node} here" for node in plan["graph"]["at"]] and len(set(shown)) > 2
    assert page.complaints() == []


def test_a_graph_of_many_states_is_seen_without_scrolling_sideways(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("tour", TOUR), width=390)
    box, svg = "document.querySelector('.graph')", "document.querySelector('.graph svg')"
    for width in (390, 1280):
        page.resize(width)
        assert page.run(f"{box}.scrollWidth - {box}.clientWidth") == 0
        assert page.run(f"{svg}.getBoundingClientRect().width / {svg}.getAttribute('width')") > 0.69, "legible"
    assert page.complaints() == []


def test_the_first_screen_plays_a_grid_in_whole(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("yard", ERRANDS.replace("size = [4, 3]", "size = [4, 4]")))
    page.wait(lambda: page.all(".caption")[1].text.startswith("the end"))
    bottoms = page.run("[...document.querySelectorAll('.map')].map((map) => map.getBoundingClientRect().bottom)")
    assert len(bottoms) == 2 and max(bottoms) < page.run("document.getElementById('transport').offsetTop")
    assert page.complaints() == []


@pytest.mark.slow
def test_the_first_screen_plays_the_cheapest_and_the_preferred_plan(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("cups", CUPS))
    page.wait(lambda: page.one("#play").text == "Pause")
    assert page.one("#trade-off").text.startswith("The preferred plan costs ")
    assert [title.text.split()[0] for title in page.all(".view h3")] == ["0", "1"]
    bottoms = page.run("[...document.querySelectorAll('video')].map((video) => video.getBoundingClientRect().bottom)")
    assert len(bottoms) == 2 and max(bottoms) < page.run("document.getElementById('transport').offsetTop")
    assert page.complaints() == []


@pytest.mark.slow
def test_videos_play_and_two_of_them_in_step(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("cups", CUPS), chosen="#plan=0")
    for i in (0, 1):
        page.click(page.points(2)[i])
        page.wait(lambda i=i: page.one("#plan").text == f"Plan {i}")  # type: ignore[misc]
        page.wait(lambda: page.run("document.querySelector('.panel video').readyState") >= 2)
        assert f"plan_{i}.mp4" in (page.one(".panel video").get_attribute("src") or "")
        assert "checks of the run’s log hold" in page.one(".panel .certificate summary").text
    page.click(page.one("tr[data-plan='0'] .compare"))
    assert len(page.all(".panel video")) == 2
    assert page.one("#parting").text == (
        "They differ from the first action: plan 1 does transit far, and plan 0 does grasp yellow. Go there"
    )
    assert page.one("#parting-mark").is_displayed() and len(page.all(".part-line")) == 2
    page.click(page.one("#play"))
    times = "[...document.querySelectorAll('video')].map((video) => video.currentTime)"
    # The clock brings a video that lags behind back into step.
    in_step = "Math.min(...times) > 1 && Math.max(...times) - Math.min(...times) < 0.5"
    page.wait(lambda: page.run(f"((times) => {in_step})({times})") and page.one("#play").text == "Pause")
    page.click(page.one("#play"))
    page.wait(lambda: page.run("[...document.querySelectorAll('video')].every((video) => video.paused)"))
    page.click(page.all(".panel.first .bar")[5])
    starts = page.run("JSON.parse(document.getElementById('data').textContent).plans[1].times[5][0]")
    # Pictures last a thirtieth of a second; what is shown begins no sooner than the action.
    page.wait(lambda: starts < page.run(times)[0] - 1 / 60 + 1e-3 < starts + 1 / 30 + 2e-3)
    page.scrub(1e9)
    for panel in (".panel.first", ".panel.second"):
        assert "accepting" in here(page, panel, "red_first") and "accepting" in here(page, panel, "then_yellow")
    duration = page.run("Number(document.getElementById('scrub').max)")
    page.wait(lambda: max(page.run(times)) > duration + 1 / 60 - 1e-3)
    assert page.complaints() == []


def pictures(page: Page, time_shown: float) -> list[np.ndarray]:
    """Return what the panels' 3-D scenes show at a time, each (height, width, 3) int."""
    page.scrub(time_shown)
    page.wait(lambda: times_drawn(page) == [pytest.approx(time_shown, abs=1e-3)] * 2)
    links = page.run("[...document.querySelectorAll('canvas.scene')].map((canvas) => canvas.toDataURL())")
    images = [Image.open(io.BytesIO(base64.b64decode(link.partition(",")[2]))) for link in links]
    return [np.asarray(image.convert("RGB")).astype(int) for image in images]


def times_drawn(page: Page) -> list[float]:
    return [float(scene.get_attribute("data-time") or "nan") for scene in page.all("canvas.scene")]


@pytest.mark.slow
def test_two_plans_in_step_are_seen_in_3d_as_their_logs_say(make: Make, chrome_3d: webdriver.Chrome) -> None:
    path = make("cups", CUPS)
    page = Page(chrome_3d, path, chosen="#plan=0&with=1")
    library = "[...document.scripts].filter((script) => /three|scene_data/.test(script.src)).length"
    assert page.run(library) == 0 and not page.all("canvas.scene")[0].is_displayed()
    page.click(page.one("#in-3d"))
    page.wait(lambda: times_drawn(page) == [0, 0])
    assert page.run(library) == 2 and not page.all(".panel video")[0].is_displayed()
    logs = [read_log(path.with_name(f"plan_{i}.npz")) for i in (0, 1)]
    worlds = [RecordedWorld(log) for log in logs]
    ends = [action.end for action in logs[0].about.actions]
    for time_shown in (0.0, ends[3], ends[-1]):
        for world, picture in zip(worlds, pictures(page, time_shown), strict=True):
            camera = Camera(world.scene, "fixed", picture.shape[1::-1])
            for obj, channel in (("red", 2), ("yellow", 0)):  # a blue cube and a pink one
                path_seen = camera.pixels(world.path(obj)[[0, world.frame_at(time_shown)]])
                was, now = (picture[y, x] for x, y in path_seen.round().astype(int))
                assert now.argmax() == channel and np.ptp(now) > 90, (time_shown, obj, now)
                moved = np.linalg.norm(path_seen[1] - path_seen[0]) > 30
                assert moved == (np.abs(was - now).max() > 30), (time_shown, obj, was, now)
    page.browser.execute_script("document.querySelector('.first canvas').focus()")
    before = pictures(page, 1.0)
    page.press(Keys.ARROW_LEFT, "-")
    page.wait(lambda: (pictures(page, 1.0)[1] != before[1]).mean() > 0.2)
    page.press(Keys.HOME)
    page.wait(lambda: np.array_equal(pictures(page, 1.0), before))
    page.press(Keys.SPACE)
    page.wait(lambda: times_drawn(page)[0] > 1.2)
    page.press(Keys.SPACE)
    page.wait(lambda: page.one("#play").text == "Play" and len(set(times_drawn(page))) == 1)
    assert page.complaints() == []


@pytest.fixture(scope="module")
def without_videos(make: Make, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of runs that have no video."""
    folder = tmp_path_factory.mktemp("without_videos") / "out"
    shutil.copytree(make("cups", CUPS).parent, folder)
    path = folder / "index.html"
    path.write_text(re.sub(r'"video": "plan_\d.mp4"', '"video": null', path.read_text(encoding="utf-8")))
    return path


@pytest.mark.slow
def test_without_videos_the_scenes_play(without_videos: Path, chrome_3d: webdriver.Chrome) -> None:
    page = Page(chrome_3d, without_videos, width=390)
    page.run(
        "(document.getElementById('speed').value = 4, "
        "document.getElementById('speed').dispatchEvent(new Event('change')))"
    )
    page.wait(lambda: len(times_drawn(page)) == 2 and min(times_drawn(page)) > 0)
    page.click(page.one("#play"))
    page.wait(lambda: page.one("#play").text == "Play" and len(set(times_drawn(page))) == 1)
    assert min(times_drawn(page)) > 0
    assert not page.all("#in-3d") and not page.all("video")
    assert page.run("document.documentElement.scrollWidth") <= 390
    assert page.all("canvas.scene")[0].is_displayed() and not page.all(".scene-note")[0].is_displayed()
    assert page.complaints() == []


@pytest.mark.slow
def test_without_videos_and_webgl_a_sentence_says_so(without_videos: Path, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, without_videos)
    sentence = "No 3-D scene: this browser has no WebGL, or it is switched off."
    page.wait(lambda: [note.text for note in page.all(".scene-note")] == [sentence] * 2)
    assert page.one("#play").text == "Play", "there is nothing to see"
    page.scrub(1.0)
    assert page.all(".caption")[0].text.startswith("1 of ")
    assert page.complaints() == []


def test_the_state_of_an_automaton_too_wide_for_its_place_is_in_sight(make: Make, chrome: webdriver.Chrome) -> None:
    rounds = "F (bank & F (post & F (bank & F (post & F bank))))"
    page = Page(chrome, make("rounds", ERRANDS.replace("F bank", rounds)), width=390)
    page.points(1)
    box = "document.querySelector('.task[data-task=pay] .automaton')"
    assert page.run(f"{box}.scrollWidth > {box}.clientWidth && {box}.scrollLeft === 0")
    page.scrub(1e9)
    assert "accepting" in here(page, ".panel", "pay")
    assert page.run(
        f"{box}.querySelector('.node.here').getBoundingClientRect().right <= {box}.getBoundingClientRect().right"
    )
    assert page.complaints() == []


@pytest.mark.slow
def test_many_points_are_still_told_apart(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("many", many()), chosen="#plan=0")
    points = page.points(POINTS)
    page.click(points[17])
    page.wait(lambda: page.one("#plan").text == "Plan 17")
    assert page.all(".view .headline")[0].text == (
        "1 more than plan 16: it does s17 instead of s16 so that reach is relaxed for 4 instead of relaxed for 5."
    )
    assert [number.text for number in page.all("#chart .number") if number.is_displayed()] == ["17"]
    row, box = "document.querySelector('#points [data-plan=\"17\"]')", "document.querySelector('.points .scroll')"
    edges = [f"{one}.getBoundingClientRect().{edge}" for one in (row, box) for edge in ("top", "bottom")]
    top, bottom, first, last = map(page.run, edges)
    assert first < top < bottom <= last, "the table shows its row"
    assert page.complaints() == []


def test_a_page_without_a_plan_says_so(make: Make, chrome: webdriver.Chrome) -> None:
    page = Page(chrome, make("never", ERRANDS.replace("F post", "F (post & bank)")))
    assert page.one("#reason").text == "task send can never be satisfied"
    time.sleep(0.2)
    assert page.complaints() == []
