"""Fields of frames, pressures of cells and those of a plug-in: from the run to all readers."""

import h5py
import numpy as np
import pytest

import tissuec
from tests.vtk_reading import opened
from tissuec.core import units
from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.results.blocks.file import write_blocks
from tissuec.results.export import frame_shape
from tissuec.results.fields import FIELDS, FieldChannel, FrameField
from tissuec.results.moments import Moments
from tissuec.results.trajectory import Trajectory
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.verbs.preserve import Preserve
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.node_values import read_fields
from tissuec.view.player.options import Options
from tissuec.view.player.packing import Pack, Quantization, pack_fields
from tissuec.view.player.reading import read_film
from tissuec.view.plots.frame_contents import FrameNumbers
from tissuec.view.plots.frames import FramesPlot, Shown

SCENE = """language 1
tissue soft { spring constant = 5 N/m; viscosity = 20 mN*s/m; mass = 0.1 g }
body cube {
  mesh is lattice {
    kind is braced cubes; cell = 1 cm; box from (0, 0, 0) mm to (20, 10, 10) mm
  }
  tissue is soft
}
body other {
  mesh is sphere { centre = (50, 0, 0) mm; radius = 5 mm; subdivisions = 1 }
  tissue is soft
}
environment { gravity = (0, 0, 0) m/s^2 }
set left = nodes of cube where x < 1 mm
set middle = nodes of cube where x between 9 mm and 11 mm
set right = nodes of cube where x > 19 mm
set edge = springs of cube where x > 19 mm and y < 1 mm
simulate { duration = 20 ms }
script {
  at 0 s: { fix left; fix middle; preserve volume of cube with 10 kPa }
  from 0 s to 20 ms: move right by (-4, 0, 0) mm using constant speed
  at 11 ms: cut edge
  at 16 ms: preserve volume of other with 1 kPa
}
output { trajectory with [FIELDS] every 5 ms; pressure of cube every 5 ms }
"""
MODULUS = 1e4
SCALE = Quantization((0.0, 0.0, 0.0), 1e-6)
#: Of the two cells, the left one keeps its shape; the right one shrinks, and is torn at 11 ms.
PRESSED = MODULUS * 0.4 * np.array([0.0, 0.25, 0.5, 0.0, 0.0])


class KineticEnergy(FrameField):
    at = "node"
    dimension = units.ENERGY
    text = "kinetic energy of each node"

    @staticmethod
    def sample(snapshot):
        return 0.5 * snapshot.state.mass * (snapshot.velocity**2).sum(axis=-1)


class Stretch(FrameField):
    at = "spring"
    dimension = units.NUMBER
    text = "stretch of each spring"
    signed = True

    @staticmethod
    def sample(snapshot):
        ends = snapshot.position[..., snapshot.state.network.springs.ends, :]
        length = np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1)
        return length / snapshot.state.network.springs.rest - 1.0


class Area(FrameField):
    at = "triangle"
    dimension = units.AREA
    text = "area of each triangle of the skin"

    @staticmethod
    def sample(snapshot):
        return areas(snapshot.position[..., snapshot.state.network.skin, :])


#: What a plug-in adds, in its one file.
MEMBERS = {"kinetic energy": KineticEnergy, "stretch": Stretch, "area": Area}


def areas(corners):
    sides = corners[..., 1:, :] - corners[..., :1, :]
    return 0.5 * np.linalg.norm(np.cross(sides[..., 0, :], sides[..., 1, :]), axis=-1)


@pytest.fixture(scope="module")
def plugged():
    len(FIELDS)  # which imports those that are shipped
    for name, member in MEMBERS.items():
        FIELDS.member(name)(member)
    yield
    for name in MEMBERS:
        del FIELDS._members[name]


@pytest.fixture(scope="module")
def path(plugged, tmp_path_factory):
    path = tmp_path_factory.mktemp("fields") / "cube.vtkhdf"
    asked = ", ".join([*MEMBERS, "pressure"])
    with tissuec.run(SCENE.replace("FIELDS", asked), out=path, companion="off"):
        return path


@pytest.fixture(scope="module")
def result(path):
    with Trajectory.open(path) as result:
        yield result


