"""Frames show the net as it is in the file, from where it is asked."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from tests.results.test_blocks import SCENE as BLOCKS
from tests.view.plots.conftest import carry_out
from tissuec.core.errors import TissueError
from tissuec.core.palette import TENSION
from tissuec.results.instruments.meshes import turned
from tissuec.results.trajectory import Trajectory
from tissuec.view.plots import draw, net
from tissuec.view.plots.frames import moments, telling_frames
from tissuec.view.plots.projection import Projection

pytestmark = pytest.mark.usefixtures("unplaced")

PRESS = """language 1
tissue flesh { spring constant = 200 N/m; viscosity = 50 mN*s/m; mass = 0.2 g }
body block {
  mesh is lattice { kind is sodium chloride; cell = 5 mm; reach is second neighbours
    box from (0, 0, 0) mm to (10, 10, 10) mm }
  tissue is flesh
}
set base = nodes of block where z < 0.1 mm
tool probe { kind is probe; radius = 4 mm; centre = (5, 5, 15) mm }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only }
script {
  at 0 s: fix base
  from 0 s to 10 ms: move probe by (0, 0, -2) mm using smooth profile
}
simulate { duration = 10 ms }
output { trajectory every 5 ms }
"""


def segments(axes):
    (lines,) = axes.collections
    return np.array(lines.get_segments())


def in_order(rows):
    """Return rows of numbers in an order that does not depend on rounding."""
    flat = np.asarray(rows).reshape(len(rows), -1)
    return flat[np.lexsort(flat.round(6).T)]


def panels(figure):
    return [axes for axes in figure.axes if axes.get_title(loc="left")]


@pytest.mark.parametrize("time", [0.05, 0.1])  # before and after the cut
def test_springs_stand_where_the_file_has_them(result, strip, time):
    figure = draw("frames", result, times=time, view=(-90.0, 90.0))
    (axes,) = panels(figure)
    assert axes.get_title(loc="left").startswith(f"{1e3 * time:g} ms")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [mm]", "y [mm]")
    frame = int(np.abs(strip.times - time).argmin())
    _, springs = strip.spring_force(frame)
    expected = 1e3 * strip.position[frame][strip.ends[springs]][:, :, :2]
    assert in_order(segments(axes)) == pytest.approx(in_order(expected))


def test_a_cut_spring_is_not_drawn(result, strip):
    before, after = panels(draw("frames", result, times=(0.055, 0.1)))
    dead = len(strip.spring_force(0)[1]) - len(strip.spring_force(-1)[1])
    assert dead > 0
    assert len(segments(before)) - len(segments(after)) == dead
    assert "cut" in after.get_title(loc="left")


def test_all_moments_are_seen_alike(result):
    figure = draw("frames", result)
    shown = panels(figure)
    assert len(shown) == 4
    assert len({(*axes.get_xlim(), *axes.get_ylim()) for axes in shown}) == 1
    assert all(axes.get_aspect() == 1.0 for axes in shown)


def test_colours_are_those_of_the_scale_of_tension(result, strip):
    figure = draw("frames", result, times=0.05)
    (axes,) = panels(figure)
    tension, _ = strip.spring_force(int(np.abs(strip.times - 0.05).argmin()))
    norm = net.tension_norm([tension])
    (lines,) = axes.collections
    expected = net.tension_colours()(norm(tension))[:, :3]
    found = lines.get_colors()[:, :3]
    assert in_order(found) == pytest.approx(in_order(expected))
    bar = figure.axes[-1]
    assert (
        bar.get_xlabel().replace("\n", " ")
        == "tension of the springs [mN]; negative: compression"
    )
    low, high = bar.get_xlim()
    assert (low, high) == pytest.approx((-1e3 * norm.vmax, 1e3 * norm.vmax))
    assert norm.vmax == pytest.approx(np.percentile(np.abs(tension), 99))
    assert [to_hex(net.tension_colours()(end)) for end in (0.0, 1.0)] == [
        TENSION[0],
        TENSION[4],
    ]


def test_an_oblique_view_has_a_bar_of_its_length(result):
    (axes,) = panels(draw("frames", result, times=0.0, view=(-110.0, 22.0)))
    assert not axes.axison
    (bar,) = (line for line in axes.get_lines() if line.get_gid() == "bar")
    (text,) = (text for text in axes.texts if text.get_text().endswith("mm"))
    length = float(np.ptp(bar.get_xdata()))
    assert text.get_text() == f"{length:g} mm"


def test_further_springs_are_drawn_first_and_paler(strip):
    import matplotlib.pyplot as plt

    view = Projection(-90.0, 0.0)  # along y: nearer is less
    ends = np.array([[[0, y, 0], [1, y, 0]] for y in (0.0, 3.0, 1.0)], dtype=float)
    figure, axes = plt.subplots()
    lines = net.draw_springs(axes, ends, view, colours=np.tile([0.0, 0, 0, 1], (len(ends), 1)))
    assert lines.get_colors()[:, 3] == pytest.approx([0.3, 0.3 + 0.7 * 2 / 3, 1.0])
    plt.close(figure)


def test_frames_are_the_nearest_ones_and_come_once(strip):
    found = moments(strip, (0.1, 0.011, 0.0, 0.012, 7.0))
    assert [strip.times[moment.frame] for moment in found] == pytest.approx([0.0, 0.01, 0.1])
    assert [moment.title for moment in found] == ["0 ms", "10 ms", "100 ms: cut at 60 ms"]


def test_chosen_frames_reach_from_start_to_end_and_show_motion(strip):
    frames = telling_frames(strip)
    assert frames[0] == 0 and frames[-1] == len(strip.times) - 1
    assert len(set(frames)) == 4


def test_skins_and_surfaces_are_drawn_with_all_their_triangles(result, strip):
    (axes,) = panels(draw("frames", result, times=0.0, show="skin"))
    assert len(axes.collections[0].get_paths()) == len(strip.cells(0).triangles)
    (axes,) = panels(draw("frames", result, times=0.1, show="surface"))
    surface = strip.surfaces["strip"]
    assert len(axes.collections[0].get_paths()) == len(surface.triangles(-1))


def test_tools_that_are_recorded_are_drawn_where_they_are(tmp_path):
    path = carry_out(PRESS, tmp_path / "press.vtkhdf")
    start, end = panels(draw("frames", path, times=(0.0, 0.01), view=(-90.0, 0.0)))
    for axes, height in ((start, 15.0), (end, 13.0)):
        probe = axes.patches[0]
        low, high = probe.get_xy().min(axis=0), probe.get_xy().max(axis=0)
        assert (low, high) == (
            pytest.approx([1.0, height - 4.0], abs=1e-6),
            pytest.approx([9.0, height + 4.0], abs=1e-6),
        )
        assert axes.get_ylim()[0] <= low[1] and axes.get_ylim()[1] >= 19.0  # none is clipped


def test_instruments_and_what_they_hold_are_drawn(tmp_path):
    path = carry_out(BLOCKS, tmp_path / "pad.vtkhdf")
    times = (0.0, 0.02, 0.025)
    shown = panels(draw("frames", path, times=times, view=(-60.0, 30.0)))
    view = Projection(-60.0, 30.0)
    with Trajectory.open(path) as run:
        for axes, time in zip(shown, times, strict=True):
            frame = int(np.abs(run.times - time).argmin())
            place = 1e3 * view.flat(run.position[frame])
            marks = {one.get_marker(): np.array(one.get_xydata()) for one in axes.lines}
            x = run.network.position[:9, 0]
            assert in_order(marks["s"]) == pytest.approx(in_order(place[:9][x < 1e-3]))
            assert ("o" in marks) == (time > 0.0)
            if time > 0.0:
                held = place[:9][x > 9e-3]
                assert in_order(marks["o"]) == pytest.approx(in_order(held))
    # The ball and the handle of a probe, forceps while they hold, and scissors when they cut.
    assert [len(axes.patches) for axes in shown] == [3, 5, 7]
    forceps = shown[1].patches[1].get_path().get_extents()
    assert (forceps.min < held.mean(axis=0)).all() and (held.mean(axis=0) < forceps.max).all()


def test_a_silhouette_is_one_area_with_its_outline():
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    points, triangles = turned([(0.0, 0.5**0.5), (1.0, 0.5**0.5)], 4)  # a cube
    view = Projection(45.0 + 45.0, np.degrees(np.arctan(0.5**0.5)))  # along its diagonal
    net.draw_silhouette(axes, points, triangles, view, colour="red", opacity=0.5)
    area, outline = axes.patches
    corners = area.get_path().vertices.reshape(-1, 4, 2)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sizes = np.linalg.det(np.stack([b - a, c - a], axis=-1)) / 2.0
    assert (sizes > 0.0).all() and sizes.sum() == pytest.approx(3.0**0.5)  # a hexagon
    ends = outline.get_path().vertices.reshape(-1, 2, 2)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert len(ends) == 6 and lengths == pytest.approx((2.0 / 3.0) ** 0.5)


def test_threads_are_found_among_bodies(tmp_path):
    text = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 1 N*s/m; mass = 1 g }
body chain { mesh is explicit; tissue is cord }
body net { mesh is sheet { corner = (0, 9, 0) mm; first edge = (9, 0, 0) mm
  second edge = (0, 9, 0) mm; columns = 3; rows = 3 }; tissue is cord }
table nodes of chain in mm with columns "id x" { 1 0; 2 1; 3 2; 4 3; 5 4 }
table springs of chain with columns "a b" { 1 2; 2 3; 3 4; 4 5 }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
    with Trajectory.open(carry_out(text, tmp_path / "chain.vtkhdf")) as run:
        chains = net.thread_springs(run.network)
    assert chains[:4].all() and not chains[4:].any()


def test_nodes_without_springs_are_dots(tmp_path):
    text = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 1 N*s/m; mass = 1 g }
body dust { mesh is explicit; tissue is cord }
table nodes of dust in mm with columns "id x y" { 1 0 0; 2 1 0; 3 0 2 }
table springs of dust with columns "a b" { }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
    path = carry_out(text, tmp_path / "dust.vtkhdf")
    axes = panels(draw("frames", path))[0]
    (dots,) = (line for line in axes.get_lines() if line.get_marker() == "o")
    assert in_order(dots.get_xydata()) == pytest.approx(in_order([[0, 0], [1, 0], [0, 2]]))


def test_what_cannot_be_shown_is_said(folder, tmp_path, monkeypatch):
    with pytest.raises(TissueError, match='"bones" cannot be shown; there are: springs'):
        draw("frames", folder / "strip.vtkhdf", show="bones")
    with Trajectory.open(folder / "strip.vtkhdf") as run:
        monkeypatch.setattr("tissuec.view.plots.frames.MOST", 3)
        with pytest.raises(TissueError, match="4 frames are too many for a page; at most 3"):
            moments(run, (0.0, 0.01, 0.02, 0.03))
    path = carry_out(PRESS, tmp_path / "press.vtkhdf")
    with pytest.raises(TissueError, match="has no smooth surfaces; write output"):
        draw("frames", path, show="surface")


def test_of_a_solid_body_the_springs_on_the_side_that_is_looked_at_are_drawn(tmp_path):
    """A block seen along y: a grid of squares with diagonals, and nothing behind its front."""
    path = carry_out(PRESS, tmp_path / "press.vtkhdf")
    with Trajectory.open(path) as run:
        (axes,) = panels(draw("frames", path, times=0.0, view=(-90.0, 0.0)))
        place = run.position[0][: run.network.body_nodes]
        ends = run.ends[run.spring_force(0)[1]]
    front = place[:, 1] <= place[:, 1].min() + 1e-9
    assert 0 < front.sum() < len(place)
    expected = 1e3 * place[ends[front[ends].all(axis=1)]][:, :, [0, 2]]
    assert in_order(segments(axes)) == pytest.approx(in_order(expected))


def test_of_a_solid_body_without_springs_in_its_skin_those_behind_the_front_are_drawn(tmp_path):
    """Corners and centres of cubes: springs join the middle of the front to centres only."""
    text = """language 1
