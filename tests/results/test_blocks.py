"""VTK sees the parts of bodies, joints and tools of a blocks file with the numbers of a run."""

import json
import re

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.test_cli import tissuec
from tests.vtk_reading import LINE, TRIANGLE, VERTEX, cells_of, opened
from tissuec.compiler.anatomy import anatomy_of
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.engine.execution.recorder import wishes
from tissuec.pipeline import compile_request, simulate
from tissuec.results import PlaceError, ResultError
from tissuec.results.blocks.fields import fields_of
from tissuec.results.blocks.file import write_blocks
from tissuec.results.blocks.layout import Names
from tissuec.results.blocks.pieces import BlockFrames, write_series
from tissuec.results.instruments.meshes import mesh_of
from tissuec.results.paraview import blocks_path
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter
from tissuec.scene.request import Request, run_command

pytest.importorskip("vtkmodules.vtkIOHDF")
from vtkmodules.util.numpy_support import vtk_to_numpy

SCENE = """language 1
use "tissues/fat"
tissue gel { spring constant = 20 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
tissue silk { Young's modulus = 1 MPa; density = 1000 kg/m^3; retardation time = 1 ms }
body pad {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm; second edge = (0, 10, 0) mm
    rows = 3; columns = 3
  }
  tissue is fat
  interface is softer
  region far where x > 9 mm { tissue is fat; prestress = 1 % }
}
body cube {
  made of springs
  mesh is lattice {
    kind is sodium chloride; reach is second neighbours; cell = 5 mm
    box from (0, 0, 10) mm to (10, 10, 20) mm
  }
  tissue is gel
}
body "long thread" {
  mesh is thread { line from (0, 0, 30) mm to (10, 0, 30) mm; pieces = 4; thickness = 0.4 mm }
  tissue is silk
}
joint "a seam" { reach = 20 mm; springs from rim to low; tissue is fat }
set rim = nodes of pad where x < 1 mm
set low = nodes of cube where x < 1 mm and z < 11 mm
set other = nodes of pad where x > 9 mm
tool finger { kind is probe; radius = 2 mm; centre = (5, 5, 4) mm }
tool grip { kind is forceps }
tool shears { kind is scissors }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only }
script {
  at 0 s: fix rim
  at 10 ms: grasp other with grip
  from 0 s to 40 ms: move finger by (0, 0, -2) mm using constant speed
  at 25 ms: cut pad along plane through (7, 5, 0) mm facing (1, 0, 0) with shears
  at 35 ms: release grip
}
simulate { duration = 40 ms }
output { trajectory every 5 ms; blocks }
"""

SCENES = (
    "bladder", "hanging_net", "indentation", "ligature", "liver", "palpation", "rupture",
    "sterilisation", "suture", "tubal_ligation",
)  # fmt: skip


