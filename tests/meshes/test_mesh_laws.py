"""Laws that every mesh keeps, whatever its kind and options."""

from itertools import product

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.every import every
from tissuec.core.fields import LocatedFile
from tissuec.core.resources import library
from tissuec.meshes.generators import MESHES, Mesh
from tissuec.model.topology import pieces

SHEET = {
    "corner": np.array([0.01, 0.02, 0.03]),
    "first_edge": np.array([0.04, 0.0, 0.0]),
    "second_edge": np.array([0.0, 0.03, 0.0]),
}
TUBE = {"axis": (np.array([0.01, 0.0, 0.0]), np.array([0.065, 0.0, 0.0])), "radius": 0.003}
BOX = (np.array([-0.01, 0.0, 0.02]), np.array([0.01, 0.02, 0.05]))  # 2 x 2 x 3 cells of 10 mm
BAR = (np.zeros(3), np.array([0.01, 0.01, 0.03]))  # 1 x 1 x 3 cells
REACH = ("nearest neighbours", "second neighbours", "third neighbours")


def samples():
    """Yield (kind, entries) for every combination of options and several sizes."""
    for sides, diagonals, interior in product(
        (3, 4, 5, 6, 7, 10, 11), ("none", "one", "both"), ("none", "crossed", "spokes")
    ):
        if sides >= {"none": 3, "crossed": 6, "spokes": 4}[interior]:
            for rings in (2, 5):
                entries = {"rings": rings, "sides": sides}
                yield "tube", TUBE | entries | {"diagonals": diagonals, "interior": interior}
    for part, layers in product(("whole", "half", "quarter"), (1, 2)):
        entries = {"inner_radius": 0.003, "outer_radius": 0.004, "layers": layers, "part": part}
        yield "thick tube", {"axis": TUBE["axis"], "rings": 4, "sides": 8} | entries
    for part, cell in product(("whole", "half", "quarter"), (0.01, 0.003)):
        cone = {"axis": TUBE["axis"], "radius": 0.01, "end_radius": 0.006, "cell": cell}
        yield "cylinder", cone | {"part": part}
    for part, cell in product(("whole", "half", "quarter", "eighth"), (0.02, 0.005)):
        egg = {"centre": np.full(3, 0.1), "radii": np.array([0.03, 0.02, 0.01]), "cell": cell}
        yield "ellipsoid", egg | {"part": part}
    for (columns, rows), diagonals, second in product(
        ((2, 2), (2, 5), (7, 4)), ("none", "one", "both"), ("no", "yes")
    ):
        entries = {"columns": columns, "rows": rows, "diagonals": diagonals}
        yield "sheet", SHEET | entries | {"second_neighbours": second}
    for subdivisions, interior in product((0, 1, 3), ("none", "spokes", "antipodes")):
        entries = {"subdivisions": subdivisions, "interior": interior}
        yield "sphere", {"centre": np.array([0.1, 0.2, 0.3]), "radius": 0.02} | entries
    for kind, reach, box in product(
        ("sodium chloride", "caesium chloride", "diamond", "braced cubes"), REACH, (BOX, BAR)
    ):
        yield "lattice", {"kind": kind, "cell": 0.01, "box": box, "reach": reach}
    line = {"line": (np.zeros(3), np.array([0.03, 0.01, 0.0]))}
    loop = {"centre": np.full(3, 0.1), "normal": np.array([1.0, 2.0, 0.0]), "radius": 0.02}
    for count in (3, 4, 9):
        for entries in (line, loop):
            yield "thread", {"pieces": count, "thickness": 0.001} | entries
    ring = np.array([[0, 1], [2, 1], [2, 3], [3, 0]])
    yield "explicit", {"position": np.eye(4, 3), "ends": ring}
    liver = LocatedFile("liver.obj", library() / "meshes" / "liver.obj", 1e-3)
    yield "imported", {"file": liver}
    for filling in (
        "sodium chloride",
        "caesium chloride",
        "diamond",
        "braced cubes",
        "tetrahedra",
    ):
        yield "imported", {"file": liver, "filling": filling, "cell": 0.018}


SOLIDS = ("sphere", "lattice", "imported", "thick tube", "cylinder", "ellipsoid")
ROUND = ("thick tube", "cylinder", "ellipsoid")


def label(value):
    if isinstance(value, str):
        return value
    return " ".join(str(v) for v in value.values() if isinstance(v, str | int))


SAMPLES = [
    *samples(),
]
every_sample = every(("kind", "entries"), SAMPLES, ids=label)


