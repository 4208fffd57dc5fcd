"""Make the README's screenshots of reports in Chromium: a grid, and two videos side by side."""

from __future__ import annotations

import io
import shutil
import time
from pathlib import Path

from PIL import Image
from selenium import webdriver

from experiments.commands.command_line import main as prefplan

OUT = Path(__file__).parents[1]

REPORTS = Path("out", "readme")
"""Folder of the reports; their videos are not made again."""

WIDTH = 1280
"""Width of the page, pixels."""

SHOWN = 1000
"""Width of the stored picture, pixels."""

QUALITY = 82
"""Quality of the JPEG files: at most 200 kB each."""

PICTURES = (
    # name, scenario, chosen plans, first element shown, height from its top in pixels, simulated seconds
    ("report_grid", "case_study_1", "#plan=0&with=5", "header", 1420, 14.0),
    ("report_videos", "case_study_3", "#plan=0&with=1", "header", 1040, 10.0),
)


def main() -> None:
    """Make the reports and take the pictures."""
    browser = _chromium()
    try:
        for name, scenario, chosen, top, height, moment in PICTURES:
            folder = REPORTS / scenario
            prefplan(["report", scenario, "--out", str(folder), "--size", "960x540"])
            picture = _taken(browser, f"{(folder / 'index.html').resolve().as_uri()}{chosen}", top, height, moment)
            picture.thumbnail((SHOWN, height), Image.Resampling.LANCZOS)
            picture.convert("RGB").save(OUT / f"{name}.jpg", quality=QUALITY, optimize=True)
    finally:
        browser.quit()


def _chromium() -> webdriver.Chrome:
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"):
        options.add_argument(flag)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))


def _taken(browser: webdriver.Chrome, address: str, top: str, height: int, moment: float) -> Image.Image:
    """Return a picture of a page from the top of an element on, at a moment of what it plays."""
    size = {"width": WIDTH, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.get(address)
    browser.execute_script(
        "const scrub = document.getElementById('scrub'); scrub.value = arguments[0];"
        "scrub.dispatchEvent(new Event('input'));"
        "document.getElementById('transport').style.position = 'static';"
        "window.scrollTo(0, document.querySelector(arguments[1]).getBoundingClientRect().top + window.scrollY - 24);",
        moment,
        top,
    )
    time.sleep(2)  # until the videos have reached that moment
    return Image.open(io.BytesIO(browser.get_screenshot_as_png()))


if __name__ == "__main__":
    main()