tissue gel { spring constant = 500 N/m; viscosity = 50 mN*s/m; mass = 1 g; prestress = 1 % }
body pad {
  mesh is lattice {
    kind is caesium chloride; cell = 10 mm; box from (0, 0, 0) mm to (20, 20, 20) mm
  }
  tissue is gel
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""
    path = carry_out(text, tmp_path / "pad.vtkhdf")
    with Trajectory.open(path) as run:
        (axes,) = panels(draw("frames", path, times=0.0, view=(-90.0, 0.0)))
        place = run.position[0]
        ends = run.ends[run.spring_force(0)[1]]
    front = place[:, 1] <= place[:, 1].min() + 1e-9
    around = front[ends].all(axis=1)
    middle = np.flatnonzero(front & ~np.isin(np.arange(len(place)), ends[around]))
    assert len(middle) == 1
    inwards = np.isin(ends, middle).any(axis=1)
    assert inwards.sum() == 4
    expected = 1e3 * place[ends[around | inwards]][:, :, [0, 2]]
    assert in_order(segments(axes)) == pytest.approx(in_order(expected))


def test_of_a_sheet_all_springs_are_drawn_from_either_side(result, strip):
    for elevation in (90.0, -90.0):
        (axes,) = panels(draw("frames", result, times=0.0, view=(-90.0, elevation)))
        assert len(segments(axes)) == len(strip.spring_force(0)[1])


SQUARE = """language 1
tissue mesh { spring constant = 25 N/m; viscosity = 20 mN*s/m; mass = 0.2 g }
body cloth {
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (60, 0, 0) mm
    second edge = (0, 60, 0) mm; rows = 5; columns = 5; diagonals is both }
  tissue is mesh
}
set top = nodes of cloth where y > 59 mm
environment { gravity = (0, -9.81, 0) m/s^2 }
script { at 0 s: fix top }
simulate { duration = 0.1 s }
output { trajectory every 10 ms }
"""


@pytest.mark.usefixtures("placed")
@pytest.mark.parametrize("options", [{}, {"times": (0.05,)}])
def test_the_page_is_high_enough_for_titles_and_labels_of_axes(tmp_path, options):
    path = carry_out(SQUARE, tmp_path / "square.vtkhdf")
    figure = draw("frames", path, **options)
    figure.canvas.draw()
    for axes in panels(figure):
        assert axes.get_tightbbox().y1 <= figure.bbox.y1
