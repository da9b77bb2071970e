"""A body whose cells were cut: two pieces with a gap, wherever it is shown."""

import json

import h5py
import numpy as np
import pytest

from tests.results.cut_block import CUT, FRAMES, SCENE, SHARE, TIMES, H, cut_block
from tests.vtk_reading import frame, opened
from tissuec.core.structs import replace
from tissuec.model.cut_cells import CutCells
from tissuec.results.conversion import to_pyvista
from tissuec.results.export import frame_shape
from tissuec.results.shapes import WRITERS, write_vtu
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter

pyvista = pytest.importorskip("pyvista")

NAMES = ("a.vtkhdf", "b.vtkhdf")
BEHIND, WHOLE = (1 + SHARE) * 4 * H**3, 16 * H**3  # volumes of the piece and the block


def near(value):
    return pytest.approx(value, rel=1e-12, abs=0.0)


@pytest.fixture(scope="module")
def block():
    return cut_block()


@pytest.fixture(scope="module")
def path(block, tmp_path_factory):
    return block.saved(tmp_path_factory.mktemp("cut") / "block.vtkhdf")


def check_pieces(grid):
    """Check the volumes of both pieces, and that there are two."""
    assert grid.integrate_data()["Volume"][0] == near(WHOLE)
    pieces = grid.connectivity().split_bodies()
    found = sorted(one.integrate_data()["Volume"][0] for one in pieces)
    assert found == near([BEHIND, WHOLE - BEHIND])


def test_vtk_shows_both_pieces_and_the_gap(path):
    before, after = frame(path, 0), frame(path, FRAMES - 1)
    assert before.n_cells == 16 and before.n_points == 63
    assert before.integrate_data()["Volume"][0] == near(WHOLE)
    assert set(after.celltypes) == {10, 12}
    assert (after.celltypes == 12).sum() == 12 and (after.celltypes == 10).sum() == 48
    check_pieces(after)
    assert after.compute_cell_sizes()["Volume"].min() > 0.0
    # The last frame is turned by half a radian; a plane within the gap meets nothing.
    along = np.array([np.cos(0.5), np.sin(0.5), 0.0])
    gap = along * ((1 + SHARE) * H + 2.5e-3)
    assert after.slice(normal=along, origin=gap).n_cells == 0
    behind = after.slice(normal=along, origin=along * 1.3 * H)
    assert behind.area == pytest.approx(4 * H**2, rel=1e-9, abs=0.0)
    clipped = after.clip(normal=along, origin=gap)
    assert clipped.integrate_data()["Volume"][0] == near(BEHIND)


def test_numbers_at_points_and_cells_belong_to_what_has_them(block, path):
    """Points are sums of nodes, forces add up, and parts have the numbers of their entities."""
    weights = np.zeros((18, 63))
    for point, (low, high) in enumerate(block.table.points.hosts.reshape(-1, 2)):
        weights[point, [low, high]] = 1.0 - SHARE, SHARE
    for number in range(FRAMES):
        grid, place = frame(path, number), block.position(number)
        fields = block.fields(slice(number, number + 1))
        rider = weights if number >= CUT else weights[:0]
        points = np.concatenate([place, rider @ place])
        np.testing.assert_allclose(grid.points, points, rtol=0.0, atol=1e-17)
        np.testing.assert_allclose(grid["velocity"], 2.0 * points, rtol=0.0, atol=1e-17)
        stress = fields["von Mises stress"][0]
        stress = np.concatenate([stress, rider @ stress])
        np.testing.assert_allclose(grid["von_mises_stress"], stress, rtol=1e-15, atol=0.0)
        assert np.array_equal(grid["force"][:63], fields["force"][0])
        assert not grid["force"][63:].any()
        ids = np.concatenate([np.arange(63), np.full(len(rider), -1)])
        assert np.array_equal(grid["node_id"], ids)
        cells = grid.cell_centers().points
        assert set(grid.cell_data) == {"region", "tissue", "fibres", "stress"}
        turned = cells[:, 0] * np.cos(0.1 * number) + cells[:, 1] * np.sin(0.1 * number)
        assert np.array_equal(grid["region"] == 1, turned < 2 * H) or number >= CUT
        assert np.array_equal(grid["fibres"], np.tile([0.0, 1.0, 0.0], (len(cells), 1)))
        if number >= CUT:
            entity = np.concatenate(
                [np.setdiff1d(block.solid.walls, block.crossed), np.repeat(block.parts, 6)]
            )
            assert np.array_equal(grid["stress"], np.tile(entity[:, None], (1, 6)))
            assert np.array_equal(grid["region"][12:], np.ones(48))


