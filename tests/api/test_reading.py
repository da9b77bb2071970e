"""What a result answers: arrays, names, origins, and how it shows itself."""

import sys
import types

import numpy as np
import pytest

import tissuec
from tests.api.scenes import PULL
from tests.vtk_reading import LINE, TRIANGLE, VERTEX, cells_of

#: Two bodies, one with regions and bending springs, joined; part of it is recorded.
PARTS = """language 1
tissue soft { spring constant = 20 N/m; viscosity = 10 mN*s/m; mass = 10 mg }
tissue hard like soft { spring constant = 90 N/m }
body flap {
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm
                  columns = 5; rows = 3; diagonals is both }
  tissue is soft
  bending = 10 %
  interface is mean
  region scar where x > 12 mm { tissue is hard }
}
body rod { mesh is explicit; tissue is hard }
table nodes of rod in mm with columns "id x y" { 10 22 0; 20 22 5; 30 22 10 }
table springs of rod with columns "a b" { 10 20; 20 30 }
set edge = nodes of flap where x < 1 mm
set rim = nodes of flap where x > 19 mm
set long ones = springs of flap where length > 6 mm
joint seam { springs from rim to rod; tissue is soft }
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix edge }
simulate { duration = 2 ms }
output { trajectory of [flap] every 1 ms; force of edge every 1 ms; tension of seam every 2 ms }
expect count(springs of long ones) > 0 at 2 ms
"""


@pytest.fixture(scope="module")
def pulled():
    with tissuec.run(PULL) as trajectory:
        yield trajectory


@pytest.fixture(scope="module")
def parts():
    with tissuec.run(PARTS) as trajectory:
        yield trajectory


def test_tensions_are_those_of_each_frame_and_nothing_once_a_spring_is_gone(pulled):
    tension = pulled.tension
    assert (tension.shape, tension.unit) == ((21, 2), "N")
    for frame in range(21):
        there, rows = pulled.spring_force(frame)
        assert np.array_equal(tension[frame, rows], there)
        assert np.isnan(tension[frame]).sum() == 2 - len(rows)
    gone = np.isnan(tension[:, pulled.springs_of("far spring")])[:, 0]
    assert gone.tolist() == [time > 0.149 for time in pulled.times]
    assert np.array_equal(tension[::-3][2], tension[14], equal_nan=True)


def test_the_law_of_a_spring_is_met_by_what_is_read(pulled):
    """T = c (L - L0) + d w, from positions and velocities of frames alone."""
    network, (a, b) = pulled.network, pulled.ends.T
    apart = pulled.position[:, b] - pulled.position[:, a]
    length = np.linalg.norm(apart, axis=-1)
    speed = ((pulled.velocity[:, b] - pulled.velocity[:, a]) * apart).sum(axis=-1) / length
    expected = (
        network.springs.stiffness * (length - network.springs.rest)
        + network.springs.damping * speed
    )
    there = np.isfinite(pulled.tension[:])
    assert pulled.tension[:][there] == pytest.approx(expected[there], abs=1e-15)


def test_names_find_rows_of_frames_whatever_their_capitals(pulled):
    assert pulled.nodes_of("Bob").tolist() == [2]
    assert pulled.node_ids[pulled.nodes_of("bob")].tolist() == [9]
    assert pulled.springs_of("far  spring").tolist() == [1]
    assert pulled.springs_of("pair").tolist() == [0, 1]
    assert list(pulled.sets) == ["wall", "bob", "far spring"]
    assert pulled.sets["bob"].indices.tolist() == [2]
    assert pulled.bodies["pair"].nodes == slice(0, 3)
    with pytest.raises(ValueError, match='no springs called "fra spring"; did you mean "far'):
        pulled.springs_of("fra spring")


def test_regions_joints_and_springs_within_nodes_have_names_too(parts):
    x = parts.network.position[:, 0]
    assert x[parts.nodes_of("scar of flap")].min() > 12e-3
    assert len(parts.nodes_of("scar of flap")) == 6
    inside = parts.springs_of("scar of flap")
    assert np.isin(parts.ends[inside], parts.nodes_of("scar of flap")).all()
    assert [group.name for group in parts.groups] == ["edge", "rim", "long ones", "scar"]
    lengths = parts.network.springs.rest[parts.springs][parts.springs_of("long ones")]
    assert lengths.min() > 6e-3