def run_to(folder, text, name="pad", **options):
    request = Request(Source(f"{name}.tis", text))
    compiled, _ = compile_request(request)
    path = folder / f"{name}.vtkhdf"
    return compiled, simulate(compiled, path, request=request, companion="off", **options)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A run with blocks beside it, and a copy of these in another folder."""
    folder = tmp_path_factory.mktemp("blocks")
    compiled, result = run_to(folder, SCENE)
    copied = tmp_path_factory.mktemp("elsewhere") / "copy.blocks.vtkhdf"
    with Trajectory.open(result.path) as trajectory:
        write_blocks(trajectory, anatomy_of(compiled), copied, links=False)
        yield compiled, trajectory, (result.blocks, copied)


def shown(reader, frame):
    """Return the blocks of a frame by name."""
    reader.SetStep(frame)
    reader.Update()
    data = reader.GetOutputDataObject(0)
    blocks = {}
    for number in range(data.GetNumberOfBlocks()):
        blocks[data.GetMetaData(number).Get(data.NAME())] = data.GetBlock(number)
    return blocks


def points(block):
    if not block.GetNumberOfPoints():
        return np.zeros((0, 3))
    return vtk_to_numpy(block.GetPoints().GetData())


def arrays(attributes):
    return {
        attributes.GetArrayName(n): vtk_to_numpy(attributes.GetArray(n))
        for n in range(attributes.GetNumberOfArrays())
    }


def at_points(block):
    return arrays(block.GetPointData())


def at_lines(block):
    return arrays(block.GetCellData())


def triangles(block):
    return cells_of(block, TRIANGLE)


def lines(block):
    return cells_of(block, LINE)


def test_blocks_are_bodies_joints_and_tools(made):
    for path in made[2]:
        assert list(shown(opened(path), 0)) == [
            "pad_springs", "pad_skin", "cube_springs", "cube_skin", "long_thread", "a_seam",
            "finger", "grip", "grip_held", "shears",
        ]  # fmt: skip


def test_every_frame_holds_the_numbers_of_the_result(made):
    _, trajectory, paths = made
    network = trajectory.network
    with h5py.File(trajectory.path) as file:
        positions = file["particles/all/position/value"][:]
    for path in paths:
        reader = opened(path)
        assert reader.GetNumberOfSteps() == len(trajectory.times) == 9
        for frame in (0, 8, 3, 5, 6):
            tension, rows = trajectory.spring_force(frame)
            tension = dict(
                zip(trajectory.springs[rows].tolist(), tension.tolist(), strict=True)
            )
            seen = set()
            for name, block in shown(reader, frame).items():
                at, along = at_points(block), at_lines(block)
                for numbers in (*at.values(), *along.values()):
                    assert np.isfinite(numbers).all()
                if name in ("finger", "grip", "shears"):
                    assert not along and set(at) == {"body"}
                    continue
                nodes = at["node"]
                assert np.array_equal(points(block), positions[frame, nodes])
                assert np.array_equal(
                    at["displacement"], positions[frame, nodes] - network.position[nodes]
                )
                for vectors in ("velocity", "force"):
                    assert np.array_equal(
                        at[vectors], getattr(trajectory, vectors)[frame, nodes]
                    )
                assert np.array_equal(at["node_id"], network.node_ids[nodes])
                if "spring" in along:
                    springs = along["spring"]
                    assert np.array_equal(nodes[lines(block)], network.springs.ends[springs])
                    assert along["spring_force"].tolist() == [tension[s] for s in springs]
                    assert np.array_equal(along["law"], network.springs.law[springs])
                    seen |= set(springs.tolist())
                elif len(nodes):
                    assert not along
            assert seen == set(tension)


def test_node_numbers_are_unique_over_all_bodies(made):
    blocks = shown(opened(made[2][0]), 0)
    nodes = np.concatenate(
        [at_points(blocks[name])["node"] for name in ("pad_skin", "cube_skin", "long_thread")]
    )
    assert sorted(nodes) == list(range(made[1].network.body_nodes))
    ids = [at_points(blocks[name])["node_id"] for name in ("pad_skin", "cube_skin")]
    assert set(ids[0]) & set(ids[1])


def test_a_cut_removes_lines_and_triangles(made):
    for path in made[2]:
        reader = opened(path)
        before, after = shown(reader, 4)["pad_springs"], shown(reader, 6)["pad_springs"]
        assert len(lines(before)) - len(lines(after)) == 3
        assert len(triangles(shown(reader, 6)["pad_skin"])) == 4
        assert len(triangles(shown(reader, 4)["pad_skin"])) == 8


def test_a_tool_without_a_shape_is_what_it_holds(made):
    compiled, _, paths = made
    other = np.flatnonzero(compiled.network.position[:9, 0] > 9e-3)
    for path in paths:
        reader = opened(path)
        held = [
            at_points(shown(reader, frame)["grip_held"]).get("node", []) for frame in range(9)
        ]
        assert [len(nodes) for nodes in held] == [0, 0, 3, 3, 3, 3, 3, 0, 0]
        assert np.array_equal(held[4], other)
        vertices = cells_of(shown(reader, 4)["grip_held"], VERTEX)
        assert vertices.tolist() == [[0], [1], [2]]


def test_tools_are_closed_surfaces_where_they_act(made):
    _, trajectory, paths = made
    for path in paths:
        reader = opened(path)
        blocks = [shown(reader, frame) for frame in range(9)]
        for name, frames in (("finger", range(9)), ("grip", range(2, 8)), ("shears", (5,))):
            for frame in range(9):
                block = blocks[frame][name]
                assert bool(len(triangles(block))) == (frame in frames)
                corners = triangles(block)
                edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
                assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
        for frame in (0, 5, 8):
            away = points(blocks[frame]["finger"]) - trajectory.tools[frame][0]
            distance = np.linalg.norm(away, axis=1)[: len(mesh_of("capsule").vertices)]
            assert distance.max() == pytest.approx(2e-3) and distance.min() > 1.9e-3
        # The blades lie in the plane of the cut, and both jaws at what they hold.
        assert points(blocks[5]["shears"])[:, 0] == pytest.approx(7.5e-3, abs=1e-3)
        held, jaws = points(blocks[4]["grip_held"]), points(blocks[4]["grip"])
        assert jaws[:, 0].min() < held[:, 0].max() and jaws[:, 2].max() > held[:, 2].max()


def test_poses_are_those_of_the_surfaces(made):
    for path in made[2]:
        with h5py.File(path) as file:
            group = file["tissuec/tools"]
            names = group["name"].asstr()[:].tolist()
            pose, opening, active = (group[name][:] for name in ("pose", "opening", "active"))
            assert all(group[name].attrs["description"] for name in group)
        assert names == ["finger", "grip", "shears"] and pose.shape == (9, 3, 7)
        assert np.linalg.norm(pose[..., 3:], axis=-1) == pytest.approx(1.0)
        assert active.T.tolist() == [
            [1] * 9,
            [0, 0, 1, 1, 1, 1, 1, 1, 0],
            [0] * 5 + [1] + [0] * 3,
        ]
        assert pose[:, 0, :3] == pytest.approx(made[1].tools[:, 0])
        assert (opening[:, 0] == 0.0).all() and (opening[2:8, 1] > 0.0).all()
        # The jaws as closed as they are, turned and moved, are the block but for their size.
        mesh = mesh_of("forceps")
        for frame in (2, 4, 7):
            local = mesh.posed(opening[frame, 1] / 2.0)
            turned = Rotation.from_quat(pose[frame, 1, 3:]).apply(local)
            shape = points(shown(opened(path), frame)["grip"]) - pose[frame, 1, :3]
            size = (turned * shape).sum() / (turned * turned).sum()
            assert np.abs(size * turned - shape).max() < 1e-9


def test_tissue_region_and_body_are_numbers_with_names(made):
    with h5py.File(made[2][1]) as file:
        data = file["VTKHDF/pad_springs"]
        names = {
            name: data["FieldData"][name].asstr()[:].tolist() for name in data["FieldData"]
        }
    assert names["name"] == ["pad springs"]
    assert names["body_names"] == ["pad", "cube", "long thread", "finger", "grip", "shears"]
    assert names["region_names"] == ["", "far of pad"]
    assert names["tissue_names"] == ["fat", "gel", "silk"]
    assert names["law_names"] == [law.name for law in made[1].network.springs.laws]
    at = at_points(shown(opened(made[2][0]), 0)["pad_springs"])
    assert set(at["body"]) == {0} and set(at["tissue"]) == {0}
    assert np.array_equal(
        at["region"], points(shown(opened(made[2][0]), 0)["pad_skin"])[:, 0] > 9e-3
    )


def test_only_matter_has_strain_and_stress(made):
    blocks = shown(opened(made[2][0]), 0)
    has = [name for name, block in blocks.items() if "stress" in at_points(block)]
    assert has == ["cube_springs", "cube_skin", "long_thread"]
    at = at_points(blocks["cube_skin"])
    assert at["strain"].shape == at["stress"].shape == (27, 6)
    assert (at["strain_directions"] == 3).all()
    # Along the thread alone.
    assert (at_points(blocks["long_thread"])["strain_directions"] == 1).all()


def test_tension_is_the_mean_of_the_springs_at_a_node(made):
    block = shown(opened(made[2][0]), 8)["cube_springs"]
    force, ends = at_lines(block)["spring_force"], lines(block)
    for node in (0, 13, 26):
        mean = force[(ends == node).any(axis=1)].mean()
        assert at_points(block)["tension"][node] == pytest.approx(mean, rel=1e-12, abs=1e-18)


def test_every_field_says_its_unit_and_what_it_is(made):
    with h5py.File(made[2][1]) as file:
        for block in file["VTKHDF"].values():
            for group in ("PointData", "CellData"):
                for dataset in block[group].values() if group in block else ():
                    assert "unit" in dataset.attrs and dataset.attrs["description"]
    fields = fields_of(made[1])
    assert len({(field.at, field.name) for field in fields}) == len(fields)


def test_rows_of_different_blocks_begin_at_different_places(made):
    """VTK 9.5 and 9.6 can take those of another block that begin at the same one."""
    with h5py.File(made[2][1]) as file:
        blocks = file["VTKHDF"]
        for name in ("node", "displacement", "tension"):
            starts = [
                set(blocks[block]["Steps/PointDataOffsets"][name][:].tolist())
                for block in ("pad_springs", "cube_springs", "long_thread", "a_seam")
            ]
            assert sum(map(len, starts)) == len(set.union(*starts))


def test_links_need_the_result_and_copies_do_not(made):
    _, trajectory, (linked, copied) = made
    with h5py.File(linked) as file:
        link = file["VTKHDF/pad_springs"].get("Points", getlink=True)
        assert (link.filename, link.path) == (trajectory.path.name, "/VTKHDF/Points")
    assert not copied.with_name(trajectory.path.name).exists()
    with h5py.File(copied) as file:  # two blocks of a body share what they have in common
        for name in ("Points", "PointData/velocity", "PointData/displacement"):
            assert file[f"VTKHDF/pad_springs/{name}"] == file[f"VTKHDF/pad_skin/{name}"]


@pytest.mark.parametrize("links", [True, False])
def test_one_frame_and_a_part_of_the_net_are_seen(tmp_path, links):
    text = SCENE.replace(
        "trajectory every 5 ms; blocks", "trajectory of [cube, far end] every 40 ms"
    )
    text = text.replace("set low", "set far end = nodes of pad where x > 1 mm\nset low", 1)
    once = text.replace("every 40 ms }", "every 50 ms }")
    for n, (one, frames) in enumerate(((text, 2), (once, 1))):
        compiled, result = run_to(tmp_path, one, name=f"part{n}")
        with Trajectory.open(result.path) as trajectory:
            path = tmp_path / f"a{n}.vtkhdf"
            write_blocks(trajectory, anatomy_of(compiled), path, links=links)
            reader = opened(path)
            for frame in range(frames):
                blocks = shown(reader, frame)
                assert list(blocks)[:4] == [
                    "pad_springs",
                    "pad_skin",
                    "cube_springs",
                    "cube_skin",
                ]
                for name in ("pad_springs", "cube_skin"):
                    nodes = at_points(blocks[name])["node"]
                    rows = np.searchsorted(trajectory.nodes, nodes)
                    place = trajectory.position[frame][rows]
                    assert np.array_equal(points(blocks[name]), place)
                assert "long_thread" not in blocks


def test_a_node_that_nothing_holds_is_a_block_of_its_own(tmp_path):
    text = SCENE.replace(
        "at 25 ms: cut pad along plane through (7, 5, 0) mm facing (1, 0, 0) with shears",
        "at 25 ms: cut corner",
    ).replace(
        "set low", "set corner = springs of pad where within 4 mm of (10, 10, 0) mm\nset low", 1
    )
    _, result = run_to(tmp_path, text)
    reader = opened(result.blocks)
    counts = [len(cells_of(shown(reader, frame)["pad_nodes"], VERTEX)) for frame in (0, 8)]
    assert counts == [0, 1]


def test_without_its_scene_a_result_has_blocks_without_tissues(made, tmp_path):
    path = tmp_path / "a.vtkhdf"
    write_blocks(made[1], None, path, links=False)
    blocks = shown(opened(path), 3)
    assert {"finger", "grip", "shears"} < set(blocks)
    at = at_points(blocks["cube_skin"])
    assert "tissue" not in at and "stress" not in at and "tension" in at


def test_what_is_no_blocks_file_is_not_replaced(tmp_path):
    path = blocks_path(tmp_path / "pad.vtkhdf")
    path.write_text("mine")
    with pytest.raises(PlaceError, match="exists and is not a blocks file"):
        run_to(tmp_path, SCENE)
    assert path.read_text() == "mine"
    path.unlink()
    run_to(tmp_path, SCENE)
    run_to(tmp_path, SCENE)  # one's own is
    with pytest.raises(ResultError, match=r'contains the blocks of "pad\.vtkhdf"'):
        Trajectory.open(path)


def test_blocks_need_a_trajectory(tmp_path):
    text = SCENE.replace("trajectory every 5 ms; blocks", "force of rim every 5 ms")
    with pytest.raises(PlaceError, match="records no trajectory"):
        run_to(tmp_path, text, blocks=True)
    _, result = run_to(tmp_path, text)
    assert result.blocks is None
    with (
        Trajectory.open(result.path) as trajectory,
        pytest.raises(ResultError, match="no frames"),
    ):
        write_blocks(trajectory, None, tmp_path / "a.vtkhdf", links=False)


def test_names_are_plain_and_unique():
    names = Names()
    assert [names.plain(one) for one in ("a b", "a_b", "A b", "Steps", "7 größe", "lö/ß")] == [
        "a_b", "a_b_2", "A_b_3", "Steps_2", "_7_gr__e", "l___",
    ]  # fmt: skip


# --- numbers that are known -------------------------------------------------------------------


def written(folder, compiled, frames, tension):
    """Return a moment's blocks of positions that are given, by name."""
    network = compiled.network
    recording = wishes(network, compiled.plan)
    count = len(frames)
    still = np.zeros((count, network.node_count, 3))
    with ResultWriter(folder / "a.vtkhdf", network, recording, {}, "") as writer:
        writer.topology(network.present)
        fields = {"force": still, "tension": tension}
        writer.frames(np.arange(count) * 0.1, np.array(frames), still, fields)
        path = writer.close("done", finished=True)
    with Trajectory.open(path) as trajectory:
        write_blocks(trajectory, anatomy_of(compiled), folder / "b.vtkhdf", links=True)
    return [shown(opened(folder / "b.vtkhdf"), frame) for frame in range(count)]