def test_pressure_of_a_shrinking_cell_is_its_modulus_times_the_part_that_is_lost(result):
    pressure = result.fields["pressure"]
    assert pressure.unit == "Pa"
    assert np.array(pressure)[:, 1] == pytest.approx(PRESSED, rel=1e-9, abs=1e-9)
    measured = result.logs["pressure of cube"].value[:, 0]
    assert np.array(pressure)[:, :2].mean(axis=1) == pytest.approx(measured, rel=1e-12)


def test_a_cell_has_no_pressure_before_it_is_preserved_and_after_it_is_torn(result):
    pressure, sides = result.fields["pressure"], result.sides
    assert result.volume_cells.bodies == ("cube", "other")
    assert result.volume_cells.total == 3
    assert not np.array(pressure)[:, [0, 2]].any()
    cut = int(np.abs(sides.times - 0.011).argmin())
    before, after = (sides.fields["pressure"][side] for side in (cut, cut + 1))
    assert before[1] == pytest.approx(MODULUS * 0.4 * 11 / 20, rel=1e-9)
    assert not after.any()


def test_fields_are_computed_from_the_motion_that_is_recorded(result):
    network, place = result.network, np.array(result.position)
    kinetic = 0.5 * network.mass * (np.array(result.velocity) ** 2).sum(axis=-1)
    assert np.array(result.fields["kinetic energy"]) == pytest.approx(kinetic, rel=1e-12)
    stretch = np.array(result.fields["stretch"])
    ends = place[:, result.ends]
    length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1)
    expected = length / network.springs.rest[result.springs] - 1.0
    gone = np.isnan(np.array(result.tension))
    assert gone.any()
    assert np.array_equal(np.isnan(stretch), gone)
    assert stretch[~gone] == pytest.approx(expected[~gone], rel=1e-12, abs=1e-15)
    area = np.array(result.fields["area"])
    there = np.isfinite(area)
    assert np.array_equal(there.sum(axis=1), [len(result.cells(n).triangles) for n in range(5)])
    assert not there.all()
    assert area[there] == pytest.approx(areas(place[:, result.triangles])[there], rel=1e-12)


def test_both_sides_of_events_have_all_fields(result):
    moments = Moments.of(result, np.arange(len(result.times)))
    row = int(np.flatnonzero(moments.sides >= 0)[0])
    place = moments.vectors_in("position", row)
    (channel,) = [one for one in result.channels if one.name == "area"]
    numbers, triangles = moments.shown(channel, row + 1)
    assert numbers == pytest.approx(areas(place[result.triangles[triangles]]), rel=1e-9)
    assert len(triangles) < len(moments.shown(channel, row)[0]) == len(result.triangles)


def test_one_number_at_each_node_is_the_mean_around_it(result):
    moments = Moments.of(result, np.arange(len(result.times)))
    row = int(np.flatnonzero(moments.frames == 2)[0])
    found = {one.name: moments.at_nodes(one, row) for one in result.channels}
    cells = result.volume_cells.pairs
    inner = cells[cells[:, 1] == 1, 0]
    edge = np.setdiff1d(inner, cells[cells[:, 1] == 0, 0])
    assert found["pressure"][edge] == pytest.approx(PRESSED[2], rel=1e-9)
    both = np.intersect1d(inner, cells[cells[:, 1] == 0, 0])
    assert found["pressure"][both] == pytest.approx(PRESSED[2] / 2, rel=1e-9)
    force = np.linalg.norm(result.force[2], axis=1)
    assert found["force"] == pytest.approx(force, rel=1e-12)
    node, last = 5, result.cells(2)
    own = (last.triangles == node).any(axis=1)
    corners = result.position[2][last.triangles[own]]
    assert found["area"][node] == pytest.approx(areas(corners).mean(), rel=1e-12)
    own = (last.lines == node).any(axis=1)
    assert found["stretch"][node] == pytest.approx(
        result.fields["stretch"][2][
            np.searchsorted(result.springs, last.line_numbers[own])
        ].mean()
    )


