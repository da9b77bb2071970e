"""Smooth surfaces in result files, their views, and what VTK reads of them."""

import os

import h5py
import numpy as np
import pytest

from tests.results.conftest import CUT, FRAMES, RUPTURE, SURFACES
from tests.vtk_reading import opened, points_of
from tissuec.core.source import Source
from tissuec.geometry.surfaces import SURFACES as FAMILY
from tissuec.geometry.surfaces.skin import BodySkin
from tissuec.pipeline import compile_request, simulate
from tissuec.results import PlaceError, ResultError
from tissuec.results.export import export_surface, surface_shape
from tissuec.results.info import summary
from tissuec.results.paraview import view_paths
from tissuec.results.recording import SurfaceChannel
from tissuec.results.shapes import write_obj, write_ply, write_vtu
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

SCENE = """language 1
tissue gum { spring constant = 20 N/m; viscosity = 20 mN*s/m; mass = 10 mg; prestress = 5 % }
body "left vessel" {
  mesh is tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 7; sides = 8 }
  tissue is gum
}
body patch {
  mesh is sheet {
    corner = (0, 0, 9) mm; first edge = (20, 0, 0) mm; second edge = (0, 15, 0) mm
    columns = 7; rows = 6; diagonals is one
  }
  tissue is gum
}
body ball {
  mesh is sphere { centre = (0, 0, 30) mm; radius = 4 mm; subdivisions = 1 }
  tissue is gum
}
set root = nodes of "left vessel" where x < 1 mm
tool shears { kind is scissors }
environment { gravity = (0, 0, 0) m/s^2; damping = 5 mN*s/m }
script {
  at 0 s: fix root
  at 20 ms: cut "left vessel" along plane through (9 mm, 0, 0) facing (1, 0, 0) with shears
  at 40 ms: cut patch along stroke from (9, -1, 8) mm to (9, 8, 8) mm by (0, 0, 2) mm
}
simulate { duration = 60 ms }
output {
  trajectory every 10 ms
  surface of ["left vessel", patch] every 10 ms
  surface of ball every 25 ms { subdivisions = 1 }
}
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Return the result of the scene above."""
    return run(SCENE, tmp_path_factory.mktemp("run") / "a.vtkhdf")


def run(text, path):
    request = Request(Source("scene.tis", text))
    compiled, _ = compile_request(request)
    return simulate(compiled, path, request=request).path


@pytest.fixture
def read(result):
    with Trajectory.open(result) as trajectory:
        yield trajectory


def expected(trajectory, name, frame):
    """Return points and triangles of a surface, from the frame of the net."""
    network, series = trajectory.network, trajectory.surfaces[name]
    (body,) = (body for body in network.bodies if body.name == name)
    alive = np.zeros(network.entity_count, dtype=bool)
    alive[trajectory.cells(frame).line_numbers] = True
    smoothing = FAMILY[series.kind](**series.entries)
    refined = smoothing.refine(BodySkin.of(network, body).at(alive))
    return refined.at(trajectory.position[frame][body.nodes]), refined.triangles


# --- content ---


@pytest.mark.parametrize("name", ["left vessel", "patch"])
def test_each_frame_is_the_surface_of_the_net_in_that_frame(read, name):
    series = read.surfaces[name]
    assert series.kind == "interpolating spline" and series.entries == {"subdivisions": 2}
    assert np.array_equal(series.times, read.times)
    counts = set()
    for frame in range(-1, len(series)):
        points, triangles = expected(read, name, frame)
        assert np.array_equal(series.position(frame), points)
        assert np.array_equal(series.triangles(frame), triangles)
        counts.add(len(triangles))
    assert len(counts) == 2  # before the cut, and after it
    with pytest.raises(IndexError, match="frame 7 of 7"):
        series.position(7)


def test_surfaces_have_rates_and_kinds_of_their_own(read):
    ball = read.surfaces["ball"]
    assert ball.kind == "loop subdivision" and ball.entries == {"subdivisions": 1}
    assert ball.times.tolist() == [0.0, 0.025, 0.05]
    assert [*read.surfaces] == ["left vessel", "patch", "ball"]
    assert summary(read)["surfaces"]["ball"] == {
        "count": 3, "kind": "loop subdivision", "subdivisions": 1,
        "first_time": 0.0, "last_time": 0.05,
    }  # fmt: skip


def test_everything_else_is_the_same_without_surfaces(result, tmp_path):
    without = "\n".join(line for line in SCENE.split("\n") if "surface of" not in line)
    with h5py.File(result) as one, h5py.File(run(without, tmp_path / "b.vtkhdf")) as other:
        assert "tissuec/surfaces" not in other
        for name in ("VTKHDF/Steps/Values", "VTKHDF/Points", "VTKHDF/PointData/velocity"):
            assert np.array_equal(one[name][:], other[name][:])


def test_every_dataset_says_what_it_is(result):
    with h5py.File(result) as file:
        surface, silent = file["tissuec/surfaces/left vessel"], []

        def visit(name, member):
            if isinstance(member, h5py.Dataset) and not member.attrs["description"]:
                silent.append(name)

        surface.visititems(visit)
        assert not silent
        assert surface["Points"].attrs["unit"] == "m"
        assert surface["Steps/Values"].attrs["unit"] == "s"