def test_a_homogeneous_strain_of_a_lattice_is_returned(tmp_path):
    compiled, _ = compile_request(Request(Source("a.tis", SCENE)))
    place = compiled.network.position
    stretched = place * (1.1, 1.0, 1.0)
    springs = np.zeros((2, compiled.network.spring_count))
    drawn, strained = written(tmp_path, compiled, [place, stretched], springs)
    exact = [0.5 * (1.1**2 - 1), 0, 0, 0, 0, 0]
    assert np.abs(at_points(drawn["cube_springs"])["strain"]).max() < 1e-12
    assert np.abs(at_points(strained["cube_springs"])["strain"] - exact).max() < 1e-12
    first, second = place[compiled.network.springs.ends.T]
    longer = np.linalg.norm((second - first) * (1.1, 1.0, 1.0), axis=1)
    drawn = np.linalg.norm(second - first, axis=1)
    found = at_lines(strained["cube_springs"])
    assert found["strain"] == pytest.approx((longer / drawn - 1)[found["spring"]], abs=1e-12)


BAR = """language 1
tissue gel { spring constant = 10 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
body bar { MESH; tissue is gel }
set left = nodes of bar where x < 0.1 mm
set right = nodes of bar where x > 29.9 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 2 mN*s/m }
script {
  at 0 s: fix left
  from 0 s to 0.2 s: move right by (1.5, 0, 0) mm using smooth profile
}
simulate { duration = 0.6 s; tolerance = 1e-4 }
output { trajectory every 100 ms; force of right every 100 ms; blocks }
"""
LATTICE = (
    "mesh is lattice { kind is KIND; reach is second neighbours; cell = 2.5 mm; "
    "box from (0, 0, 0) mm to (30, 10, 10) mm }"
)
WALL = (
    "mesh is sheet { corner = (0, 0, 0) mm; first edge = (30, 0, 0) mm; "
    "second edge = (0, 10, 0) mm; columns = 13; rows = 5; diagonals is both }; thickness = 1 mm"
)


