"""Draw the picture of the page that explores words, as a browser shows it.

    python docs/make_explorer.py

needs Chromium, and playwright and Pillow (``pip install playwright pillow``). The page is that
of ``tissuec words --explore``; its sliders are moved as a reader would move them.
"""

import shutil
import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from tissuec.core.resources import library
from tissuec.scene.request import Request
from tissuec.view.explorer.page import document, render

PLACE = Path(__file__).resolve().parent / "figures" / "explorer.png"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SIZE = {"width": 1200, "height": 860}
COLOURS = 128  # of the picture, as many as its palette holds


def main() -> None:
    """Write the page, set a tissue by hand, and keep what is seen."""
    text = render(document(Request.file(library() / "fuzzy" / "soft_tissue.tis")))
    chromium = next(filter(None, map(shutil.which, BROWSERS)))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as engine:
        path = Path(folder) / "soft_tissue.html"
        path.write_text(text, encoding="utf-8")
        browser = engine.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE, color_scheme="light")
        page.goto(path.as_uri())
        page.get_by_label("Start from").select_option(label="scarred tube")
        page.get_by_role("group", name="words for hardness").get_by_text("soft").click()
        page.get_by_label("hedge of hardness").select_option(label="slightly")
        page.get_by_label("weight as a number").fill("0.37")
        page.get_by_label("weight as a number").press("Tab")
        page.evaluate("document.activeElement.blur()")
        page.wait_for_timeout(300)
        seen = page.screenshot()
        browser.close()
    picture = Image.open(BytesIO(seen)).convert("RGB").quantize(COLOURS)
    picture.save(PLACE, optimize=True)
    print(f"{PLACE}: {PLACE.stat().st_size / 1000:.0f} kB")


main()
