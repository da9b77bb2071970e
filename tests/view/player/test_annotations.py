"""Labels keep clear of each other and within the picture; pages place them as Python does."""

import re

import numpy as np
import pytest
from msgspec.structs import asdict

from tests.view.player.conftest import Show, grid
from tests.view.player.test_labels import evaluated
from tissuec.core.structs import replace
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.annotations import EDGE, Placing
from tissuec.view.player.fields import DERIVED
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.options import Options
from tissuec.view.player.page import WEB, render
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.player.rules import RULES, shader_rules
from tissuec.view.section import read_plane
from tissuec.view.section.cross_section import check_reach
from tissuec.view.section.plane import SectionPlane

PLACES = """
const placing = new Placing(given.size[0], given.size[1], given.taken);
return given.labels.map(([point, room, isRight]) => placing.beside(point, room, isRight, 6));
"""


def boxes(figure):
    """Return the texts of a figure and where they stand, by pairs."""
    figure.canvas.draw()
    texts = [text for text in figure.axes[0].texts if text.get_text()]
    return [(text.get_text(), text.get_window_extent()) for text in texts]


@pytest.mark.parametrize("size", [(390, 300), (640, 360)])
def test_labels_stand_clear_of_each_other_and_of_scales(sterilisation, size):
    pytest.importorskip("matplotlib", reason="needs the extra plot")
    options = Options(colour="tension")
    with Trajectory.open(sterilisation) as trajectory:
        film = read_film(trajectory, options)
    values = np.linspace(-3.0, 5.0, film.node_count) + np.zeros((len(film.times), 1))
    field = FieldValues.of(DERIVED[0], values).ranged((-0.6, 1.2))
    painter = Painter(film, options, size, "sterilisation", forces=True, field=field)
    found = boxes(painter.draw(film.moment_at(0.65)))
    assert {"largest: 5 m", "smallest: −3 m"} <= {text for text, _ in found}
    for k, (text, box) in enumerate(found):
        assert box.x0 >= 0.0 and box.x1 <= size[0], text
        assert box.y0 >= 0.0 and box.y1 <= size[1], text
        for other, one in found[:k]:
            wide = min(box.x1, one.x1) - max(box.x0, one.x0)
            high = min(box.y1, one.y1) - max(box.y0, one.y0)
            assert wide <= 0.0 or high <= 1.0, (text, other)  # lines of a legend touch


def test_pages_place_labels_as_pictures_do():
    rng = np.random.default_rng(5)
    size, room = (300.0, 200.0), (50.0, 15.0)
    taken = [(0.0, 0.0, 80.0, 30.0), (200.0, 150.0, 300.0, 200.0)]
    points = rng.uniform((0.0, 0.0), size, (12, 2)).tolist()
    placing = Placing(size)
    for box in taken:
        placing.take(box)
    own = [placing.beside((x, y), room, right=k % 2 == 0, gap=6.0)
           for k, (x, y) in enumerate(points)]  # fmt: skip
    flipped = [(left, 200.0 - top, right, 200.0 - low) for left, low, right, top in taken]
    labels = [[[x, 200.0 - y], room, k % 2 == 0] for k, (x, y) in enumerate(points)]
    given = {"size": size, "taken": flipped, "labels": labels}
    found = evaluated(PLACES, given, scripts=("placing.js",))
    np.testing.assert_allclose(
        [(left, 200.0 - middle - 7.5) for left, middle in found], own, atol=1e-9
    )
    placed = placing.taken[2:]
    for k, (left, low, right, top) in enumerate(placed):
        assert left >= EDGE and low >= EDGE and right <= 300.0 - EDGE and top <= 200.0 - EDGE
        for a, b, c, d in [*taken, *placed[:k]]:
            assert min(right, c) - max(left, a) <= 1e-9 or min(top, d) - max(low, b) <= 1e-9


def test_rounding_errors_are_not_read_out(shown):
    values = np.tile([-0.3, 0.3, -0.29, 0.1 + 0.2], (1, 5))
    field = replace(FieldValues.of(DERIVED[0], values), low=-0.3, high=0.1 + 0.2)
    assert 0.5 * (field.low + field.high) not in (0.0, -0.0)
    film = read_film(shown(Show(grid(4, 5), frames=1)), Options())
    texts = [text for text, _ in boxes(Painter(film, Options(), SIZE, "", field=field).draw(0))]
    assert {"−300", "0", "300"} <= set(texts)
    aslant = SectionPlane((6e-17, 0.6, 0.8), 7e-3)
    assert aslant.text == "through (0, 4.2, 5.6) mm facing (0, 0.6, 0.8)"
    position = np.array([[0.0, 0.0, 3e-18], [0.0, 0.0, 0.02]])
    with pytest.raises(Exception, match=r"extend from 0 to 20 mm in z"):
        check_reach(position, read_plane("z = 6 cm"), "at 0 ms")


SIZE = (400, 300)


def test_the_range_of_a_field_is_found_once(shown, monkeypatch):
    found, own = [], FieldValues.of

    def counted(field, value):
        found.append(field.name)
        return own(field, value)

    monkeypatch.setattr(FieldValues, "of", counted)
    render(shown(Show(grid(4, 5))), Options(field="strain", range=(0.0, 0.1)))
    assert sorted(found) == sorted(set(found)) and "strain" in found


def test_rules_reach_scripts_and_shaders_and_are_used_there(shown):
    text = render(shown(Show(grid(3, 3), frames=2)))
    assert text.count(shader_rules().splitlines()[-1]) == 2  # for corners and for fragments
    scripts = "".join(path.read_text(encoding="utf-8") for path in WEB.glob("*.js"))
    shaders = "".join(path.read_text(encoding="utf-8") for path in WEB.glob("*.glsl"))
    for name in asdict(RULES):
        by_script = re.search(rf"\brules\.{name}\b", scripts)
        assert by_script or re.search(rf"\b{name.upper()}\b", shaders), name
