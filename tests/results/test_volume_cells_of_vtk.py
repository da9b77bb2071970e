"""Solids are volume cells in ParaView and PyVista: filled, whole, and of the right size."""

import json

import h5py
import numpy as np
import pytest

import tissuec
from tests.every import every
from tests.findings import finding_of
from tests.test_cli import tissuec as command
from tests.vtk_reading import BRICK, HEXAHEDRON, TETRAHEDRON, WEDGE, frame, opened
from tissuec.geometry.elements import CUBE, CUBE_27, MIDDLES, SHAPES
from tissuec.meshes.formats import FormatError
from tissuec.meshes.formats import read as read_mesh
from tissuec.results.element_cells import TYPES
from tissuec.results.export import frame_shape
from tissuec.results.shapes import write_vtu

pyvista = pytest.importorskip("pyvista")

GEL = "tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }\n"
RECORDED = "trajectory with [stress tensor, strain tensor] every 2 ms"
BLOCK = """language 1
{gel}
body block {{ mesh is {mesh}; tissue is gel; {made} }}
set low = nodes of block where z < 0.1 mm
set high = nodes of block where z > 7.9 mm
environment {{ gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }}
script {{
  at 0 s: fix low
  from 0 s to 4 ms: move high by (1, 0.5, 1) mm using smooth profile
  {more}
}}
simulate {{ duration = 6 ms }}
output {{ trajectory every 2 ms; volume(block) every 2 ms; stress(block) every 2 ms; blocks }}
"""
LATTICE = "lattice { cell = 4 mm; box from (0, 0, 0) mm to (8, 8, 8) mm }"
MADE = {
    HEXAHEDRON: (LATTICE, "made of elements"),
    BRICK: (LATTICE, "made of quadratic elements"),
    TETRAHEDRON: ('imported { file "tetrahedra.vtk" in mm }', "made of elements"),
    WEDGE: ('imported { file "wedges.vtk" in mm }', "made of elements"),
}
COUNTS = {HEXAHEDRON: 8, BRICK: 8, TETRAHEDRON: 5, WEDGE: 2}
CORNERS = 4.0 * (CUBE + 1.0)
FILES = {
    "tetrahedra": (10, [[0, 1, 3, 4], [1, 2, 3, 6], [1, 4, 5, 6], [3, 4, 6, 7], [1, 3, 4, 6]]),
    "wedges": (13, [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]),
}


def scene(kind, more=""):
    mesh, made = MADE[kind]
    return BLOCK.format(gel=GEL, mesh=mesh, made=made, more=more)


def saved(folder, name, text):
    """Write a scene with its meshes, and return where it is."""
    for mesh, (kind, cells) in FILES.items():
        grid = pyvista.UnstructuredGrid(
            np.insert(np.array(cells), 0, len(cells[0]), axis=1).ravel(),
            [kind] * len(cells), CORNERS,
        )  # fmt: skip
        grid.save(folder / f"{mesh}.vtk")
    path = folder / f"{name}.tis"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Results of blocks of each kind of cells by kind."""
    folder = tmp_path_factory.mktemp("solids")
    return {
        kind: tissuec.run(
            saved(folder, kind, scene(kind)), out=folder / f"{kind}.vtkhdf", companion="off"
        )
        for kind in MADE
    }


def corners_of(name):
    """Return a cell of a shape that is moved and sheared, with straight edges (node, 3)."""
    tetrahedron = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    wedge = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
    natural = {
        "hexahedron": CUBE, "quadratic hexahedron": CUBE_27, "wedge": wedge,
        "tetrahedron": np.concatenate([tetrahedron, tetrahedron[MIDDLES].mean(axis=1)]),
    }[name]  # fmt: skip
    return natural @ np.array([[1.0, 0.2, 0], [0.1, 1.2, 0.3], [0, -0.2, 0.9]]) + 0.5


@every("name", sorted(TYPES))
def test_the_order_of_nodes_is_that_of_vtk(name):
    """VTK's validator takes the cell, its volume is positive, and quadratics interpolate."""
    corners = corners_of(name)
    grid = pyvista.UnstructuredGrid(
        np.array([len(corners), *range(len(corners))]), [TYPES[name]], corners
    )
    (volume,) = SHAPES[name].volumes(corners[None])
    assert volume > 0.0
    assert grid.compute_cell_sizes()["Volume"][0] == pytest.approx(volume, rel=1e-12)
    assert grid.integrate_data()["Volume"][0] == pytest.approx(volume, rel=1e-12)
    from vtkmodules.vtkFiltersGeneral import vtkCellValidator

    validator = vtkCellValidator()
    validator.SetInputData(grid)
    validator.Update()
    state = validator.GetOutput().GetCellData().GetArray("ValidityState")
    assert state.GetTuple1(0) == 0.0
    if name in ("tetrahedron", "quadratic hexahedron"):

        def quadratic(x):
            return 1.0 + x @ [1.0, 2.0, 3.0] + x[..., 0] * x[..., 1] - x[..., 2] ** 2

        from vtkmodules.vtkCommonCore import mutable

        cell, values = grid.GetCell(0), quadratic(corners)
        place, weights = [0.0] * 3, [0.0] * len(corners)
        for at in np.random.default_rng(2).uniform(0.1, 0.3, (5, 3)):
            cell.EvaluateLocation(mutable(0), at, place, weights)
            assert values @ weights == pytest.approx(quadratic(np.array(place)), rel=1e-12)


