"""Frames in section: regions as filled polygons, outlines, axes, areas, and wrong requests."""

from typing import Any

import numpy as np
import pytest

import tissuec
from tissuec.core.errors import TissueError
from tissuec.view.plots import draw

pytest.importorskip("matplotlib", reason="needs the extra plot")
BLOCK = """language 1
use "tissues/fat"
tissue lump like fat { colour = "#2040c0" }
body sample {
  mesh is lattice {
    box from (0, 0, 0) mm to (20, 20, 10) mm; cell = 2.5 mm
    kind is sodium chloride; reach is second neighbours
  }
  tissue is fat; interface is mean
  region core where within 3 mm of (10, 10, 5) mm { tissue is lump }
}
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 1 ms; integrator is velocity verlet; step = 2 us }
output { trajectory every 1 ms }
"""
PIPE = """language 1
use "tissues/fat"
body pipe {
  mesh is tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 4 mm; rings = 4; sides = 8 }
  tissue is fat
}
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    path = tmp_path_factory.mktemp("block") / "block.vtkhdf"
    tissuec.run(BLOCK, out=path, companion="off").close()
    return path


def shapes(axes, kind):
    return [one for one in axes.collections if type(one).__name__ == kind]


def area(polygons):
    x, y = np.moveaxis(np.array([path.vertices[:3] for path in polygons.get_paths()]), 2, 0)
    return np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)) / 2.0


def test_regions_are_polygons_in_the_colours_of_their_tissues(block):
    figure: Any = draw("frames", block, section="z = 5.3 mm", times=(0.0,))
    (axes,) = figure.axes
    (polygons,) = shapes(axes, "PolyCollection")
    sizes, blue = area(polygons), polygons.get_facecolor()[:, 2] > 0.6
    assert sizes.sum() == pytest.approx(400.0)
    assert sizes[blue].sum() == pytest.approx(25.0, rel=0.4)  # five nodes of 2.5 mm
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [mm]", "y [mm]")
    assert {text.get_text() for text in figure.legends[0].get_texts()} == {"fat", "lump"}
    (told,) = figure.numbers["areas_mm2"].values()
    assert told["lump"] == pytest.approx(sizes[blue].sum())


@pytest.mark.parametrize(
    ("plane", "labels", "size"),
    [
        ("y = 9 mm", ("x [mm]", "z [mm]"), 200.0),
        ("through (10, 10, 5) mm facing (1, 1, 0)",
         ("along (0.71, −0.71, 0) [mm]", "z [mm]"), 200.0 * 2**0.5),
    ],
)  # fmt: skip
def test_axes_name_the_directions_in_the_plane(block, plane, labels, size):
    figure: Any = draw("frames", block, section=plane, times=(0.0,))
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == labels
    assert area(shapes(axes, "PolyCollection")[0]).sum() == pytest.approx(size)


def test_hollow_bodies_have_an_outline(tmp_path):
    tissuec.run(PIPE, out=tmp_path / "pipe.vtkhdf", companion="off").close()
    figure: Any = draw("frames", tmp_path / "pipe.vtkhdf", section="x = 3 mm", times=(0.0,))
    (lines,) = shapes(figure.axes[0], "LineCollection")
    ends = np.array([path.vertices for path in lines.get_paths()])
    length = np.linalg.norm(np.diff(ends, axis=1), axis=2).sum()
    assert length == pytest.approx(8 * 2 * 4.0 * np.sin(np.pi / 8))
    assert any("pipe is not filled" in note for note in figure.notes)


def test_wrong_requests_are_answered(block):
    with pytest.raises(TissueError, match=r"z = 60 mm meets nothing .* 0 to 10 mm in z"):
        draw("frames", block, section="z = 60 mm")
    with pytest.raises(TissueError, match="omit --from"):
        draw("frames", block, section="z = 5 mm", view=(-90.0, 0.0))
    with pytest.raises(TissueError, match="omit --show"):
        draw("frames", block, section="z = 5 mm", show="skin")