def test_arrays_of_nodes_stay_those_of_nodes(block, path):
    place = block.positions()
    with Trajectory.open(path) as result, h5py.File(path) as file:
        assert np.array_equal(result.position[:], place)
        assert np.array_equal(result.position[[1, 4], 3], place[[1, 4], 3])
        assert np.array_equal(result.velocity[-1], 2.0 * place[-1])
        assert np.array_equal(file["particles/all/position/value"][()], place)
        assert np.array_equal(file["particles/all/force/value"][()], place + 1.0)
        table = result.cut_cells
        for frame in range(FRAMES):
            assert len(result.points(frame)) == (63 if frame < CUT else 81)
            every = table.points.beside(result.position[frame])
            drawn = result.cells(frame).points
            np.testing.assert_allclose(result.points(frame), every[:drawn], atol=1e-17)
        for name in ("parts", "wholes", "corners", "owners", "triangles", "borders", "cuts"):
            assert np.array_equal(getattr(table, name), getattr(block.table, name)), name
        stress = result.fields["stress tensor"]
        assert stress.shape == (FRAMES, 24, 6)
        items = np.concatenate([block.solid.walls, block.parts])
        for frame in (0, FRAMES - 1):
            alive = block.alive(frame)[items]
            assert np.array_equal(stress[frame][alive, 0], items[alive])
            assert np.isnan(stress[frame][~alive]).all()


def test_a_surface_of_pieces_is_closed(path):
    """Skin, outer triangles of parts and faces of the cut bound both pieces."""
    with Trajectory.open(path) as result:
        for frame in range(FRAMES):
            points, triangles = result.points(frame), result.cells(frame).triangles
            a, b, c = points[triangles].swapaxes(0, 1)
            across = np.cross(b - a, c - a)
            assert np.abs(across.sum(axis=0)).max() < 1e-12 * np.abs(across).sum()
            volume = np.einsum("tx,tx->", a, across) / 6.0
            assert volume == near(WHOLE)
            assert not len(result.cells(frame).vertices)


@pytest.mark.parametrize("checkpoint", range(1, FRAMES))
def test_a_resumed_run_writes_the_same_file(block, tmp_path, checkpoint):
    from tests.results.test_resume import content

    def written(name, *, broken):
        writer = block.open(tmp_path / name)
        block.write(writer, checkpoints=(checkpoint, *(() if broken else (FRAMES,))))
        if not broken:
            return writer.close("done", finished=True)
        path = writer.close("interrupted", finished=False)
        with Trajectory.open(path) as begun:
            kept = begun.checkpoint()
        again = ResultWriter.resume(path, kept)
        assert (again.cut_cells is None) == (checkpoint <= CUT)
        block.write(again, first=kept.state["frame"], checkpoints=(FRAMES,))
        return again.close("done", finished=True)

    whole, resumed = (content(written(name, broken=name == "b.vtkhdf")) for name in NAMES)
    assert whole.keys() == resumed.keys()
    for one in (whole, resumed):  # whose order is that in which columns were made or opened
        one["tissuec/checkpoint/rows"] = json.loads(one["tissuec/checkpoint/rows"])
    for name, data in whole.items():
        np.testing.assert_equal(resumed[name], data, err_msg=name)
    with Trajectory.open(tmp_path / NAMES[1]) as result:
        assert result.mesh.cut is not None


def test_an_exported_frame_is_the_same(path, tmp_path):
    with Trajectory.open(path) as result:
        for number in (0, CUT, FRAMES - 1):
            shape = frame_shape(result, number)
            write_vtu(shape, tmp_path / "frame.vtu")
            grid, other = pyvista.read(tmp_path / "frame.vtu"), frame(path, number)
            for one in (grid, to_pyvista(shape)):
                assert np.array_equal(one.points, other.points)
                assert np.array_equal(one.cells, other.cells)
                for data in ("velocity", "node_id", "stress", "region", "force"):
                    assert np.array_equal(one[data], other[data]), data
        for ending in ("obj", "ply"):
            WRITERS[ending](shape, tmp_path / f"frame.{ending}")
            skin = pyvista.read(tmp_path / f"frame.{ending}")
            assert skin.volume == pytest.approx(WHOLE, rel=1e-5, abs=0.0)


