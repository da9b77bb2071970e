"""Organs have the colours of their tissues, and are round without being asked to."""

import re
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import tissuec
from tissuec.core import palette
from tissuec.core.resources import library
from tissuec.core.structs import replace
from tissuec.view.player.bodies import bulges, rounded, smooth_mesh, spread
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.player.rules import rgb
from tissuec.view.player.tints import node_tints

pytest.importorskip("matplotlib", reason="needs the extra plot")

SHEET = """language 1
use "tissues/TISSUE"
body sheet {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 4; rows = 4; diagonals is both
  }
  tissue is NAME
}
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 10 ms }
output { trajectory every 10 ms }
"""
BLOCK = """language 1
use "tissues/fat"
use "tissues/skin"
body sample {
  mesh is lattice {
    box from (0, 0, 0) mm to (20, 20, 10) mm; cell = 5 mm
    kind is sodium chloride; reach is second neighbours
  }
  tissue is fat; interface is softer
  region cover where z > 7 mm { tissue is skin }
}
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
SEAM = """language 1
use "tissues/skin"
body left {
  SHEET { corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 3; rows = 3; diagonals is both }
}
body right {
  SHEET { corner = (14, 0, 0) mm; first edge = (10, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 3; rows = 3; diagonals is both }
}
set hole = nodes of left where x > 9 mm and y < 1 mm
set other = nodes of right where x < 15 mm and y < 1 mm
joint seam { springs from hole to other; reach = 5 mm; tissue is skin }
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""


def lab(colour):
    """Return CIE L*a*b* (D65) of sRGB colours from 0 to 1, shape (…, 3)."""
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    part = linear @ np.transpose(to_xyz) / [0.9505, 1.0, 1.089]
    f = np.where(part > 0.008856, np.cbrt(part), 7.787 * part + 16.0 / 116.0)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def presets(folder):
    """Yield the name and the colour of each preset of a folder of the library."""
    for path in sorted((library() / folder).glob("*.tis")):
        for name, body in re.findall(
            r"^tissue ([^{]+?)(?: like [^{]+)? \{(.*?)^\}", path.read_text(), re.M | re.S
        ):
            found = re.search(r'colour = "(#[0-9a-f]{6})"', body)
            yield path.stem, name, found and found[1]


def test_every_preset_has_a_colour_or_that_of_its_parent():
    without = {name for folder in ("tissues", "matter")
               for _, name, colour in presets(folder) if colour is None}  # fmt: skip
    assert without == {"fascia lata", "tense muscle"}


def test_tissues_of_one_file_can_be_told_apart():
    for folder in ("tissues", "matter"):
        found = [(file, name, colour) for file, name, colour in presets(folder) if colour]
        for (file, a, first), (other, b, second) in combinations(found, 2):
            if file == other:
                distance = np.linalg.norm(lab(rgb(first)) - lab(rgb(second)))
                assert distance > 12.0, (a, b, distance)


@pytest.mark.parametrize("file", ["liver", "fat", "gallbladder", "skin", "muscle"])
def test_a_still_shows_the_colour_of_the_tissue(file):
    colours = {name: colour for stem, name, colour in presets("tissues") if stem == file}
    name = next(iter(colours))
    scene = SHEET.replace("TISSUE", file).replace("NAME", name)
    film = read_film(tissuec.run(scene, companion="off"), Options())
    pixels = Painter(film, Options(view=(-90.0, 90.0)), (120, 80), "").pixels(0.0) / 255.0
    inside = pixels[30:50, 50:70].reshape(-1, 3).mean(axis=0)
    # The light of the page is a little below that of paper.
    assert np.linalg.norm(lab(inside) - lab(np.array(rgb(colours[name])))) < 10.0


def test_regions_have_the_colours_of_their_tissues():
    result = tissuec.run(BLOCK, companion="off")
    tints = node_tints(result)
    cover = result.nodes_of("cover of sample")
    fat, skin = ({name: c for _, name, c in presets("matter")}[one] for one in ("fat", "skin"))
    assert np.allclose(tints[cover, :3], rgb(skin))
    assert np.allclose(np.delete(tints, cover, axis=0)[:, :3], rgb(fat))


def test_stitches_are_threads_while_springs_are_hidden():
    scene = SEAM.replace("SHEET", "tissue is skin; mesh is sheet")
    film = read_film(tissuec.run(scene, companion="off"), Options())
    lines = film.lines
    assert lines.stitch.sum() == 1 and (lines.radius > 0.0).tolist() == lines.stitch.tolist()
    ((first, second),) = lines.ends[lines.stitch]
    assert film.position[0, [first, second], 0] == pytest.approx([0.01, 0.014])
    above = Options(view=(-90.0, 90.0))
    for options, is_silk in ((above, True), (replace(above, colour="tension"), False)):
        painter = Painter(film, options, (240, 160), "")
        pixels = painter.scene(0.0) / 255.0
        place, _ = painter.camera.seen(np.array([[0.012, 0.0, 0.0]]))
        x, y = ((1.0 + place[0] * [1, -1]) / 2.0 * [240, 160]).astype(int)
        near = pixels[y - 2 : y + 3, x - 2 : x + 3].reshape(-1, 3)
        silk = np.linalg.norm(lab(near) - lab(np.array(rgb(palette.SILK))), axis=1).min()
        assert (silk < 15.0) == is_silk, (options.colour, silk)


def test_colours_can_be_set_and_are_inherited(tmp_path):
    scene = BLOCK.replace(
        'use "tissues/fat"', 'use "tissues/fat"\ntissue mine like fat { gloss = 0 }'
    )
    scene = scene.replace("tissue is fat;", "tissue is mine;")
    (tmp_path / "block.tis").write_text(scene)
    result = tissuec.run(
        tmp_path / "block.tis", params={"colour of mine": '"#102030"'}, companion="off",
        out=tmp_path / "block.vtkhdf",
    )  # fmt: skip
    tints = node_tints(result)
    assert np.allclose(tints[0], [16 / 255, 32 / 255, 48 / 255, 0.0])


def tube(sides, rings=4):
    turn = 2.0 * np.pi * np.arange(sides) / sides
    points = np.array([[x, np.cos(a), np.sin(a)] for x in range(rings) for a in turn])
    at = np.arange(sides * rings).reshape(rings, sides)
    a, b = at[:-1], np.roll(at, -1, axis=1)[:-1]
    c, d = at[1:], np.roll(at, -1, axis=1)[1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)
    return points, faces


def smooth(points, faces, divisions):
    mesh = smooth_mesh(points, faces)
    return rounded(mesh, bulges(points, faces, mesh), divisions)[0]


@pytest.mark.parametrize("sides", [10, 20, 40])
def test_a_tube_is_round_to_third_order(sides):
    points, faces = tube(sides)
    corners = smooth(points, faces, 8).corners.reshape(-1, 3)
    inner = corners[(corners[:, 0] >= 1.0) & (corners[:, 0] <= 2.0)]
    away = np.abs(np.hypot(inner[:, 1], inner[:, 2]) - 1.0).max()
    flat = 1.0 - np.cos(np.pi / sides)
    assert away < 0.5 * (np.pi / sides) ** 4 < 0.25 * flat


def test_rounding_leaves_no_gap_and_nodes_in_place():
    points = np.random.default_rng(5).normal(size=(40, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points[:, 2] *= 0.3  # sharp and smooth edges
    hull = ConvexHull(points)
    faces = hull.simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    out = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) > 0.0
    faces = np.where(out[:, None], faces, faces[:, ::-1])
    corners = smooth(points, faces, 4).corners
    # Every edge of a part is met by its reverse at the same place: the surface stays closed.
    starts = corners.reshape(-1, 3).round(12) + 0.0
    ends = np.roll(corners, -1, axis=1).reshape(-1, 3).round(12) + 0.0
    there = {(tuple(a), tuple(b)) for a, b in zip(starts, ends, strict=True)}
    assert all((b, a) in there for a, b in there)
    assert {tuple(p) for p in points.round(12) + 0.0} <= {tuple(p) for p in starts}


def test_flat_faces_stay_flat_and_blocks_keep_their_edges():
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0.0, 1.0)])
    hull = ConvexHull(cube)
    corners = smooth(cube, hull.simplices, 4).corners.reshape(-1, 3)
    on_a_face = np.minimum(np.abs(corners), np.abs(corners - 1.0)).min(axis=1)
    assert on_a_face.max() < 1e-12 and corners.min() > -1e-12 and corners.max() < 1.0 + 1e-12