@every("kind", MADE)
def test_a_solid_is_its_elements(runs, kind):
    result = runs[kind]
    for number in range(len(result.times)):
        grid = frame(result.path, number)
        assert set(grid.celltypes) == {kind}
        assert grid.n_cells == COUNTS[kind]
        assert np.array_equal(grid.points, result.position[number])
        assert set(grid.cell_data.keys()) == {"region", "tissue"}
    assert not result.tension[:].any()
    assert not result.spring_force(-1)[0].any()


@every("kind", MADE)
def test_the_integral_of_the_volume_is_the_measure(runs, kind):
    """To rounding where edges are straight; VTK divides bent cells into straight pieces."""
    result = runs[kind]
    measured = result.logs["volume of block"].value[:, 0]
    first = frame(result.path, 0).integrate_data()["Volume"][0]
    assert first == pytest.approx(measured[0], rel=1e-12)
    assert first == pytest.approx(512e-9, rel=1e-12)
    last = frame(result.path, len(result.times) - 1)
    assert last.integrate_data()["Volume"][0] == pytest.approx(measured[-1], rel=0.02)
    shape = SHAPES[{number: name for name, number in TYPES.items()}[kind]]
    cells = last.cells.reshape(COUNTS[kind], -1)[:, 1:]
    assert shape.volumes(last.points[cells]).sum() == pytest.approx(measured[-1], rel=1e-12)


def test_slices_clips_and_contours_are_filled(runs):
    grid = frame(runs[HEXAHEDRON].path, 0)
    cut = grid.slice(origin=(3e-3, 3e-3, 3e-3), normal="z")
    assert cut.area == pytest.approx(64e-6, rel=1e-12)
    half = grid.clip(origin=(3e-3, 3e-3, 3e-3), normal="z")
    assert half.integrate_data()["Volume"][0] == pytest.approx(64e-6 * 3e-3, rel=1e-9)
    height = grid.contour([2e-3], scalars=grid.points[:, 2])
    assert height.area == pytest.approx(64e-6, rel=1e-9)


def without_a_layer():
    """Return a scene in which the edges along x of one of two layers are removed."""
    gone = "set gone = springs of block where x > 5.9 mm and x < 6.1 mm\nenvironment"
    return scene(HEXAHEDRON, "at 5 ms: cut gone").replace("environment", gone)


def test_elements_that_are_lost_vanish(tmp_path):
    path = saved(tmp_path, "cut", without_a_layer())
    result = tissuec.run(path, out=tmp_path / "cut.vtkhdf", companion="off")
    first, last = (frame(result.path, n) for n in (0, len(result.times) - 1))
    assert (first.celltypes == HEXAHEDRON).sum() == 8
    left = result.cells(-1).elements
    assert (last.celltypes == HEXAHEDRON).sum() == len(left) < 8


@every("kind", MADE)
def test_an_exported_frame_is_the_same(runs, kind, tmp_path):
    result, path = runs[kind], tmp_path / "frame.vtu"
    write_vtu(frame_shape(result, 2), path)
    grid, other = pyvista.read(path), frame(result.path, 2)
    for one in (grid, result.to_pyvista(2)):
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.cells, other.cells)
        assert np.array_equal(one.celltypes, other.celltypes)
        assert np.array_equal(one["velocity"], other["velocity"])