def test_frames_of_one_side_show_what_they_contain(block, tmp_path):
    """Of a part of a body, they show surfaces, also those of its parts of elements."""
    behind = np.flatnonzero(~block.front)
    ends = block.network.line_ends
    lines = np.flatnonzero(np.isin(ends, behind).all(axis=1))
    recording = block.recording(nodes=behind, lines=lines, single=True)
    path = block.saved(tmp_path / "part.vtkhdf", recording)
    grid = frame(path, FRAMES - 1)
    assert set(grid.celltypes) == {5}
    area = 4 * H**2 + 4 * 2 * H * (1 + SHARE) * H + 4 * H**2  # left, around, and the cut
    assert grid.area == pytest.approx(area, rel=1e-6, abs=0.0)
    with Trajectory.open(path) as result:
        assert result.position.shape == (FRAMES, len(behind), 3)
        riding = result.points(-1)[len(behind) :].astype(float)
        turned = riding @ [np.cos(0.5), np.sin(0.5), 0.0]
        np.testing.assert_allclose(turned, (1 + SHARE) * H, rtol=1e-6)


def test_tables_only_grow_and_are_of_one_piece(block, path):
    table, none = block.table, CutCells.none(block.network.node_count)
    for one in (none.followed_by(table), table):
        assert np.array_equal(one.corners, table.corners)
    twice = replace(table, parts=table.parts + 8, owners=table.owners + 8,
                    borders=table.borders + 8)  # fmt: skip
    both = table.followed_by(twice)
    assert np.array_equal(
        both.corners[48:], np.where(table.corners < 63, 0, 18) + table.corners
    )
    assert len(both.points) == 36 and np.array_equal(both.points.hosts[36:], table.points.hosts)
    for changes, message in (
        ({"corners": table.corners + 18}, "corners must be less than 81"),
        ({"owners": table.owners + 8}, "must belong to a part"),
        ({"parts": table.parts * 0 + table.parts[0]}, "must belong to a part"),
        ({"nodes": 50}, "corners must be less than 68"),
    ):
        with pytest.raises(ValueError, match=message):
            replace(table, **changes)
    with pytest.raises(ValueError, match="of its own"):
        table.followed_by(table)


def test_a_table_that_shrinks_is_refused(block, tmp_path):
    with block.open(tmp_path / "a.vtkhdf") as writer:
        writer.topology(block.alive(CUT), block.table)
        with pytest.raises(ValueError, match="only grows"):
            writer.topology(block.alive(CUT), CutCells.none(63))


def test_a_later_cut_adds_points_behind_those_that_are_there(block, tmp_path):
    """Two parts are drawn anew with points of their own; earlier frames stay as they are."""
    later = CutCells.none(63).followed_by(block.table)
    first = block.parts[:1]
    own = block.table.owners == first[0]
    seen = block.table.borders == first[0]
    (body,), (phantoms,) = block.network.bodies, block.network.phantoms
    elements = slice(block.solid.walls[0], block.parts[-1] + 2)
    reserve = body.reserve._replace(elements=body.reserve.elements + 1)
    spare = slice(phantoms.elements.start, elements.stop)
    network = replace(
        block.network,
        bodies=(replace(body, elements=elements, reserve=reserve),),
        phantoms=(replace(phantoms, elements=spare),),
    )
    part = block.parts[-1:] + 1
    more = CutCells(
        63, block.table.points, part, block.table.wholes[:1], block.table.corners[own],
        np.repeat(part, own.sum()), block.table.triangles[seen], np.repeat(part, seen.sum()),
        block.table.cuts[seen],
    )  # fmt: skip
    both = later.followed_by(more)
    alive = np.append(block.alive(CUT), False)
    place, fields = block.positions(), block.fields(slice(None))
    fields["stress tensor"] = np.pad(fields["stress tensor"], ((0, 0), (0, 1), (0, 0)))
    with ResultWriter(tmp_path / "a.vtkhdf", network, block.recording(), {}, SCENE) as writer:
        for number, table in ((0, None), (CUT, later), (CUT + 1, both)):
            now = alive.copy()
            if not number:
                now = np.append(block.alive(0), False)
            elif table is both:
                now[first], now[part] = False, True
            writer.topology(now, table)
            rows = slice(number, number + 1)
            found = {name: each[rows] for name, each in fields.items()}
            writer.frames(TIMES[rows], place[rows], place[rows], found)
        path = writer.close("done", finished=True)
    counts = [frame(path, number).n_points for number in range(3)]
    assert counts == [63, 81, 99]
    for number in (1, 2):
        check_pieces(frame(path, number))
    with Trajectory.open(path) as result:
        assert np.array_equal(result.position[:], place[[0, CUT, CUT + 1]])
        assert [len(result.points(n)) for n in range(3)] == counts