def test_springs_against_bending_are_in_no_frame_and_nobody_misses_them(parts):
    drawn = parts.springs_of("flap")
    assert len(drawn) == len(parts.springs)
    assert len(drawn) < parts.bodies["flap"].springs.stop


@pytest.mark.parametrize(
    ("ask", "count"), [("nodes_of", "3 of 3 nodes"), ("springs_of", "2 of 2 springs")]
)
def test_what_frames_do_not_show_is_not_given_in_part(parts, ask, count):
    with pytest.raises(ValueError, match=f'do not contain {count} of "rod"') as caught:
        getattr(parts, ask)("rod")
    assert "output { trajectory of [rod] every … }" in str(caught.value)


def test_every_number_says_which_text_gave_it(parts):
    stiffness, network = parts.provenance["stiffness"], parts.network
    assert sorted(parts.provenance) == sorted(
        ["mass", "stiffness", "damping", "rest", "strength", "crush"]
    )
    scar = parts.springs[parts.springs_of("scar of flap")[0]]
    assert stiffness[scar].span.text == "spring constant = 90 N/m"
    assert stiffness[scar].span.place == "scene:3"
    assert stiffness[scar].how == "written"
    assert stiffness[0].span.text == "spring constant = 20 N/m"
    assert stiffness[network.spring_count - 1].span.place == "scene:2"  # of the joint
    hows = {stiffness[spring].how for spring in range(network.spring_count)}
    assert hows == {"written", "interface mean", "bending"}


def test_origins_are_those_of_the_compiler(parts):
    compiled = tissuec.compile(PARTS).network.provenance
    for name, provenance in parts.provenance.items():
        for entry in range(len(provenance.index)):
            kept, made = provenance[entry], compiled[name][entry]
            assert (kept.how, kept.span.place, kept.span.text) == (
                made.how,
                made.span.place,
                made.span.text,
            )


def test_words_lead_to_the_rules_of_the_vocabulary():
    trajectory = tissuec.run(
        'language 1\nuse "tissues/muscle"\n'
        "body rod { mesh is explicit; tissue is muscle }\n"
        'table nodes of rod in mm with columns "id x" { 1 0; 2 10 }\n'
        'table springs of rod with columns "a b" { 1 2 }\n'
        "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
    )
    origin = trajectory.provenance["stiffness"][0]
    assert origin.how == "rules"
    assert origin.span.source.name == "fuzzy/soft_tissue.tis"
    assert origin.span.text.startswith("if ")
    files = ["fuzzy/words.tis", "fuzzy/soft_tissue.tis", "tissues/muscle.tis", "scene"]
    assert list(trajectory.sources) == files


def test_a_closed_result_says_that_it_is_closed():
    trajectory = tissuec.run(PULL)
    with trajectory:
        trajectory.times  # noqa: B018
    assert repr(trajectory) == '<closed Trajectory "scene.vtkhdf">'
    assert "closed" in trajectory._repr_html_()
    with pytest.raises(tissuec.ResultError, match="is closed"):
        trajectory.position  # noqa: B018


def test_it_says_what_it_holds(pulled, parts):
    lines = repr(pulled).splitlines()
    assert lines.pop(2).startswith("  accuracy in time: ")
    assert lines == [
        '<Trajectory "scene.vtkhdf">',
        "  outcome: done: 0.2 s were simulated",
        "  frames: 21, 0 s to 200 ms, of 3 nodes, 2 springs",
        "  body: pair, 3 nodes, 2 springs",
        "  sets: wall (1 node), bob (1 node), far spring (1 spring)",
        "  logs: position of bob [m], energies [J]",
        "  events: 1 fix, 1 move, 1 end, 1 cut",
        "  expectations: 1 of 1 hold",
    ]
    assert "joint: seam, 3 springs" in repr(parts)
    assert repr(pulled.position) == "<21 x 3 x 3 numbers [m], float64, read when indexed>"
    assert repr(pulled.logs) == '<log "position of bob" [m]: 201 moments of x, y, z>'