BUILT: dict[int, Mesh] = {}


def built(kind, entries):
    """Return the mesh of one of the samples, which is built once; nobody changes it."""
    key = id(entries)
    if key not in BUILT:
        BUILT[key] = MESHES[kind](**entries).build()
    return BUILT[key]


def test_every_kind_has_a_sample():
    assert {kind for kind, _ in SAMPLES} == set(MESHES)


@every_sample
def test_no_spring_repeats_or_joins_a_node_to_itself(kind, entries):
    ends = built(kind, entries).ends
    assert (ends[:, 0] < ends[:, 1]).all()
    assert len(np.unique(ends, axis=0)) == len(ends)


@every_sample
def test_springs_are_ordered_by_their_nodes(kind, entries):
    if kind == "explicit":
        pytest.skip("tables keep the order of their rows")
    ends = built(kind, entries).ends
    assert np.array_equal(np.lexsort((ends[:, 1], ends[:, 0])), np.arange(len(ends)))


@every_sample
def test_every_node_has_two_springs_or_more(kind, entries):
    mesh = built(kind, entries)
    degree = np.bincount(mesh.ends.ravel(), minlength=len(mesh.position))
    assert len(degree) == len(mesh.position)
    ends = 2 if "line" in entries else 0  # an open thread has ends
    assert (degree < 2).sum() == ends


@every_sample
def test_a_mesh_is_one_piece(kind, entries):
    mesh = built(kind, entries)
    assert not pieces(len(mesh.position), mesh.ends).any()


@every_sample
def test_size_is_a_bound_and_exact_but_for_lattices_and_files(kind, entries):
    generator = MESHES[kind](**entries)
    mesh = built(kind, entries)
    nodes, springs = generator.size()
    assert nodes == len(mesh.position) or "filling" in entries
    assert nodes >= len(mesh.position)
    if kind in ("lattice", "imported"):
        assert len(mesh.ends) <= springs
    else:
        assert len(mesh.ends) == springs


@every_sample
def test_types_are_those_of_the_kernels(kind, entries):
    mesh = built(kind, entries)
    assert mesh.position.dtype == np.float64 and mesh.position.shape[1] == 3
    assert mesh.ends.dtype == np.int32 and mesh.ends.shape[1] == 2
    assert mesh.skin.dtype == np.int32 and mesh.skin.shape[1] == 3


@every_sample
def test_no_two_nodes_coincide(kind, entries):
    position = built(kind, entries).position
    gap, _ = KDTree(position).query(position, k=2)
    assert gap[:, 1].min() > 1e-4  # the samples are centimetres in size


@every_sample
def test_two_builds_are_equal(kind, entries):
    one, other = built(kind, entries), MESHES[kind](**entries).build()
    assert np.array_equal(one.position, other.position)
    assert np.array_equal(one.ends, other.ends)
    assert np.array_equal(one.skin, other.skin)


def image_of(position, ends, move):
    """Return the springs of the net after ``move``, numbered as before, as a set of pairs."""
    moved = move(position)
    gap = np.linalg.norm(moved[:, None] - position, axis=2)
    assert gap.min(axis=1).max() < 1e-12  # a million times below the spacing, above rounding
    partner = gap.argmin(axis=1)
    return {tuple(sorted(pair)) for pair in partner[ends].tolist()}


def mirrored(axis):
    def move(position):
        moved = position.copy()
        moved[:, axis] = position[:, axis].min() + position[:, axis].max() - position[:, axis]
        return moved

    return move


def half_turned(position):
    return mirrored(0)(mirrored(1)(position))


def diagonal_swapped(position):
    low = position.min(axis=0)
    return (position - low)[:, [1, 0, 2]] + low


def symmetries(kind, entries):
    """Return the mirror images and turns under which a sample must not change."""
    if kind == "sphere":
        return [mirrored(0), mirrored(1), mirrored(2)]
    if kind == "thread":  # those of these samples, which lie as they like
        return []
    if kind in ("cylinder", "ellipsoid"):
        # Along x, a cone has no mirror; a half, a quarter or an eighth has fewer.
        axes = {"whole": (0, 1, 2), "half": (0, 1), "quarter": (0,), "eighth": ()}
        return [mirrored(axis) for axis in axes[entries["part"]] if kind == "ellipsoid"]
    if kind in ("tube", "sheet"):
        chiral = entries["diagonals"] == "one"
        if kind == "sheet":
            return [half_turned] if chiral else [mirrored(0), mirrored(1)]
        # Side 0 points along y, so the mirror that every number of sides allows is z -> -z.
        return [lambda p: mirrored(0)(mirrored(2)(p))] if chiral else [mirrored(0), mirrored(2)]
    if kind != "lattice":  # of a mesh of one's own, nothing is known
        return []
    if entries["kind"] == "diamond":  # the crystal itself has no mirror parallel to a face
        return [half_turned, diagonal_swapped]
    if entries["kind"] == "braced cubes" and entries["reach"] != "third neighbours":
        # Even numbers of cells have another diagonal at either end.
        low, high = entries["box"]
        odd = np.rint((high - low) / entries["cell"]) % 2 == 1
        return [mirrored(axis) for axis in range(3) if odd[axis]]
    return [mirrored(0), mirrored(1), mirrored(2)]