@pytest.mark.parametrize(
    "mesh",
    [
        LATTICE.replace("KIND", "sodium chloride"),
        pytest.param(LATTICE.replace("KIND", "caesium chloride"), marks=pytest.mark.slow),
        WALL,
    ],
)
def test_mean_stress_of_a_pulled_net_is_its_force_over_its_section(tmp_path, mesh):
    text = BAR.replace("MESH", mesh)
    compiled, result = run_to(tmp_path, text)
    with Trajectory.open(result.path) as trajectory:
        pull = abs(np.asarray(trajectory.logs["force of right"].value)[-1, 0])
        frame = len(trajectory.times) - 1
    block = shown(opened(result.blocks), frame)["bar_springs"]
    drawn = compiled.network.position[at_points(block)["node"]]
    middle = np.isclose(drawn[:, 0], 15e-3)
    ends = points(block)[middle]
    height = 1e-3 if "sheet" in mesh else np.ptp(ends[:, 2])
    stress = pull / (np.ptp(ends[:, 1]) * height)
    across = [1] if "sheet" in mesh else [1, 2]
    # Nodes of a side stand for half as much of the section; springs in sides are as stiff as
    # those inside, so that it is the mean over the section that balances the force.
    at_side = np.isclose(np.abs(drawn[middle][:, across] - 5e-3), 5e-3)
    weight = np.where(at_side, 0.5, 1.0).prod(axis=1)
    found = at_points(block)["stress"][middle, 0]
    assert weight @ found / weight.sum() == pytest.approx(stress, rel=0.02)
    inner = middle & (np.abs(drawn[:, across] - 5e-3) < 2.6e-3).all(axis=1)
    assert inner.sum() == 3 ** len(across)
    assert np.abs(at_points(block)["stress"][inner, 3:]).max() < 0.02 * stress