@pytest.mark.parametrize("links", [False, True])
def test_blocks_show_both_pieces(block, path, tmp_path, links):
    """The solid is one block with points of its own after the cut, and the same numbers."""
    from tissuec.results.blocks.file import write_blocks

    beside = path.with_name(f"blocks{links}.vtkhdf") if links else tmp_path / "blocks.vtkhdf"
    with Trajectory.open(path) as result:
        written = write_blocks(result, None, beside, links=links)
    assert written.names == ("block_solid",)
    reader = opened(beside)
    for number in range(FRAMES):
        reader.SetStep(number)
        reader.Update()
        grid = pyvista.wrap(reader.GetOutputDataObject(0).GetBlock(0))
        other = frame(path, number)
        assert np.array_equal(grid.points, other.points)
        assert np.array_equal(grid.cells, other.cells)
        for name in ("velocity", "von_mises_stress", "node_id", "stress", "region", "force"):
            assert np.array_equal(grid[name], other[name]), (number, name)
        drawn = block.table.points.beside(block.network.position)[: grid.n_points]
        np.testing.assert_allclose(grid["displacement"], grid.points - drawn, atol=1e-17)
        assert not grid.point_data["body"].any()
        if number >= CUT:
            check_pieces(grid)
            behind = grid.points[63:] @ [np.cos(0.1 * number), np.sin(0.1 * number), 0]
            assert np.isclose(behind, (1 + SHARE) * H).sum() == 9


def test_frames_of_blocks_for_other_programs_show_both_pieces(path, tmp_path):
    from tissuec.results.blocks.pieces import BlockFrames

    with Trajectory.open(path) as result:
        frames = BlockFrames(result, None)
        for number in (0, CUT, FRAMES - 1):
            frames.write(number, tmp_path / f"frame{number}.vtm")
            (grid,) = pyvista.read(tmp_path / f"frame{number}.vtm")
            other = frame(path, number)
            assert np.array_equal(grid.points, other.points)
            assert np.array_equal(grid["stress"], other["stress"])


def test_tensors_are_sampled_by_entity(block):
    """Elements and parts have their places, in whatever order the blocks of a state are."""
    from tissuec.mechanics.state import State
    from tissuec.model.blocks import FieldBlock
    from tissuec.results.fields import FIELDS
    from tissuec.results.fields.tensors import StrainTensorField, StressTensorField
    from tissuec.script.measures.snapshot import Snapshot

    chosen = [3, 0, 5]
    parts = block.parts[chosen]
    cut = block.solid.only(block.cells[[1, 0, 2]])
    cut = replace(cut, walls=parts, walled=np.arange(3))
    state = State.start(block.network, gravity=np.zeros(3), drag=0.0)
    state.alive = block.alive(CUT)
    state.alive[np.setdiff1d(block.parts, parts)] = False
    (own,) = block.network.blocks
    stretch = np.diag([1.1, 0.95, 1.02]) + np.triu(np.full((3, 3), 0.05), 1)
    state.position = block.network.position @ stretch
    state.position += 1e-4 * np.sin(1e3 * block.network.position[:, [1, 2, 0]])
    more = FieldBlock("cut of block", own.kind, cut, own.span)
    for blocks in ((own, more), (more, own)):
        state.blocks = {one.name: one for one in blocks}
        snapshot = Snapshot.of(state)
        for field in (StressTensorField, StrainTensorField):
            found = field.sample(snapshot)
            assert found.shape == (24, 6)
            wanted = np.zeros((24, 6))
            drawn = block.network.position
            for one, at in ((block.solid, block.solid.walls), (cut, parts)):
                alive = state.alive[one.walls]
                place = at[alive] - block.solid.walls[0]
                values = field.numbers(one, state.position, drawn)[alive]
                wanted[place] = values[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
            assert np.abs(wanted).max() > 0.0
            np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-15)
    assert FIELDS["stress tensor"] is StressTensorField


def test_a_checkpoint_of_a_run_has_the_table(block):
    from tissuec.engine.execution.run_state import read_state, write_state

    again = read_state(write_state({"table": block.table}, ()), ())["table"]
    assert np.array_equal(again.corners, block.table.corners)
    assert np.array_equal(again.points.weights, block.table.points.weights)
    assert len(again.points) == 18


def test_a_stepped_run_shows_both_pieces(block):
    from tissuec.api.stepped_run import present_shape
    from tissuec.mechanics.state import State
    from tissuec.script.measures.snapshot import Snapshot

    state = State.start(block.network, gravity=np.zeros(3), drag=0.0)
    state.alive, state.position = block.alive(CUT), block.position(FRAMES - 1)
    state.cut_cells = block.table
    grid = to_pyvista(present_shape("now", Snapshot.of(state)))
    check_pieces(grid)
    assert (grid["node_id"][63:] == -1).all() and not grid["velocity"].any()