@every(
    ("kind", "entries"), [s for s in SAMPLES if s[0] not in ("explicit", "imported")], ids=label
)
def test_a_mesh_is_as_symmetric_as_its_shape(kind, entries):
    mesh = built(kind, entries)
    drawn = {tuple(pair) for pair in mesh.ends.tolist()}
    for move in symmetries(kind, entries):
        assert image_of(mesh.position, mesh.ends, move) == drawn


@every(("kind", "entries"), [s for s in SAMPLES if s[0] in SOLIDS], ids=label)
def test_the_skin_of_a_solid_is_closed_and_faces_outwards(kind, entries):
    mesh = built(kind, entries)
    edges = mesh.skin[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    one_way = {tuple(edge) for edge in edges.tolist()}
    assert len(one_way) == len(edges)
    assert {(b, a) for a, b in one_way} == one_way
    a, b, c = mesh.position[mesh.skin].transpose(1, 0, 2)
    volume = np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0
    if kind == "imported":
        assert volume == pytest.approx(666.5e-6, rel=1e-4)
    elif kind in ROUND:
        assert mesh.volume is not None
        # Faces of cells are curved; two triangles of each are not.
        assert volume == pytest.approx(mesh.volume.sum(), rel=0.01)
    elif kind == "lattice":
        low, high = entries["box"]
        assert volume == pytest.approx(np.prod(high - low), rel=1e-12)
    else:
        ball = 4.0 / 3.0 * np.pi * entries["radius"] ** 3
        assert 0.6 * ball < volume < ball  # an icosahedron fills 60.5 % of its sphere


def test_entries_outside_their_limits_are_refused_by_name():
    cases = [
        ("tube", TUBE | {"rings": 1, "sides": 5}, '"rings" must be at least 2, not 1'),
        ("tube", TUBE | {"rings": 2, "sides": 2.5}, '"sides" must be a whole number'),
        ("tube", TUBE | {"rings": 2, "sides": 5, "radius": 0.0}, '"radius" must be above 0 m'),
        (
            "tube",
            TUBE | {"rings": 2, "sides": 5, "interior": "cross"},
            '"interior" must be one of',
        ),
        ("sheet", SHEET | {"rows": 2, "columns": 1}, '"columns" must be at least 2'),
        (
            "sheet",
            SHEET | {"rows": 2, "columns": 2, "corner": np.array([0, 0])},
            '"corner" must',
        ),
        (
            "sheet",
            SHEET | {"rows": 2, "columns": 2, "first_edge": np.array([np.inf, 0, 0])},
            '"first edge" must have finite components',
        ),
        ("sphere", {"centre": np.zeros(3), "radius": 1.0, "subdivisions": 8}, "at most 7"),
        ("sphere", {"centre": np.zeros(3), "radius": np.nan, "subdivisions": 1}, "finite"),
    ]
    for kind, entries, message in cases:
        with pytest.raises(ValueError, match=message):
            MESHES[kind](**entries)


def quality(mesh):
    """Return the least product of three unit edges at a corner of each cell, shape (cell,)."""
    nodes = mesh.elements[0].nodes
    beside = [
        [1, 3, 4],
        [2, 0, 5],
        [3, 1, 6],
        [0, 2, 7],
        [7, 5, 0],
        [4, 6, 1],
        [5, 7, 2],
        [6, 4, 3],
    ]
    edges = mesh.position[nodes[:, beside]] - mesh.position[nodes][:, :, None]
    return np.linalg.det(edges / np.linalg.norm(edges, axis=3)[..., None]).min(axis=1)


@pytest.mark.parametrize("across", [4, 8, 16])
def test_cells_of_balls_and_cylinders_are_neither_flat_nor_needles(across):
    ball = MESHES["ellipsoid"](centre=np.zeros(3), radii=np.ones(3), cell=2.0 / across)
    axis = (np.zeros(3), np.array([0.0, 0.0, 2.0]))
    plug = MESHES["cylinder"](axis=axis, radius=1.0, cell=2.0 / across)
    # Where three cells meet on a circle, at most sin 120 deg is possible, and on a ball 0.77.
    assert quality(ball.build_elements()).min() > 0.65
    assert quality(plug.build_elements()).min() > 0.75


@pytest.mark.parametrize("part", ["whole", "half", "quarter", "eighth"])
def test_elements_fill_an_ellipsoid_and_nets_with_the_square_of_cells(part):
    share = {"whole": 1, "half": 2, "quarter": 4, "eighth": 8}[part]
    exact = 4.0 / 3.0 * np.pi * 0.03 * 0.02 * 0.01 / share
    missing = []
    for cell in (0.0025, 0.00125):
        egg = MESHES["ellipsoid"](
            centre=np.zeros(3), radii=np.array([0.03, 0.02, 0.01]), cell=cell, part=part
        )
        assert egg.build_elements().volume.sum() == pytest.approx(exact, rel=1e-12)
        missing.append(1.0 - egg.build().volume.sum() / exact)
    assert missing[0] < 0.05 and missing[0] / missing[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("cell", [0.006, 0.002])
def test_elements_fill_cones_and_tubes(cell):
    axis = (np.zeros(3), np.array([0.01, 0.0, 0.03]))
    for part in ("whole", "half", "quarter"):
        share = {"whole": 1, "half": 2, "quarter": 4}[part]
        cone = MESHES["cylinder"](
            axis=axis, radius=0.01, end_radius=0.005, cell=cell, part=part
        )
        tube = MESHES["thick tube"](
            axis=axis, inner_radius=0.005, outer_radius=0.01, rings=4, sides=8, part=part,
            end_inner_radius=0.004,
        )  # fmt: skip
        long = np.pi * np.sqrt(1e-3) / 3.0 / share
        full = long * (0.01**2 + 0.01 * 0.005 + 0.005**2)
        assert cone.build_elements().volume.sum() == pytest.approx(full, rel=1e-12)
        wall = long * (3 * 0.01**2 - 0.005**2 - 0.005 * 0.004 - 0.004**2)
        assert tube.build_elements().volume.sum() == pytest.approx(wall, rel=1e-12)


def test_named_parts_of_round_solids_are_where_they_should_be():
    axis = (np.zeros(3), np.array([0.0, 0.0, 0.03]))
    plug = MESHES["cylinder"](axis=axis, radius=0.01, end_radius=0.005, cell=0.002)
    mesh = plug.build_elements()
    x, y, z = mesh.position.T
    assert np.array_equal(np.sort(mesh.groups["first end"]), np.flatnonzero(z < 1e-9))
    assert np.array_equal(np.sort(mesh.groups["last end"]), np.flatnonzero(z > 0.03 - 1e-9))
    wide = np.hypot(x, y) / (0.01 - z / 6.0)
    side = np.isclose(wide, wide.max(), rtol=1e-9)
    assert 1.0 < wide.max() < 1.02
    assert np.array_equal(np.sort(mesh.groups["side"]), np.flatnonzero(side))
    ball = MESHES["ellipsoid"](centre=np.ones(3), radii=np.full(3, 0.01), cell=0.002)
    mesh = ball.build_elements()
    wide = np.linalg.norm(mesh.position - 1.0, axis=1)
    surface = np.isclose(wide, wide.max(), rtol=1e-9)
    assert 0.01 < wide.max() < 0.0103
    assert np.array_equal(np.sort(mesh.groups["surface"]), np.flatnonzero(surface))
    tube = MESHES["thick tube"](
        axis=axis, inner_radius=0.004, outer_radius=0.006, rings=3, sides=8, layers=2
    )
    mesh = tube.build_elements()
    x, y, z = mesh.position.T
    # An octagon with the area of its circle.
    larger = np.sqrt(0.25 * np.pi / np.sin(0.25 * np.pi))
    for name, radius in (("inside", 0.004), ("outside", 0.006)):
        there = np.isclose(np.hypot(x, y), larger * radius, rtol=1e-9)
        assert np.array_equal(np.sort(mesh.groups[name]), np.flatnonzero(there))
    for name, place in (("first end", 0.0), ("last end", 0.03)):
        assert np.array_equal(np.sort(mesh.groups[name]), np.flatnonzero(np.isclose(z, place)))