# --- shipped scenes ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "sterilisation",
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in SCENES
            if one != "sterilisation"
        ),
    ],
)
def test_blocks_of_shipped_scenes_are_whole(tmp_path, name):
    pyvista = pytest.importorskip("pyvista")
    request = Request.file(library() / "scenes" / f"{name}.tis")
    compiled, _ = compile_request(request)
    result = simulate(
        compiled, tmp_path / f"{name}.vtkhdf", request=request, companion="off", blocks=True
    )
    reader, network = opened(result.blocks), compiled.network
    names = {tool.name.replace(" ", "_") for tool in compiled.scene.tools.values()}
    names |= {joint.name.replace(" ", "_") for joint in network.joints}
    names |= {body.name.replace(" ", "_") for body in network.bodies}
    frames = reader.GetNumberOfSteps()
    with Trajectory.open(result.path) as trajectory:
        assert frames == len(trajectory.times)
        for frame in np.linspace(0, frames - 1, 5).astype(int).tolist():
            blocks = shown(reader, frame)
            plain = {re.sub("_(springs|skin|held|jet)$", "", one) for one in blocks}
            assert plain - {"scalpel"} == names
            every = []
            for title, block in blocks.items():
                for numbers in (*at_points(block).values(), *at_lines(block).values()):
                    assert np.isfinite(numbers).all()
                nodes = at_points(block).get("node", np.zeros(0, dtype=int))
                if title.endswith("_springs") or title in network.threads:
                    every.append(nodes)
                if len(nodes) and nodes.max() < network.body_nodes:
                    rows = np.searchsorted(trajectory.nodes, nodes)
                    assert np.array_equal(points(block), trajectory.position[frame][rows])
            every = np.concatenate(every)
            assert len(np.unique(every)) == len(every)
        read = pyvista.read(result.path)
        assert np.array_equal(read.points, trajectory.position[0])
        assert set(trajectory.nodes) <= set(range(network.body_nodes))
        assert all(np.isfinite(read[array]).all() for array in read.array_names)
    assert len(pyvista.read(result.blocks)) == len(blocks)
    if name == "sterilisation":
        counts = [len(lines(shown(reader, frame)["oviduct_springs"])) for frame in (17, 18)]
        assert counts == [610, 580]