# --- notebooks --------------------------------------------------------------------------------


@pytest.fixture
def player(monkeypatch):
    """Stand in for the player, whose pages have tests of their own."""
    asked = []

    class Options:
        def __init__(self, frames=None):
            self.frames = frames

    def fragment(trajectory, options, *, height):
        asked.append((trajectory, options.frames, height))
        return '<iframe srcdoc="&lt;p&gt;the player&lt;/p&gt;"></iframe>'

    for name, member in (("options", Options), ("page", fragment)):
        module = types.ModuleType(f"tissuec.view.player.{name}")
        setattr(module, member.__name__, member)
        monkeypatch.setitem(sys.modules, f"tissuec.view.player.{name}", module)
    return asked


def test_a_notebook_shows_the_player_and_a_table(pulled, player):
    shown = pulled._repr_html_()
    assert shown.index("<iframe") < shown.index("<table")
    assert "<th" in shown and "3 nodes, 2 springs" in shown
    assert player[0][0] is pulled


def test_what_is_shown_is_escaped(player):
    trajectory = tissuec.run(PULL.replace("set bob", 'set "<b>"').replace("bob", '"<b>"'))
    assert "&lt;b&gt; (1 node)" in trajectory._repr_html_()
    assert "<b>" not in trajectory._repr_html_()


def test_many_frames_are_thinned_and_said_to_be(pulled, player, monkeypatch):
    from tissuec.api import notebook

    monkeypatch.setattr(notebook, "MOST_POSITIONS", 15)
    assert "5 of 21 frames are shown; tissuec view" in pulled._repr_html_()
    assert player[0][1] == 5


def test_what_is_too_large_for_a_notebook_is_a_sentence(pulled, player, monkeypatch):
    from tissuec.api import notebook

    monkeypatch.setattr(notebook, "LARGEST", 10)
    shown = pulled._repr_html_()
    assert "too large for a notebook" in shown and "<table" in shown and "iframe" not in shown
    monkeypatch.setattr(notebook, "MOST_NODES", 2)
    assert "3 nodes are too many for a notebook" in pulled._repr_html_()
    assert len(player) == 1  # a page that will not be shown is not made


def test_a_run_without_frames_is_shown_without_a_player(player):
    trajectory = tissuec.run(PULL.replace("trajectory every 10 ms;", ""))
    assert "not record a trajectory" in trajectory._repr_html_() and not player
    assert "frames: none" in repr(trajectory)


def test_ipython_shows_it(pulled, player):
    formatters = pytest.importorskip("IPython.core.formatters")
    data, _ = formatters.DisplayFormatter().format(pulled)
    assert data["text/html"] == pulled._repr_html_()
    assert data["text/plain"] == repr(pulled)


# --- pandas and xarray ------------------------------------------------------------------------


def test_one_log_is_a_table_of_its_columns(pulled):
    pytest.importorskip("pandas")
    table, log = pulled.to_pandas("position of bob"), pulled.logs["position of bob"]
    assert list(table.columns) == ["x", "y", "z"]
    assert table.index.name == "time [s]"
    assert np.array_equal(table.index, log.time) and np.array_equal(table, log.value)
    assert table.attrs["units"] == {"position of bob": "m"}


def test_several_logs_share_a_table_with_gaps_where_one_has_no_row(pulled):
    pytest.importorskip("pandas")
    table = pulled.to_pandas("energies", "position of bob")
    log, energies = pulled.logs["position of bob"], pulled.energies
    assert np.array_equal(table.index, log.time)
    assert np.array_equal(table["position of bob"], log.value)
    kinetic = table["energies"]["kinetic"]
    assert np.array_equal(kinetic.dropna(), energies.value[:, 0])
    assert np.array_equal(kinetic.dropna().index, energies.time)
    assert kinetic.isna().sum() == 201 - 5
    assert table.attrs["units"] == {"energies": "J", "position of bob": "m"}


def test_without_names_all_logs_are_meant(parts):
    pytest.importorskip("pandas")
    table = parts.to_pandas()
    assert list(table.columns.get_level_values(0).unique()) == list(parts.logs)
    assert list(table["tension of seam"].columns) == list(parts.logs["tension of seam"].columns)