def test_files_say_unit_and_text_and_h5md_shows_nodes(path):
    with h5py.File(path) as file:
        for place, unit in {
            "VTKHDF/PointData/kinetic_energy": "J", "VTKHDF/CellData/stretch": "",
            "VTKHDF/CellData/area": "m^2", "VTKHDF/PointData/pressure": "Pa",
            "tissuec/cells/pressure": "Pa", "tissuec/sides/pressure": "Pa",
        }.items():  # fmt: skip
            assert file[place].attrs["unit"] == unit
            assert file[place].attrs["description"]
        assert (
            "kinetic energy of each node"
            in file["VTKHDF/PointData/kinetic_energy"].attrs["description"]
        )
        view = file["particles/all/kinetic_energy/value"]
        assert np.array_equal(view[:].ravel(), file["VTKHDF/PointData/kinetic_energy"][:])


def test_exports_and_tables_have_all_fields(result):
    shape = frame_shape(result, 2)
    assert {"kinetic_energy", "pressure"} <= set(shape.point_data)
    rows = shape.grid.rows
    own = shape.cell_data["area"]
    assert own[rows["triangle"]] == pytest.approx(areas(shape.points[shape.triangles]))
    assert not own[: rows["triangle"].start].any()
    assert shape.cell_data["stretch"][rows["spring"]].any()
    pytest.importorskip("xarray")
    data = tissuec.load(result.path).to_xarray("pressure", "area", "kinetic_energy")
    assert data["pressure"].dims == ("time", "cell")
    assert data["area"].dims == ("time", "triangle")
    assert data["kinetic_energy"].attrs == {
        "units": "J", "long_name": "kinetic energy of each node",
    }  # fmt: skip


def test_a_file_is_read_without_the_plug_in(path, plugged):
    taken = {name: FIELDS._members.pop(name) for name in MEMBERS}
    try:
        with Trajectory.open(path) as result:
            assert result.fields["kinetic energy"].unit == "J"
            assert result.channels[2:] == (
                FieldChannel("kinetic energy", "node", "J", 1, "kinetic energy of each node",
                             "kinetic_energy", False),
                FieldChannel("stretch", "spring", "", 1, "stretch of each spring", "stretch",
                             True),
                FieldChannel("area", "triangle", "m^2", 1, "area of each triangle of the skin",
                             "area", False),
                FieldChannel.of("pressure"),
            )  # fmt: skip
    finally:
        FIELDS._members.update(taken)


def test_vtk_finds_fields_in_the_result_and_in_blocks(path, result):
    reader = opened(path)
    reader.SetStep(2)
    reader.Update()
    whole, shape = arrays(reader.GetOutput()), frame_shape(result, 2)
    for name in ("kinetic_energy", "pressure", "area", "stretch"):
        assert np.array_equal(whole[name], (shape.point_data | shape.cell_data)[name])
    for links in (True, False):
        blocks = path.with_name(f"{links}.blocks.vtkhdf")
        write_blocks(result, None, blocks, links=links)
        reader = opened(blocks)
        reader.SetStep(2)
        reader.Update()
        found = reader.GetOutputDataObject(0)
        parts = {
            found.GetMetaData(n).Get(found.NAME()): arrays(found.GetBlock(n))
            for n in range(found.GetNumberOfBlocks())
        }
        own = result.network.bodies[0].nodes
        springs, skin = parts["cube_springs"], parts["cube_skin"]
        for name in ("kinetic_energy", "pressure"):
            assert np.array_equal(springs[name], shape.point_data[name][own])
        count = len(springs["cells stretch"])
        cells = result.cells(2)
        assert np.array_equal(
            springs["cells stretch"],
            shape.cell_data["stretch"][shape.grid.rows["spring"]][:count],
        )
        corners = shape.points[cells.triangles[: len(skin["cells area"])]]
        assert skin["cells area"] == pytest.approx(areas(corners), rel=1e-12)
        moments = Moments.of(result, np.arange(5))
        (channel,) = [one for one in result.channels if one.name == "area"]
        row = int(np.flatnonzero(moments.frames == 2)[0])
        assert skin["area"] == pytest.approx(moments.at_nodes(channel, row)[own], rel=1e-12)