# --- single frames ----------------------------------------------------------------------------


def test_frames_as_xml_hold_the_same_blocks(made, tmp_path):
    xml = pytest.importorskip("vtkmodules.vtkIOXML")
    compiled, trajectory, paths = made
    frames = BlockFrames(trajectory, anatomy_of(compiled))
    files = [tmp_path / f"pad_{number:04}.vtm" for number in range(9)]
    for number, file in enumerate(files):
        frames.write(number, file, f"_{number:04}")
    write_series(files, trajectory.times, tmp_path / "pad.pvd")
    reader = opened(paths[0])
    for number in (0, 4, 8):
        multi = xml.vtkXMLMultiBlockDataReader()
        multi.SetFileName(str(files[number]))
        multi.Update()
        data, expected = multi.GetOutput(), shown(reader, number)
        assert data.GetNumberOfBlocks() == len(expected)
        for index, (name, block) in enumerate(expected.items()):
            found = data.GetBlock(index)
            assert data.GetMetaData(index).Get(data.NAME()) == name
            assert np.array_equal(points(found), points(block))
            assert (
                found.GetFieldData().GetArray("TimeValue").GetValue(0)
                == trajectory.times[number]
            )
            title = found.GetFieldData().GetAbstractArray("name").GetValue(0)
            assert title.replace(" ", "_") == name
            for one, other in (
                (at_points(found), at_points(block)),
                (at_lines(found), at_lines(block)),
            ):
                if block.GetNumberOfPoints():
                    assert one.keys() == other.keys()
                    for key in one:
                        assert np.array_equal(one[key], other[key]), (name, key)
            assert np.array_equal(cells_of(found, VERTEX), cells_of(block, VERTEX))
            assert np.array_equal(triangles(found), triangles(block))
    assert sorted(p.name for p in (tmp_path / "pad").glob("grip_*")) == [
        f"grip{part}_{number:04}.vtu" for part in ("", "_held") for number in range(9)
    ]


