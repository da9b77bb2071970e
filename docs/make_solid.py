"""Draw a solid in pascals: liver under a punch, cut open, in the colours of its stress.

    python docs/make_solid.py

needs the extra plot (``pip install "tissuec[plot]"``).
"""

from pathlib import Path

import tissuec
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.node_values import chosen_field
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.section import read_plane

FIGURE = Path(__file__).resolve().parent / "figures" / "solid.png"
SIZE = (760, 420)
OPTIONS = Options(view=(-62.0, 24.0), section=read_plane("y = 15.1 mm"), field="stress")
SCENE = """language 1
tissue liver { Young's modulus = 6 kPa; Poisson's ratio = 0.45; density = 1060 kg/m^3 }
body block {
  mesh is lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (40, 30, 20) mm }
  tissue is liver
}
set base = nodes of block where z == 0 mm
set punch = nodes of block where z == 20 mm and (x - 20 mm)^2 + (y - 15 mm)^2 < (6 mm)^2
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix base; from 0 s to 1 s: move punch by (0, 0, -4) mm using constant speed }
simulate { duration = 1 s; integrator is equilibrium; step = 0.25 s }
output { trajectory every 0.25 s }
"""


def main() -> None:
    """Run the scene, and draw its end."""
    run = tissuec.run(SCENE, companion="off")
    film = read_film(run, OPTIONS)
    field = chosen_field(DrawnNodes(film, run), OPTIONS)
    painter = Painter(film, OPTIONS, SIZE, "liver under a punch", field=field)
    figure = painter.draw(float(len(film.times) - 1))
    figure.savefig(FIGURE, format="png", metadata={"Software": "tissuec"})
    print(FIGURE)


if __name__ == "__main__":
    main()
