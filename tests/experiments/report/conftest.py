"""The browsers of all tests of reports: one for a process, and a second one where the 3-D scene is looked at."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from report_browser import SOFTWARE_GL, start_chrome
from selenium import webdriver


@pytest.fixture(scope="session")
def chrome(chromium: tuple[str, str]) -> Iterator[webdriver.Chrome]:
    """A browser without WebGL: with it, drawing the pages alone takes twice as much work."""
    browser = start_chrome(chromium, "--disable-3d-apis")
    yield browser
    browser.quit()


@pytest.fixture(scope="session")
def chrome_3d(chromium: tuple[str, str]) -> Iterator[webdriver.Chrome]:
    browser = start_chrome(chromium, *SOFTWARE_GL)
    yield browser
    browser.quit()
