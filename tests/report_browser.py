"""A report that is open in headless Chromium."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.ui import WebDriverWait

TIMEOUT_S = 120
"""Longest wait for the browser."""

SOFTWARE_GL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Flags for WebGL without a graphics card."""


def start_chrome(chromium: tuple[str, str], *flags: str) -> webdriver.Chrome:
    """Return a headless browser.

    Args:
        chromium: the paths of the browser and of its driver.
        flags: for the browser.
    """
    options = webdriver.ChromeOptions()
    options.binary_location, driver = chromium
    for flag in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", *flags):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))


class Page:
    """A report that is open."""

    def __init__(
        self,
        browser: webdriver.Chrome,
        path: Path,
        *,
        chosen: str = "",
        width: int = 1280,
        scheme: str = "light",
        still: bool = False,
    ) -> None:
        """Open it; where it is to be `still`, as for readers who want no motion, nothing plays by itself."""
        self.browser, self.still = browser, still
        self.resize(width)
        self.set_scheme(scheme)
        browser.get("about:blank")
        browser.get_log("browser")
        browser.get(path.as_uri() + chosen)

    def resize(self, width: int) -> None:
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def set_scheme(self, scheme: str) -> None:
        wanted = {"prefers-color-scheme": scheme, "prefers-reduced-motion": "reduce" if self.still else ""}
        media = {"features": [{"name": name, "value": value} for name, value in wanted.items()]}
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)

    def wait(self, happens: Callable[[], Any]) -> Any:
        return WebDriverWait(self.browser, TIMEOUT_S, 0.05).until(lambda _: happens())

    def all(self, selector: str) -> list[WebElement]:
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def one(self, selector: str) -> WebElement:
        (found,) = self.all(selector)
        return found

    def click(self, element: WebElement) -> None:
        self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
        element.click()

    def run(self, script: str) -> Any:
        return self.browser.execute_script(f"return {script}")

    def scrub(self, time: float) -> None:
        """Move the slider of the playback to a time, s."""
        slider = "document.getElementById('scrub')"
        self.run(f"({slider}.value = {time}, {slider}.dispatchEvent(new Event('input')))")

    def points(self, number: int) -> list[WebElement]:
        """Return the points, or lines, of the chart, in the order of the plans."""
        self.wait(lambda: len(self.all("#chart [data-plan]")) == number)
        return [self.one(f"#chart [data-plan='{i}']") for i in range(number)]

    def press(self, *keys: str) -> None:
        ActionChains(self.browser).send_keys(*keys).perform()

    def complaints(self) -> list[Any]:
        return [entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]