# --- writing ---


@pytest.mark.parametrize("single", [False, True])
def test_a_torn_skin_is_shown_torn_from_the_very_frame(tmp_path, example, single):
    example = example.recorded(surfaces=SURFACES, single=single)
    with Trajectory.open(example.saved(tmp_path / "a.vtkhdf")) as read:
        series = read.surfaces["tube"]
        kind = np.float32 if single else np.float64
        counts = [len(series.triangles(frame)) for frame in range(FRAMES)]
        assert counts == [512] * CUT + [384] * (RUPTURE - CUT) + [368] * (FRAMES - RUPTURE)
        for frame in (0, CUT, RUPTURE, FRAMES - 1):
            body = BodySkin.of(example.network, example.network.bodies[0])
            refined = FAMILY["loop subdivision"]().refine(body.at(example.alive(frame)))
            points = refined.at(example.position[frame, :20]).astype(kind)
            assert np.array_equal(series.position(frame), points)
    with h5py.File(tmp_path / "a.vtkhdf") as file:
        assert len(file["tissuec/surfaces/tube/NumberOfPoints"]) == 3


def test_the_size_of_a_batch_changes_no_byte(tmp_path, example, monkeypatch):
    example = example.recorded(surfaces=SURFACES)
    stored = []
    for size, batch in ((1 << 17, 7), (1, 7), (600, 2)):
        monkeypatch.setattr("tissuec.results.surface_table._MOST_AT_ONCE", size)
        with example.open(tmp_path / f"{size}.vtkhdf") as writer:
            example.write(writer, batch=batch)
            path = writer.close("done", finished=True)
        with h5py.File(path) as file:
            group = file["tissuec/surfaces/tube"]
            stored.append([group["Points"][:], group["Steps/PointOffsets"][:]])
    for one in stored[1:]:
        assert all(map(np.array_equal, one, stored[0]))


def test_numbers_that_are_none_are_named_and_not_written(tmp_path, example):
    bad = example.position.copy()
    bad[4, 3, 1] = np.nan
    with example.recorded(surfaces=SURFACES).open(tmp_path / "a.vtkhdf") as writer:
        writer.topology(example.alive(0))
        with pytest.raises(ValueError, match=r'position of node 4 of "tube" is nan at 0.16 s'):
            writer.surface("tube", example.time, bad)
        with pytest.raises(ValueError, match=r"position has shape \(40, 20, 3\), not"):
            writer.surface("tube", example.time, example.position[:, :20])
        with pytest.raises(ValueError, match='no surface of "rod" is recorded'):
            writer.surface("rod", example.time, example.position)
        path = writer.close("stopped", finished=False)
    with Trajectory.open(path) as read:
        assert len(read.surfaces["tube"]) == 0


# --- views ---


def test_names_of_views_are_names_of_files_and_differ(tmp_path):
    names = ["left vessel", "left_vessel", "a/b", "größe", "left-vessel"]
    paths = view_paths(tmp_path / "run.partial.vtkhdf", names)
    assert [path.name for path in paths.values()] == [
        "run.left_vessel.vtkhdf",
        "run.left_vessel_2.vtkhdf",
        "run.a_b.vtkhdf",
        "run.größe.vtkhdf",
        "run.left-vessel.vtkhdf",
    ]


def test_a_view_is_small_and_says_whose_it_is(result):
    view = result.with_name("a.left_vessel.vtkhdf")
    assert view.stat().st_size < 4096
    with pytest.raises(ResultError, match=r'surface of left vessel in "a.vtkhdf"; use that'):
        Trajectory.open(view)


def test_a_view_replaces_a_view_and_nothing_else(tmp_path, example):
    example, place = example.recorded(surfaces=SURFACES), tmp_path / "a.tube.vtkhdf"
    example.saved(tmp_path / "a.vtkhdf")
    example.saved(tmp_path / "a.vtkhdf")
    assert sorted(os.listdir(tmp_path)) == ["a.tube.vtkhdf", "a.vtkhdf"]
    place.write_text("keep me")
    with pytest.raises(PlaceError, match="for the surface of tube: it exists"):
        example.open(tmp_path / "a.vtkhdf")
    assert place.read_text() == "keep me"
    assert sorted(os.listdir(tmp_path)) == ["a.tube.vtkhdf", "a.vtkhdf"]


def test_an_unfinished_result_has_no_view(tmp_path, example):
    with example.recorded(surfaces=SURFACES).open(tmp_path / "a.vtkhdf") as writer:
        example.write(writer, last=9)
        writer.close("interrupted", finished=False)
    assert os.listdir(tmp_path) == ["a.partial.vtkhdf"]


# --- other programs ---


def shape_of(data):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    is_grid = hasattr(data, "GetCells")
    triangles = (data.GetCells() if is_grid else data.GetPolys()).GetConnectivityArray()
    return vtk_to_numpy(data.GetPoints().GetData()), vtk_to_numpy(triangles).reshape(-1, 3)