IMPORTED = """language 1
{gel}
body block {{ mesh is imported {{ file "{file}" in m }}; tissue is gel; {made} }}
set low = nodes of block where z < 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix low }}
simulate {{ duration = 1 us; integrator is velocity verlet; step = 1 us }}
output {{ trajectory every 1 us; volume(block) every 1 us }}
"""


@every("kind", MADE)
def test_a_deformed_solid_is_a_mesh(runs, kind, tmp_path):
    """Nodes, elements and volume of the last frame are those of the new body as drawn."""
    result = runs[kind]
    last = len(result.times) - 1
    write_vtu(frame_shape(result, last), tmp_path / "frame.vtu")
    result.save(tmp_path / "whole.vtkhdf")
    for file in ("frame.vtu", "whole.vtkhdf"):
        made = "made of quadratic elements" if kind == BRICK else "made of elements"
        scene = saved(tmp_path, "new", IMPORTED.format(gel=GEL, file=file, made=made))
        new = tissuec.run(scene, out=tmp_path / "new.vtkhdf", companion="off")
        assert new.position.shape[1] == result.position.shape[1]
        old, drawn = result.position[last], new.network.position
        order, other = np.lexsort(np.round(old, 9).T), np.lexsort(np.round(drawn, 9).T)
        np.testing.assert_allclose(drawn[other], old[order], rtol=0.0, atol=1e-15)
        volumes = [
            one.logs["volume of block"].value[n, 0] for one, n in ((result, -1), (new, 0))
        ]
        assert volumes[1] == pytest.approx(volumes[0], rel=1e-12)


def by_hand(drawn, place, young=10e3, ratio=0.3):
    """Return strain and neo-Hookean stress of tetrahedra with ten nodes [Pa], (cell, 6) each.

    By four points, with F of the shape functions (Hammer and Stroud, 1956). The volume costs
    0.5 K0 log² J at points and 0.5 (K - K0) log² of the mean of J, K0 = 2 μ < K.
    """
    shear, bulk = young / (2.0 * (1.0 + ratio)), young / (3.0 * (1.0 - 2.0 * ratio))
    local = np.minimum(2.0 * shear, bulk)
    near, far = (5.0 + 3.0 * np.sqrt(5.0)) / 20.0, (5.0 - np.sqrt(5.0)) / 20.0
    slopes = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    weights, gradients = [], []
    for point in range(4):
        share = np.full(4, far)
        share[point] = near
        natural = [(4.0 * share[a] - 1.0) * slopes[a] for a in range(4)]
        for a, b in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)):
            natural.append(4.0 * (share[a] * slopes[b] + share[b] * slopes[a]))
        sides = np.einsum("eax,ak->exk", drawn, np.array(natural))
        there = np.einsum("eax,ak->exk", place, np.array(natural))
        gradients.append(there @ np.linalg.inv(sides))
        weights.append(np.linalg.det(sides))
    deformation = np.stack(gradients, axis=1)
    share = np.stack(weights, axis=1)
    share /= share.sum(axis=1, keepdims=True)
    swell = np.linalg.det(deformation)
    mean = (share * swell).sum(axis=1)[:, None]
    left = deformation @ deformation.swapaxes(-1, -2)
    own = left - np.trace(left, axis1=2, axis2=3)[..., None, None] / 3.0 * np.eye(3)
    pressure = local * np.log(swell) / swell + (bulk - local) * np.log(mean) / mean
    stress = shear * swell[..., None, None] ** (-5.0 / 3.0) * own
    stress += pressure[..., None, None] * np.eye(3)
    strain = 0.5 * (deformation.swapaxes(-1, -2) @ deformation - np.eye(3))
    found = (np.einsum("eq,eqxy->exy", share, one) for one in (strain, stress))
    return [
        np.stack(
            [one[:, i, i] for i in range(3)]
            + [one[:, i, j] for i, j in ((0, 1), (1, 2), (0, 2))],
            axis=1,
        )
        for one in found
    ]


