"""Photograph the page about the virtual sterilisation for the documentation.

    python docs/make_report.py

needs matplotlib, Chromium, and playwright and Pillow (``pip install playwright pillow``).
"""

import shutil
import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from tissuec.core.resources import library
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view.report.content import ReportContent
from tissuec.view.report.page import render

PICTURE = Path(__file__).resolve().parent / "figures" / "report.png"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZE = {"width": 1280, "height": 1290}
COLOURS = 200  # of a palette, which makes a small file
DRAWN = 1000  # until everything is drawn in software [ms]
MOMENT = 0.6  # of the run: the tube is cut and lifted


def main() -> None:
    """Run the scene, write its page, and take a picture of its head and motion."""
    with tempfile.TemporaryDirectory() as folder:
        request = Request.file(library() / "scenes" / "sterilisation.tis")
        compiled, _ = compile_request(request)
        result = simulate(
            compiled, Path(folder) / "run.vtkhdf", request=request, companion="inline"
        )
        page = Path(folder) / "run.html"
        with Trajectory.open(result.path) as trajectory:
            page.write_text(render(ReportContent(trajectory)), encoding="utf-8")
        picture = photograph(page)
    image = Image.open(BytesIO(picture)).convert("RGB").quantize(COLOURS)
    image.save(PICTURE, optimize=True)
    print(f"{PICTURE}: {PICTURE.stat().st_size} bytes")


def photograph(page: Path) -> bytes:
    """Return a picture of the upper part of a page, with its player at the moment."""
    with sync_playwright() as engine:
        browser = engine.chromium.launch(
            executable_path=next(filter(None, map(shutil.which, BROWSERS))), args=ARGUMENTS
        )
        tab = browser.new_page(viewport=SIZE)
        tab.goto(page.as_uri())
        tab.wait_for_timeout(DRAWN)
        slider = tab.frame_locator("#motion iframe").locator("#time")
        slider.evaluate(
            """(slider, part) => {
              slider.value = +slider.min + part * (slider.max - slider.min);
              slider.dispatchEvent(new Event("input", { bubbles: true }));
            }""",
            MOMENT,
        )
        tab.wait_for_timeout(DRAWN)
        picture = tab.screenshot()
        browser.close()
    return picture


if __name__ == "__main__":
    main()