def test_the_series_opens_in_pyvista_with_its_times(made, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    frames = BlockFrames(made[1], None)
    frames.write(3, tmp_path / "one.vtm")
    write_series([tmp_path / "one.vtm"], [0.25], tmp_path / "all.pvd")
    reader = pyvista.get_reader(tmp_path / "all.pvd")
    assert reader.time_values == [0.25]
    assert reader.read()[0].keys()[:2] == ["pad_springs", "pad_skin"]
    assert pyvista.read(tmp_path / "one" / "pad_skin.vtu").n_cells == 8


# --- commands ---------------------------------------------------------------------------------


def test_commands_write_blocks_and_say_so(tmp_path):
    (tmp_path / "pad.tis").write_text(SCENE.replace("; blocks }", " }"))
    done = tissuec("run", "pad.tis", "--blocks", "--companion", "off", "--json", cwd=tmp_path)
    document = json.loads(done.stdout)
    assert (document["blocks"], document["left_out"]) == ("pad.blocks.vtkhdf", [])
    names = list(shown(opened(tmp_path / "pad.blocks.vtkhdf"), 0))
    done = tissuec("export", "pad.vtkhdf", "-o", "copy.blocks.vtkhdf", "--json", cwd=tmp_path)
    assert json.loads(done.stdout) == {
        "ok": True, "file": "copy.blocks.vtkhdf", "frames": 9, "blocks": names, "left_out": [],
    }  # fmt: skip
    done = tissuec("export", "pad.vtkhdf", "--all", "-o", "a.vtm", cwd=tmp_path)
    assert "wrote 9 frames to a_0000.vtm … a_0008.vtm" in done.stderr
    assert (tmp_path / "a.pvd").exists()
    for options, message in (
        (["--surface", "pad", "-o", "a.blocks.vtkhdf"], "remove --surface"),
        (["--all", "-o", "a.blocks.vtkhdf"], "remove --all"),
        (["-o", "a.vtkhdf"], "a name that ends with .blocks.vtkhdf"),
    ):
        refused = tissuec("export", "pad.vtkhdf", *options, cwd=tmp_path)
        assert refused.returncode == 2
        assert message in " ".join(refused.stderr.split())


def test_what_is_left_out_is_said(tmp_path):
    solid = SCENE.replace(
        "at 0 s: fix rim", "at 0 s: fix rim\n  at 1 ms: preserve volume of cube with 1 kPa"
    )
    _, result = run_to(tmp_path, solid)
    assert result.left_out == (
        "cube has no strain and stress: the volume that it keeps is set by the script "
        "(pad.tis:36)",
    )
    blocks = shown(opened(result.blocks), 3)
    assert "stress" not in at_points(blocks["cube_skin"])
    assert "stress" in at_points(blocks["long_thread"])


def test_the_command_that_resumes_a_run_writes_blocks_too():
    assert run_command("a.tis", (), resume=True, blocks=True) == (
        "tissuec run a.tis --resume --blocks"
    )