def test_parts_cover_their_triangle():
    mesh = smooth_mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]))
    for divisions in (1, 2, 4, 8):
        parts, weights = rounded(mesh, np.zeros((1, 3, 3)), divisions)
        a, b, c = (parts.corners[:, k] for k in range(3))
        assert len(parts.corners) == divisions**2 == len(weights)
        assert np.cross(b - a, c - a)[:, 2] == pytest.approx(1.0 / divisions**2)
        assert spread(mesh.corners, weights).sum() == pytest.approx(parts.corners.sum())


def test_springs_hide_behind_skin_unless_a_colour_is_chosen():
    film = read_film(tissuec.run(BLOCK, companion="off"), Options())
    assert not film.shows_springs(None) and film.shows_springs("tension")
    assert film.divisions == 8


def test_only_tubes_and_shells_have_an_inside():
    scene = SHEET.replace("TISSUE", "fat").replace("NAME", "fat")
    sheet = read_film(tissuec.run(scene, companion="off"), Options())
    block = read_film(tissuec.run(BLOCK, companion="off"), Options())
    pipe = re.sub(
        r"mesh is sheet \{.*?\}",
        "mesh is tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; "
        "radius = 4 mm; rings = 4; sides = 8 }",
        scene,
        flags=re.S,
    )
    hollow = read_film(tissuec.run(pipe, companion="off"), Options()).skin.hollow
    assert not sheet.skin.hollow.any() and not block.skin.hollow.any() and hollow.all()