def test_strain_and_stress_of_elements_are_those_by_hand(runs):
    result = runs[TETRAHEDRON]
    reader = opened(result.path.with_name(f"{TETRAHEDRON}.blocks.vtkhdf"))
    for number in (1, len(result.times) - 1):
        reader.SetStep(number)
        reader.Update()
        block = pyvista.wrap(reader.GetOutputDataObject(0).GetBlock(0))
        cells = block.cells.reshape(COUNTS[TETRAHEDRON], -1)[:, 1:]
        strain, stress = by_hand(result.network.position[cells], block.points[cells])
        assert np.abs(strain).max() > 1e-3
        scale = np.abs(stress).max()
        np.testing.assert_allclose(block.cell_data["strain"], strain, rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(
            block.cell_data["stress"], stress, rtol=0.0, atol=1e-12 * scale
        )
        for name in ("stress", "von_mises", "displacement", "region", "tissue"):
            assert name in block.point_data


def test_files_that_are_no_deformed_shape_are_refused(runs, tmp_path):
    path = runs[HEXAHEDRON].path
    named = tmp_path / "a.vtkhdf"

    def refusal(data):
        with pytest.raises(FormatError) as caught:
            read_mesh(data, named)
        return str(caught.value)

    blocks = path.with_name(f"{HEXAHEDRON}.blocks.vtkhdf").read_bytes()
    assert refusal(blocks) == 'it contains "MultiBlockDataSet", not "UnstructuredGrid"'
    assert refusal(path.read_bytes()[:20_000]).startswith("it cannot be read: ")
    with h5py.File(named, "w") as file:
        file["other"] = 1
    assert refusal(named.read_bytes()) == "it is an HDF5 file without the group VTKHDF"
    with h5py.File(path) as now, h5py.File(named, "w") as file:
        for name in now:
            now.copy(name, file)
        file["tissuec"].attrs["layout_version"] = 2
    assert refusal(named.read_bytes()) == (
        f"it is a result of layout 2 (of tissuec {tissuec.__version__}), which has no volume "
        "cells"
    )
    text = scene(HEXAHEDRON).replace("trajectory every 2 ms; ", "").replace("; blocks", "")
    still = tissuec.run(text, out=tmp_path / "still.vtkhdf", companion="off")
    assert refusal(still.path.read_bytes()) == (
        "it contains no frame, because its scene records no trajectory"
    )


@pytest.mark.parametrize(
    ("kind", "cells", "where"),
    [
        (HEXAHEDRON, [[0, 1, 2, 3, 4, 5, 6, 7], [0, 1, 2, 3, 3, 2, 1, 0]], "(4 mm, 4 mm, 0 m)"),
        (WEDGE, [[0, 1, 2, 4, 5, 6], [0, 1, 2, 2, 1, 0]], "(5.33 mm, 2.67 mm, 0 m)"),
        (10, [[0, 1, 3, 4], [0, 1, 2, 3]], "(4 mm, 4 mm, 0 m)"),
    ],
)
def test_cells_without_volume_have_a_place_and_a_way_out(kind, cells, where, tmp_path):
    grid = pyvista.UnstructuredGrid(
        np.insert(np.array(cells), 0, len(cells[0]), axis=1).ravel(), [kind] * 2, CORNERS
    )
    grid.save(tmp_path / "mesh.vtk")
    mesh = 'imported { file "mesh.vtk" in mm }'
    text = BLOCK.format(gel=GEL, mesh=mesh, made="made of elements", more="")
    (tmp_path / "scene.tis").write_text(text, encoding="utf-8")
    found = finding_of(tissuec.compile, tmp_path / "scene.tis")
    name = {HEXAHEDRON: "hexahedron", WEDGE: "wedge", 10: "tetrahedron"}[kind]
    assert found.code == "TIS605" and found.span.text.startswith('file "mesh.vtk"')
    assert f"the first of them {name} 2 around {where}" in found.message
    assert found.hint.startswith("repair it in the program that made the mesh")


def test_recorded_tensors_are_those_of_blocks(tmp_path):
    """The result and its blocks have them at cells, also once some elements are gone."""
    text = without_a_layer()
    plain = tissuec.run(text, out=tmp_path / "plain.vtkhdf", companion="off")
    text = text.replace("trajectory every 2 ms", RECORDED)
    result = tissuec.run(text, out=tmp_path / "a.vtkhdf", companion="off")
    assert result.fields["stress tensor"].shape == (len(result.times), 8, 6)
    reader = opened(plain.path.with_name("plain.blocks.vtkhdf"))
    other = opened(result.path.with_name("a.blocks.vtkhdf"))
    for number in range(len(result.times)):
        grid = frame(result.path, number)
        solid = grid.celltypes == HEXAHEDRON
        for one in (reader, other):
            one.SetStep(number)
            one.Update()
        block, recorded = (
            pyvista.wrap(one.GetOutputDataObject(0).GetBlock(0)) for one in (reader, other)
        )
        for name in ("stress", "strain"):
            expected = block.cell_data[name]
            least = 1e-12 * max(1e-9, np.abs(expected).max())
            for found in (grid.cell_data[name][solid], recorded.cell_data[name]):
                np.testing.assert_allclose(found, expected, rtol=0.0, atol=least)
        gone = np.isnan(result.fields["stress tensor"][number]).any(axis=1)
        assert (~gone).sum() == solid.sum()
    assert gone.any()
    assert np.abs(expected).max() > 1e-3


LABELLED = """language 1
{gel}
tissue muscle like gel {{ fibre modulus = 30 kPa }}
tissue scar like muscle {{ Young's modulus = 20 kPa; prestress = 5 % }}
body other {{
  mesh is lattice {{ cell = 4 mm; box from (20, 0, 0) mm to (24, 4, 8) mm }}; tissue is gel
  region top where z > 4 mm {{ }}
}}
body block {{
  mesh is {mesh}; tissue is gel; fibres = (3, 4, 0); second fibres = (0, 0, 1)
  prestress along (1, 0, 0)
  region left where x < 4.1 mm and y < 4.1 mm {{ tissue is muscle }}
  region right where x > 4.1 mm {{ tissue is scar }}
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
set gone = springs of block where z > 1.9 mm and z < 2.1 mm
script {{ at 1 ms: cut gone }}
simulate {{ duration = 2 ms }}
output {{ trajectory every 1 ms; blocks }}
"""


def test_cells_have_regions_tissues_and_fibres(tmp_path):
    """In results, blocks, exported frames and PyVista, also once elements are gone."""
    path = saved(tmp_path, "labels", LABELLED.format(gel=GEL, mesh=LATTICE))
    result = tissuec.run(path, out=tmp_path / "labels.vtkhdf", companion="off")
    with h5py.File(result.path) as file:
        kept = file["tissuec/network/solids"]
        regions, tissues = (kept[f"{name}_names"].asstr()[:] for name in ("region", "tissue"))
    write_vtu(frame_shape(result, -1), tmp_path / "last.vtu")
    frames = {n: frame(result.path, n) for n in range(len(result.times))}
    reader = opened(tmp_path / "labels.blocks.vtkhdf")
    last = max(frames)
    assert frames[last].n_cells < frames[0].n_cells == 10
    for number, grid in [*frames.items(), (last, pyvista.read(tmp_path / "last.vtu"))]:
        drawn = pyvista.UnstructuredGrid(
            grid.cells, grid.celltypes, result.network.position[result.nodes]
        )
        x, y, z = drawn.cell_centers().points.T
        left, right = (x < 4e-3) & (y < 4e-3), (x > 4e-3) & (x < 9e-3)
        expected = np.select(
            [left, right, (x > 9e-3) & (z > 4e-3)],
            ["left of block", "right of block", "top of other"], "",
        )  # fmt: skip
        assert np.array_equal(regions[grid["region"]], expected)
        made = np.select([left, right], ["muscle", "scar"], "gel")
        assert np.array_equal(tissues[grid["tissue"]], made)
        has = (left | right)[:, None]
        for name, along in (("fibres", [0.6, 0.8, 0.0]), ("second_fibres", [0.0, 0.0, 1.0])):
            np.testing.assert_allclose(grid[name], has * along, rtol=0.0, atol=1e-15)
        reader.SetStep(number)
        reader.Update()
        blocks = pyvista.wrap(reader.GetOutputDataObject(0))
        solids = [b for b in blocks if b is not None and b.n_cells and (b.celltypes > 5).all()]
        assert len(solids) == 2
        for name in ("region", "tissue", "fibres", "second_fibres"):
            rows = np.concatenate([solid.cell_data[name] for solid in solids])
            assert np.array_equal(rows, grid[name])
    with h5py.File(tmp_path / "labels.blocks.vtkhdf") as file:
        names = file["VTKHDF/block_solid/FieldData"]
        assert names["region_names"].asstr()[:].tolist() == regions.tolist()
        assert names["tissue_names"].asstr()[:].tolist() == tissues.tolist()


LIVER = """language 1
use "matter/liver"
tissue parenchyma like liver { Poisson's ratio = 0.45; stiffening is none }
tissue scar like cirrhotic liver { Poisson's ratio = 0.4; stiffening is none }
body liver {
  mesh is imported { file "meshes/liver.obj" in mm; filling is tetrahedra; cell = 20 mm }
  tissue is parenchyma
  region nodule where within 30 mm of (-40, 0, 5) mm { tissue is scar }
}
set bare area = nodes of liver where group is "bare_area"
set tip = nodes of liver where group is "left_tip"
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix bare area; from 0 s to 10 us: move tip by (0, 0, 40) um using ramp }
simulate { duration = 10 us; integrator is velocity verlet; step = 0.5 us }
output { trajectory with stress tensor every 5 us; volume(liver) every 5 us }
"""


@pytest.fixture(scope="module")
def liver(tmp_path_factory):
    """The liver of the library as a body of elements: its scene and its result."""
    scene = tmp_path_factory.mktemp("liver") / "liver.tis"
    scene.write_text(LIVER, encoding="utf-8")
    return scene, tissuec.run(scene, out=scene.with_suffix(".vtkhdf"), companion="off")


def test_the_liver_can_be_sliced_clipped_and_integrated(liver):
    """VTK divides bent tetrahedra into straight ones: as drawn, volumes agree to rounding.

    Of the ten nodes of each, they agree at any time.
    """
    _, result = liver
    measured = result.logs["volume of liver"].value[:, 0]
    for number, volume in enumerate(measured):
        grid = frame(result.path, number)
        assert (grid.celltypes == TETRAHEDRON).all()
        whole = grid.integrate_data()["Volume"][0]
        assert whole == pytest.approx(volume, rel=1e-5 if number else 1e-12)
        cells = grid.cells.reshape(-1, 11)[:, 1:]
        exact = SHAPES["tetrahedron"].volumes(grid.points[cells]).sum()
        assert exact == pytest.approx(volume, rel=1e-12)
        halves = [grid.clip("x", origin=grid.center, invert=side) for side in (True, False)]
        parts = [half.integrate_data()["Volume"][0] for half in halves]
        assert min(parts) > 0.1 * whole
        assert sum(parts) == pytest.approx(whole, rel=1e-10)
        assert grid.slice("z", origin=grid.center).area > 0.01
        assert grid.contour([0.0], scalars=grid.points[:, 0]).area > 0.001


def test_the_liver_of_springs_is_a_closed_surface(shipped):
    """A net has no volume cells; the skin of it encloses the volume that the run measures."""
    result = tissuec.load(shipped("liver").path)
    measured = result.logs["volume of liver"]
    for number in (0, 15, len(result.times) - 1):
        grid = frame(result.path, number)
        skin = grid.extract_cells(grid.celltypes == 5).extract_surface(algorithm=None)
        at = np.searchsorted(measured.time, result.times[number] * (1.0 - 1e-12))
        assert skin.volume == pytest.approx(measured.value[at, 0], rel=1e-12)


def test_the_stress_of_the_liver_is_that_by_hand_from_what_explain_says(liver):
    scene, result = liver
    said = command("--json", "explain", str(scene), cwd=scene.parent)
    tissues = json.loads(said.stdout)["tissues"]
    last = frame(result.path, len(result.times) - 1)
    cells = last.cells.reshape(-1, 11)[:, 1:]
    drawn, place = result.network.position[cells], last.points[cells]
    with h5py.File(result.path) as file:
        names = file["tissuec/network/solids/tissue_names"].asstr()[:]
    for number, name in enumerate(names):
        own = last["tissue"] == number
        assert own.sum() > 20
        young, ratio = (
            tissues[name]["quantities"][key]["value"]
            for key in ("Young's modulus", "Poisson's ratio")
        )
        _, stress = by_hand(drawn[own], place[own], young, ratio)
        error = np.abs(last["stress"][own] - stress).max()
        assert error < 1e-11 * np.abs(last["stress"]).max()
    assert np.abs(last["stress"]).max() > 10.0