@pytest.mark.parametrize("name", ["left vessel", "patch", "ball"])
@pytest.mark.parametrize("way", ["view", "copy"])
def test_vtk_sees_every_frame_through_a_cut_in_any_order(result, read, name, way, tmp_path):
    path = view_paths(result, [name])[name]
    series = read.surfaces[name]
    if way == "copy":
        path = tmp_path / "copy.vtkhdf"
        export_surface(series, path)
    reader = opened(path)
    assert reader.GetNumberOfSteps() == len(series)
    order = np.random.default_rng(1).permutation(len(series))
    for frame in [*range(len(series)), *order.tolist()]:
        reader.SetStep(frame)
        reader.Update()
        assert reader.GetTimeValue() == series.times[frame]
        points, triangles = shape_of(reader.GetOutput())
        assert np.array_equal(points, series.position(frame))
        assert np.array_equal(triangles, series.triangles(frame))


def test_a_result_with_surfaces_shows_the_net_as_before(result, read):
    reader = opened(result)
    reader.SetStep(3)
    reader.Update()
    assert np.array_equal(points_of(reader.GetOutput()), read.position[3])


def test_surfaces_without_frames_open(tmp_path, example):
    with example.recorded(surfaces=SURFACES).open(tmp_path / "a.vtkhdf") as writer:
        writer.topology(example.alive(0))
        writer.close("done", finished=True)
    opened(tmp_path / "a.tube.vtkhdf").Update()


@pytest.mark.parametrize(
    ("write", "reader"),
    [
        (write_ply, "vtkIOPLY.vtkPLYReader"),
        (write_obj, "vtkIOGeometry.vtkOBJReader"),
        (write_vtu, "vtkIOXML.vtkXMLUnstructuredGridReader"),
    ],
)
def test_one_frame_is_read_from_each_format(read, tmp_path, write, reader):
    series, path = read.surfaces["patch"], tmp_path / "frame"
    write(surface_shape(series, 5), path)
    data = read_by_vtk(reader, path)
    points, triangles = shape_of(data)
    # VTK keeps points of PLY and OBJ in single precision.
    np.testing.assert_allclose(points, series.position(5), rtol=1e-6, atol=1e-9)
    assert np.array_equal(triangles, series.triangles(5))


def read_by_vtk(name, path):
    module, _, kind = name.partition(".")
    reader = getattr(pytest.importorskip(f"vtkmodules.{module}"), kind)()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def test_a_net_goes_into_ply_with_its_springs(read, tmp_path):
    from tissuec.results.export import frame_shape

    write_ply(frame_shape(read, 0), tmp_path / "net.ply")
    head, _, data = (tmp_path / "net.ply").read_bytes().partition(b"end_header\n")
    cells = read.cells(0)
    assert f"element edge {len(cells.lines)}".encode() in head
    assert len(data) == 24 * len(read.nodes) + 13 * len(cells.triangles) + 8 * len(cells.lines)
    lines = np.frombuffer(data[-8 * len(cells.lines) :], dtype="<i4").reshape(-1, 2)
    assert np.array_equal(lines, cells.lines)
    points, triangles = shape_of(read_by_vtk("vtkIOPLY.vtkPLYReader", tmp_path / "net.ply"))
    assert np.array_equal(triangles, cells.triangles)
    np.testing.assert_allclose(points, read.position[0], rtol=1e-6, atol=1e-9)


# --- resuming ---


def test_a_surface_of_a_grid_is_gone_on_with_to_the_same_bytes(result, tmp_path, monkeypatch):
    """Interrupt the scene in each of its parts, and resume it."""
    monkeypatch.setattr("tissuec.engine.execution.run.CHECKPOINT_EVERY", 0.0)
    request = Request(Source("scene.tis", SCENE))
    compiled, _ = compile_request(request)
    path = tmp_path / "b.vtkhdf"
    for moment, resume in ((0.012, False), (0.03, True), (0.05, True)):
        with pytest.raises(RuntimeError, match="pulled"):
            simulate(compiled, path, request=request, resume=resume, progress=pulled_at(moment))
    simulate(compiled, path, request=request, resume=True)
    with h5py.File(result) as whole, h5py.File(path) as resumed:
        names = []
        whole["tissuec/surfaces"].visit(names.append)
        assert len(names) > 50
        for name in names:
            one, other = whole["tissuec/surfaces"][name], resumed["tissuec/surfaces"][name]
            if isinstance(one, h5py.Dataset):
                assert np.array_equal(one[()], other[()]), name
        assert resumed["tissuec/surfaces/patch/Steps"].attrs["NSteps"] == 7


def pulled_at(moment):
    """Return what stops a run from outside, as a crash would."""

    def at(time):
        if time > moment:
            raise RuntimeError("the plug was pulled")

    return at


def test_a_surface_of_no_known_body_is_refused(tmp_path, example):
    surfaces = (SurfaceChannel("nobody", "loop subdivision", {"subdivisions": 1}),)
    with pytest.raises(ValueError, match='there is no body "nobody"'):
        example.recorded(surfaces=surfaces).open(tmp_path / "a.vtkhdf")
    assert os.listdir(tmp_path) == []
