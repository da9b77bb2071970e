"""Draw a body that is cut open: the indentation of the library.

    python docs/make_section.py

needs the extra plot (``pip install "tissuec[plot]"``).
"""

import tempfile
from pathlib import Path

from tissuec.core.resources import library
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.section import read_plane

FIGURE = Path(__file__).resolve().parent / "figures" / "section.png"
SIZE = (760, 420)
MOMENT = 0.4  # [s], while the finger rests
OPTIONS = Options(view=(-68.0, 22.0), section=read_plane("y = 15.1 mm"))


def main() -> None:
    """Run the scene, and draw it."""
    with tempfile.TemporaryDirectory() as name:
        request = Request.file(library() / "scenes" / "indentation.tis")
        compiled, _ = compile_request(request)
        place = Path(name) / "indentation.vtkhdf"
        simulate(compiled, place, request=request, companion="off")
        with Trajectory.open(place) as trajectory:
            film = read_film(trajectory, OPTIONS)
            at = float(abs(film.times - MOMENT).argmin())
            figure = Painter(film, OPTIONS, SIZE, "indentation").draw(at)
    figure.savefig(FIGURE, format="png", metadata={"Software": "tissuec"})
    print(FIGURE)


if __name__ == "__main__":
    main()