def test_events_are_a_table_too(pulled):
    pytest.importorskip("pandas")
    table = pulled.to_pandas("events")
    assert list(table["kind"]) == ["fix", "move", "end", "cut"]
    assert table["springs"].iloc[-1] == ("2",)
    assert list(table.index) == pytest.approx([0.0, 0.0, 0.1, 0.15])


def test_a_log_that_is_not_there_is_named(pulled):
    pytest.importorskip("pandas")
    with pytest.raises(tissuec.ResultError, match=r'no log "position of bbo".*did you mean'):
        pulled.to_pandas("position of bbo")


def test_a_result_without_logs_is_an_empty_table():
    pytest.importorskip("pandas")
    text = PULL.replace("position of bob every 1 ms; energy every 50 ms", "")
    assert tissuec.run(text).to_pandas().shape == (0, 0)


def test_frames_are_a_dataset_with_axes_units_and_ids(pulled):
    pytest.importorskip("xarray")
    data = pulled.to_xarray()
    assert data.position.dims == ("time", "node", "axis")
    assert data.tension.dims == ("time", "spring")
    assert data.position.attrs["units"] == "m"
    bob = data.position.isel(node=pulled.nodes_of("bob")).sel(axis="x", time=0.2)
    assert bob.node_id.item() == 9 and bob.item() == pytest.approx(0.021)
    for name in ("position", "velocity", "force", "tension"):
        assert np.array_equal(data[name], getattr(pulled, name)[:], equal_nan=True)
    assert set(data.body.values) == {"pair"}
    assert list(data.part.values) == ["pair", "pair"]


def test_only_what_is_asked_for_is_read(parts):
    pytest.importorskip("xarray")
    data = parts.to_xarray("velocity", frames=slice(1, None))
    assert list(data.data_vars) == ["velocity"]
    assert data.velocity.shape == (2, 15, 3)
    with pytest.raises(ValueError, match='frames have no "speed"'):
        parts.to_xarray("speed")


def test_a_frame_is_a_mesh_of_pyvista(parts):
    pytest.importorskip("pyvista")
    mesh, last = parts.to_pyvista(), len(parts.times) - 1
    cells = parts.cells(last)
    assert np.array_equal(mesh.points, parts.position[last])
    assert np.array_equal(cells_of(mesh, LINE), cells.lines)
    assert np.array_equal(cells_of(mesh, TRIANGLE), cells.triangles)
    assert np.array_equal(cells_of(mesh, VERTEX), cells.vertices)
    assert np.array_equal(mesh.point_data["velocity"], parts.velocity[last])
    tension, rows = parts.spring_force(last)
    lines = mesh.celltypes == LINE
    assert np.array_equal(mesh.cell_data["spring_force"][lines], tension)
    assert np.array_equal(mesh.cell_data["spring_id"][lines], parts.spring_ids[rows])
    assert mesh.field_data["TimeValue"] == [parts.times[last]]
    assert parts.to_pyvista(0).field_data["TimeValue"] == [0.0]
    with pytest.raises(IndexError, match="frame 99"):
        parts.to_pyvista(99)


@pytest.mark.parametrize(
    ("ask", "package", "extra"),
    [
        ("to_pandas", "pandas", "notebook"),
        ("to_xarray", "xarray", "notebook"),
        ("to_pyvista", "pyvista", "pyvista"),
    ],
)
def test_a_missing_package_is_named_with_what_brings_it(
    pulled, monkeypatch, ask, package, extra
):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf'{ask} needs {package}.*"tissuec\[{extra}\]"'):
        getattr(pulled, ask)()


def test_modes_and_properties_are_a_few_lines():
    first, *rest = repr(tissuec.modes(PULL, count=3)).splitlines()
    assert first.startswith("3 modes of ") and [line[:10] for line in rest] == [
        f"  <mode {number}:" for number in (1, 2, 3)
    ]
    (body,) = tissuec.properties(PULL)
    assert repr(body).startswith(f'<{body.kind} "{body.name}"') and len(repr(body)) < 100