def arrays(data):
    """Return the arrays of VTK at points and, under "cells NAME" as well, at cells."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    found = {}
    for group, prefix in ((data.GetCellData(), "cells "), (data.GetPointData(), "")):
        for number in range(group.GetNumberOfArrays()):
            name, values = group.GetArrayName(number), vtk_to_numpy(group.GetArray(number))
            found[prefix + name] = values
            found.setdefault(name, values)
            if not prefix:
                found[name] = values
    return found


def test_pages_and_pictures_have_all_fields(result):
    nodes = DrawnNodes(read_film(result, Options()), result)
    moments = Moments.of(result, np.arange(len(result.times)))
    found = {one.field.name: one for one in read_fields(nodes, None)}
    for channel in result.channels[2:]:
        values, row = found[channel.name], len(moments) - 3
        expected = moments.at_nodes(channel, row)
        assert values.value[row] == pytest.approx(expected, rel=1e-6, nan_ok=True)
        assert values.field.unit == channel.unit
    assert found["stretch"].is_signed
    assert not found["area"].is_signed
    pack = Pack()
    told = {one["name"]: one for one in pack_fields(nodes, None, pack, SCALE)["fields"]}
    for channel in result.channels[2:]:
        assert told[channel.name]["about"] == channel.at_nodes
        assert pack.specs[f"field {channel.name}"]["shape"] == list(nodes.displacement.shape)


@pytest.mark.parametrize(("show", "name"), [("springs", "stretch"), ("skin", "area")])
def test_frames_are_plotted_by_the_numbers_of_a_field(result, show, name):
    pytest.importorskip("matplotlib")
    shown = Shown.of(FramesPlot(times=(0.005,), show=show, field=name), result)
    numbers, _ = result.shown(name, 1)
    assert shown.numbers is not None
    own = shown.numbers.of_lines(1) if show == "springs" else shown.numbers.of_triangles(1)
    assert np.array_equal(own, numbers)
    mixed = FrameNumbers.of(result, "kinetic energy", [1])
    energy = result.fields["kinetic energy"][1]
    ends = result.ends[result.shown("stretch", 1)[1]]
    assert mixed.of_lines(1) == pytest.approx(energy[ends].mean(axis=1), rel=1e-6)
    assert mixed.unit == "J"
    with pytest.raises(TissueError, match="a scene records it by: trajectory with charge"):
        FrameNumbers.of(result, "charge", [1])


@pytest.mark.parametrize("name", sorted(FIELDS))
def test_every_member_has_numbers_of_all_that_it_is_about(name):
    field, compiled = FIELDS[name], tissuec.compile(SCENE.replace("FIELDS", "pressure"))
    state = compiled.plan.start(compiled.network)
    for event in compiled.plan.events:
        if event.time == 0.0 and isinstance(event.action, Preserve):
            event.action.apply(state, None)
    network, snapshot = state.network, Snapshot.of(state)
    count = {
        "node": network.node_count, "spring": network.spring_count,
        "triangle": len(network.skin),
        "cell": sum(one.item_count for one in state.enclosures.values()),
        "element": sum(one.item_count for one in state.of_kind("elements")),
    }[field.at]  # fmt: skip
    row = (field.width,) if field.width > 1 else ()
    batch = replace(
        snapshot,
        time=np.zeros(2),
        position=np.stack([snapshot.position] * 2),
        velocity=np.stack([snapshot.velocity] * 2),
    )
    for sample, shape in ((snapshot, (count, *row)), (batch, (2, count, *row))):
        found = field.sample(sample)
        assert found.shape == shape
        assert np.isfinite(found).all()
    assert field.text[0].islower()
    assert not field.text.endswith(".")
    assert {1: True, 3: field.at == "node", 6: field.at == "element"}[field.width]
    stored = [FieldChannel.of(other).stored for other in FIELDS]
    assert stored.count(FieldChannel.of(name).stored) == 1


@pytest.mark.parametrize(
    ("asked", "message", "hint"),
    [
        ("presure", '"presure" is not a field of frames', 'did you mean "pressure"?'),
        ("force", "every trajectory contains the force of each node", "omit it"),
        ("pressure, pressure", '"pressure" is given twice', "remove one of them"),
    ],
)
def test_fields_that_cannot_be_asked_for_are_errors(asked, message, hint):
    with pytest.raises(TissueError) as caught:
        tissuec.compile(SCENE.replace("FIELDS", asked))
    assert message in str(caught.value)
    assert hint in str(caught.value)
