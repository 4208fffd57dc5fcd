"""`prefplan view`: the real command, shown in a real browser."""

from __future__ import annotations

import importlib.util
import re
import signal
import socket
import subprocess
import sys
import webbrowser
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from report_browser import SOFTWARE_GL, start_chrome
from scenario_texts import CUP, shipped, task_tables
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from experiments.commands.command_line import main
from experiments.commands.execution.view import front_with
from experiments.viewer import session
from prefplan.planner import Planner
from prefplan.scenario.decode import loads

PROGRAM = [sys.executable, "-c", "import sys; from experiments.commands.command_line import main; sys.exit(main())"]

TIMEOUT_S = 120.0
"""Longest wait for the browser."""


@pytest.fixture
def cup(tmp_path: Path) -> Path:
    path = tmp_path / "cup.toml"
    path.write_text(CUP)
    return path


@pytest.fixture
def server(cup: Path) -> Iterator[subprocess.Popen[str]]:
    command = [*PROGRAM, "view", str(cup), "--port", "0", "--no-open"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    yield process
    process.kill()
    process.communicate()


@pytest.fixture
def browser(chromium: tuple[str, str]) -> Iterator[webdriver.Chrome]:
    # Drawn coarsely, for less work.
    chrome = start_chrome(chromium, *SOFTWARE_GL, "--window-size=640,360", "--force-device-scale-factor=0.25")
    yield chrome
    chrome.quit()


def address_of(server: subprocess.Popen[str]) -> str:
    assert server.stdout is not None
    line = server.stdout.readline()
    found = re.fullmatch(r"cup: (http://127\.0\.0\.1:\d+/[\w-]{43}) \(Ctrl-C ends it\)\n", line)
    assert found, line
    return found[1]


def ended(server: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Press Ctrl-C, and return the exit status and what was printed since."""
    server.send_signal(signal.SIGINT)
    out, err = server.communicate(timeout=TIMEOUT_S)
    return server.returncode, out, err


def refuse(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["view", *arguments]) == 2
    out, err = capsys.readouterr()
    assert not out
    return err


@pytest.mark.slow
def test_a_user_steps_through_a_plan_chooses_it_from_the_front_meddles_and_presses_ctrl_c(
    server: subprocess.Popen[str], browser: webdriver.Chrome
) -> None:
    browser.get(address_of(server))

    def text(part: str) -> str:
        return browser.execute_script(f"return document.querySelector('.status {part}')?.textContent ?? ''")

    def until(happens: Callable[[], bool]) -> None:
        # An element that is redrawn after it was found is searched for again.
        WebDriverWait(browser, TIMEOUT_S, 0.1, [StaleElementReferenceException]).until(lambda _: happens())

    def click(label: str) -> None:
        until(lambda: clicked(label))

    def clicked(label: str) -> bool:
        buttons = [b for b in browser.find_elements(By.TAG_NAME, "button") if b.text == label]
        for button in buttons:
            browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
            button.click()
        return len(buttons) == 1

    def choose(label: str, value: str) -> None:
        for place in (f"//label[.='{label}']/following::input[1]", f"//*[@role='option'][.='{value}']"):
            until(lambda place=place: browser.find_elements(By.XPATH, place))  # type: ignore[misc]
            browser.execute_script("arguments[0].click()", browser.find_element(By.XPATH, place))

    until(lambda: text(".state") == "playing")
    # A slow browser may be too late to pause it.
    until(lambda: clicked("Pause") or text(".state") == "completed")
    click("Restart")
    until(lambda: text(".count").startswith("0 of 4 actions done") and text(".current") == "transit desk")
    assert browser.title == "cup - prefplan"
    icon = browser.find_element(By.CSS_SELECTOR, "link[rel=icon]").get_attribute("href") or ""
    assert icon.startswith("data:image/svg+xml;base64,")
    choose("Speed", "8")
    click("Step")
    until(lambda: text(".count").startswith("1 of 4") and text(".state") == "paused")
    assert text(".current") == "grasp cup"
    click("Restart")
    until(lambda: text(".count").startswith("0 of 4"))
    # While nothing moves: how soon a browser tells of a click depends on the machine.
    click("Knock over")
    click("Play")
    until(lambda: text(".state") == "completed")
    assert "fault knock:cup@1" in text("") and " again" in text("")
    click("0: cost 10, penalty 0")
    # The parts are read one after the other, and the count of a new run begins again.
    until(lambda: text(".state") == "completed" and "fault" not in text("") and text(".count").startswith("4 of 4"))
    thumb = browser.find_element(By.CSS_SELECTOR, "[role=slider]")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", thumb)
    # As slowly as a hand: a busy page hears of a movement only if it has seen that the thumb is held.
    ActionChains(browser).click_and_hold(thumb).pause(1).move_by_offset(-100, 0).pause(1).release().perform()
    # A drag is told in steps, each of which may be shown before the next: only where both come to rest counts.
    until(
        lambda: (
            text(".state") == "paused"
            and not text(".count").startswith("4 of 4")
            and abs(float(text(".count").split()[-2]) - float(thumb.get_attribute("aria-valuenow") or "nan")) < 0.1
        )
    )
    click("Restart")
    until(lambda: text(".count").startswith("0 of 4 actions done"))
    assert browser.find_element(By.TAG_NAME, "canvas").size["width"] > 200
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
    assert ended(server) == (0, "", "")


@pytest.mark.parametrize(("display", "options", "opened"), [(":0", [], 1), (":0", ["--no-open"], 0), ("", [], 0)])
def test_a_browser_is_opened_where_there_is_a_screen(
    display: str,
    options: list[str],
    opened: int,
    cup: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    addresses: list[str] = []
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    monkeypatch.setattr(session, "watch", lambda *what, ready, **how: ready("http://127.0.0.1:1"))
    assert main(["view", str(cup), *options]) == 0
    assert capsys.readouterr().out == "cup: http://127.0.0.1:1 (Ctrl-C ends it)\n"
    assert addresses == ["http://127.0.0.1:1"] * opened


def test_a_port_that_is_taken_is_reported(cup: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        told = refuse(capsys, str(cup), "--port", port, "--no-open")
    assert told == f"prefplan: --port {port}: it is in use; --port 0 takes any free port\n"


def test_without_its_libraries_it_names_the_command_that_installs_them(
    cup: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "mjviser" else find(name))
    told = refuse(capsys, str(cup))
    install = "pip install '.[sim,viewer]', in a clone of prefplan"
    assert told == f"prefplan: view needs the libraries viser and mjviser: {install}\n"


ERRANDS = """
[model]
kind = "grid"
size = [3, 3]
start = [1, 1]
cost = 1
[model.regions]
a = [1, 2, 1, 2]
b = [0, 0, 0, 0]
c = [2, 0, 2, 0]
""" + task_tables(a="F a", b="F b", c="F c", preference="")


def test_the_front_goes_with_the_plan_that_is_carried_out() -> None:
    planner = Planner(shipped("case_study_3").problem())
    preferred = planner.preferred()
    assert [plan.cost for plan in front_with(preferred, planner, max_cost=None)] == [34, 41]
    assert [plan.cost for plan in front_with(preferred, planner, max_cost=34)] == [34, 41]
    wishes = [f"[[preferences]]\nname = 'early_{i}'\nkind = 'weighted-sum'\nweights = {{ {i} = 1 }}" for i in "abc"]
    several = Planner(loads("\n".join([ERRANDS, *wishes])).problem())
    assert len(front_with(several.cheapest(), several, max_cost=None)) == len([*several.front()])
    product = 'kind = "expression"\nexpression = "tidy * tidy"\ncontract = "general"'
    boundless = Planner(loads(CUP.replace('kind = "order"', product)).problem())
    cheapest = boundless.cheapest()
    assert front_with(cheapest, boundless, max_cost=None) == [cheapest], "its whole front may be infinite"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cup.toml", "--port=65536"], "'--port': 65536 is not in the range 0<=x<=65535"),
        (["cup.toml", "--port=http"], "'--port': 'http' is not a valid integer"),
        (["case_study_1", "--no-open"], "only a manipulation model can be carried out"),
    ],
)
def test_bad_input_is_told_in_a_sentence(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert message in refuse(capsys, *arguments)
