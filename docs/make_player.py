"""Draw the picture of the player, as a browser shows it, and an animation without a browser.

    python docs/make_player.py

needs Chromium, playwright, and the extra plot (``pip install playwright "tissuec[plot]"``).
Both are of the shipped sterilisation.
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
from tissuec.view.player.files import write_gif
from tissuec.view.player.options import Options
from tissuec.view.player.page import render
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film

FIGURES = Path(__file__).resolve().parent / "figures"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SOFTWARE = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SIZE = {"width": 1180, "height": 760}
MOMENT = 0.735  # [s], shortly after the cut


def main() -> None:
    """Run the scene, and draw both."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        request = Request.file(library() / "scenes" / "sterilisation.tis")
        compiled, _ = compile_request(request)
        result = simulate(compiled, folder / "sterilisation.vtkhdf", request=request).path
        with Trajectory.open(result) as trajectory:
            (folder / "page.html").write_text(render(trajectory), encoding="utf-8")
            picture = Image.open(BytesIO(seen(folder / "page.html"))).convert("RGB")
            save(picture.quantize(256, kmeans=2))
            film = read_film(trajectory, Options())
    painter = Painter(film, Options(), (480, 240), "sterilisation")
    write_gif(painter, FIGURES / "sterilisation.gif", None, lambda number, count: None)
    print(f"{FIGURES / 'sterilisation.gif'}")


def seen(page: Path) -> bytes:
    """Return what a browser shows of the page after the cut."""
    chromium = next(filter(None, map(shutil.which, BROWSERS)))
    with sync_playwright() as engine:
        browser = engine.chromium.launch(executable_path=chromium, args=list(SOFTWARE))
        tab = browser.new_page(viewport=SIZE, color_scheme="light")
        tab.goto(page.as_uri())
        tab.evaluate("tissuec.ready")
        tab.evaluate(f"tissuec.seek({MOMENT})")
        tab.evaluate("tissuec.set('forces', true)")
        tab.wait_for_timeout(500)
        shot = tab.screenshot()
        browser.close()
    return shot


def save(picture: Image.Image) -> None:
    """Keep a picture."""
    path = FIGURES / "player.png"
    picture.save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


main()
