"""Pictures, GIFs and videos: what is where in them, and how long they take."""

import sys
from base64 import b64decode
from io import BytesIO

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tests.view.player.conftest import Show, grid, without_springs
from tissuec.core import palette
from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.view.player.bodies import arrows, capsules, smooth_mesh
from tissuec.view.player.camera import Camera
from tissuec.view.player.files import (
    GIF_RATE,
    VIDEO_RATE,
    moments,
    need_ffmpeg,
    png,
    still,
    write_gif,
    write_video,
)
from tissuec.view.player.film import InterpolatedFrame
from tissuec.view.player.lifetimes import Timeline
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film
from tissuec.view.player.rules import dashed, ramp, rgb
from tissuec.view.player.shading import Raster
from tissuec.view.plots.page import need_matplotlib

pytest.importorskip("matplotlib", reason="needs the extra plot")
SIZE = (160, 90)


def quiet(number, count):
    """Tell nobody how far it is."""


def volume(corners):
    """Return the volume inside triangles, by Gauss's theorem."""
    a, b, c = (corners[:, k] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def test_solids_are_closed_and_have_their_volumes():
    first, second, radius = np.array([[1.0, 2.0, 3.0]]), np.array([[4.0, 6.0, 3.0]]), 0.5
    rod = capsules(first, second, np.array([radius]), sides=80)
    exact = np.pi * radius**2 * (5.0 + 4.0 / 3.0 * radius)
    # Flat faces inside a round body: short of it by the square of an angle of 4.5 degrees.
    assert volume(rod.corners) == pytest.approx(exact, rel=3e-3)
    ball = capsules(first, first, np.array([radius]), sides=80)
    assert volume(ball.corners) == pytest.approx(4.0 / 3.0 * np.pi * radius**3, rel=3e-3)
    for mesh in (rod, ball):
        a, b, c = (mesh.corners[:, k] for k in range(3))
        face = np.cross(b - a, c - a)[:, None]
        assert ((face * mesh.normals).sum(axis=2) >= -1e-12).all()  # all look outwards


def test_arrows_are_as_long_as_they_are_told():
    foot, arrow = np.array([[1.0, 2.0, 3.0]]), np.array([[0.0, 3.0, -4.0]])
    corners = arrows(foot, arrow, 0.1).corners.reshape(-1, 3) - foot
    along = corners @ arrow[0] / 5.0
    assert (along.min(), along.max()) == pytest.approx((0.0, 5.0))
    wide = np.linalg.norm(corners - along[:, None] * arrow / 5.0, axis=1)
    assert wide.max() == pytest.approx(0.24) and wide[along > 4.999].max() < 1e-9  # a tip


def test_normals_are_smooth_but_across_edges():
    points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1.0, 1.0)])
    mesh = smooth_mesh(points, ConvexHull(points).simplices)
    assert (np.abs(mesh.normals).max(axis=2) == 1.0).all()  # each along an axis
    x = np.linspace(-0.5, 0.5, 9)
    bent = np.array([[np.sin(a), y, np.cos(a)] for a in x for y in (0.0, 1.0)])
    strip = np.array([[k, k + 2, k + 1] for k in range(0, 16, 2)]
                     + [[k + 1, k + 2, k + 3] for k in range(0, 16, 2)])  # fmt: skip
    found = smooth_mesh(bent, strip)
    inner = np.abs(found.corners[..., 0]) < np.sin(0.45)
    exact = found.corners * [1.0, 0.0, 1.0]
    away = np.linalg.norm(np.abs(found.normals) - np.abs(exact), axis=2)[inner]
    assert away.max() < 0.07  # half of an eighth of a radian, where triangles differ in number


def test_the_nearer_of_two_triangles_is_seen():
    raster = Raster((20, 10), np.zeros(3))
    whole = np.array([[[-1.0, -1.0, 0.0], [50.0, -1.0, 0.0], [-1.0, 50.0, 0.0]]])
    colours = {"red": [1.0, 0.0, 0.0], "green": [0.0, 1.0, 0.0], "blue": [0.0, 0.0, 1.0]}
    for name, near in (("red", 0.5), ("green", 1.0), ("blue", 0.7)):
        colour = np.broadcast_to(np.array(colours[name]), (1, 3, 3))
        raster.draw(whole + np.array([0.0, 0.0, near]), colour, np.ones(1), hides=True)
    glass = np.broadcast_to(np.array([1.0, 1.0, 1.0]), (1, 3, 3))
    raster.draw(whole + np.array([0.0, 0.0, 2.0]), glass, np.full(1, 0.5), hides=False)
    assert (raster.pixels() == [128, 255, 128]).all()


def test_triangles_cover_their_area():
    raster = Raster((40, 40), np.zeros(3))
    corners = np.array([[[5.0, 5.0, 1.0], [35.0, 8.0, 1.0], [12.3, 31.1, 1.0]]])
    raster.draw(corners, np.ones((1, 3, 3)), np.ones(1), hides=True)
    exact = 0.5 * (30.0 * 26.1 - 3.0 * 7.3)
    # Of quarter pixels along rims of 90 pixels, as many are too many as too few.
    assert raster.pixels()[..., 0].sum() / 255.0 == pytest.approx(exact, rel=0.01)


def test_dashes_cover_their_part_of_a_line():
    ends = np.array([[[0.0, 0, 0], [10.0, 0, 0]], [[0.0, 1, 0], [10.0, 1, 0]]])
    which, found = dashed(ends, np.array([0.0, 4.0]))
    assert which.tolist() == [0, 1, 1, 1, 1]
    length = np.linalg.norm(found[:, 1] - found[:, 0], axis=1)
    assert length[0] == 10.0 and length[1:].sum() == pytest.approx(6.0)


def test_colours_run_from_pressure_to_tension():
    assert ramp(palette.TENSION, np.array([-1.0, 0.0, 1.0])) == pytest.approx(
        np.array([rgb(palette.TENSION[k]) for k in (0, 2, 4)])
    )


def test_a_spring_is_drawn_where_the_camera_sees_it_in_the_colour_of_its_tension(shown):
    class Drawn(Show):
        def place(self, frame):
            return self.network.position * [1.0 + 0.1 * frame, 1.0, 1.0]

    net = grid(2, 2)
    film = read_film(shown(Drawn(net, frames=3)), Options(view=(-90.0, 90.0)))
    options = Options(view=(-90.0, 90.0), colour="tension")
    painter = Painter(film, options, (400, 400), "")
    painter.film.skin.life[:] = -1.0  # the springs alone
    picture = painter.scene(2.0).astype(int)
    along = film.position[2][[0, 2]].mean(axis=0)  # a spring in x, which is drawn
    still = film.position[2][[0, 1]].mean(axis=0)  # one in y, which is not
    seen, _ = painter.camera.seen(np.array([along, still]))
    for (x, y), (low, high) in zip(seen, ((60, 255), (0, 25)), strict=True):
        column, row = int(200 * (1 + x)), int(200 * (1 - y))
        patch = picture[row - 2 : row + 3, column - 2 : column + 3].reshape(-1, 3)
        colour = patch[patch.sum(axis=1).argmin()]
        assert low <= colour[0] - colour[2] <= high  # more red than blue where it is drawn


def test_the_camera_follows_what_falls(shown):
    class Falling(Show):
        def place(self, frame):
            return self.network.position - [0.0, 0.0, 5.0 * frame**2]

    film = read_film(shown(Falling(without_springs(grid(4, 4)), frames=8)), Options())
    painter = Painter(film, Options(), SIZE, "")
    inked = [(painter.scene(float(frame)).min(axis=2) < 200).sum() for frame in (0, 7)]
    assert inked[0] == inked[1] > 20


@pytest.mark.parametrize("kind", ["points", "one frame", "one point", "law", "strain"])
def test_odd_results_are_drawn(shown, kind):
    net, options = grid(5, 5), Options()
    show = Show(net, cut=2)
    match kind:
        case "points":
            show = Show(without_springs(net))
        case "one frame":
            show = Show(net, frames=1)
        case "one point":
            show = Show(without_springs(grid(1, 1)), frames=1)
        case "law" | "strain":
            options = Options(colour=kind)
    film = read_film(shown(show), options)
    pixels = Painter(film, options, SIZE, "title", forces=True).pixels(len(film.times) - 1.0)
    assert pixels.shape == (SIZE[1], SIZE[0], 3) and pixels.min() < 200


@pytest.mark.parametrize("rate", [20, 30])
def test_moments_take_the_time_that_they_should(rate):
    times = np.array([0.0, 0.5, 2.0])
    found = moments(times, rate, None)
    assert len(found) == 2 * rate + 1 and found[[0, -1]].tolist() == [0.0, 2.0]
    assert np.interp(found, range(3), times) == pytest.approx(
        np.linspace(0.0, 2.0, 2 * rate + 1)
    )
    assert len(moments(times, rate, 0.5)) == 4 * rate + 1
    assert moments(times[:1], rate, None).tolist() == [0.0]


def test_a_gif_takes_as_long_as_the_run(shown, tmp_path):
    Image = pytest.importorskip("PIL.Image")
    film = read_film(shown(Show(grid(4, 4), frames=11, step=0.04)), Options())
    painter = Painter(film, Options(), SIZE, "sheet")
    assert write_gif(painter, tmp_path / "sheet.gif", 0.4, quiet) == GIF_RATE + 1
    with Image.open(tmp_path / "sheet.gif") as gif:
        shown_for = 0
        for number in range(gif.n_frames):
            gif.seek(number)
            shown_for += gif.info["duration"]
        assert gif.size == SIZE and gif.info["loop"] == 0
    assert shown_for == 1000 * (GIF_RATE + 1) // GIF_RATE + 600  # the end stays


def test_a_gif_of_few_frames_takes_as_long_with_fewer_pictures(shown, tmp_path):
    Image = pytest.importorskip("PIL.Image")
    options = Options(frames=5)
    film = read_film(shown(Show(grid(4, 4), frames=11, step=0.04)), options)
    assert (
        write_gif(Painter(film, options, SIZE, "sheet"), tmp_path / "few.gif", 0.2, quiet) == 5
    )
    with Image.open(tmp_path / "few.gif") as gif:
        assert gif.n_frames == 5 and gif.info["duration"] == 500


def test_a_video_takes_as_long_as_the_run(shown, tmp_path):
    encoder = pytest.importorskip("imageio_ffmpeg", reason="needs the extra animate")
    film = read_film(shown(Show(grid(4, 4), frames=6)), Options())
    painter = Painter(film, Options(), (161, 91), "sheet")  # odd sides are cut
    count = write_video(painter, tmp_path / "sheet.mp4", 0.2, quiet)
    frames, seconds = encoder.count_frames_and_secs(str(tmp_path / "sheet.mp4"))
    assert frames == count
    assert seconds == pytest.approx(count / VIDEO_RATE, abs=0.05)


@pytest.mark.parametrize(
    "most", [2, 10, *(pytest.param(most, marks=pytest.mark.slow) for most in (3, 6))]
)
def test_a_video_has_at_most_as_many_pictures_as_frames_are_asked_for(most, shown, tmp_path):
    encoder = pytest.importorskip("imageio_ffmpeg", reason="needs the extra animate")
    options = Options(frames=most)
    film = read_film(shown(Show(grid(4, 4), frames=11, step=0.04)), options)
    path = tmp_path / "few.mp4"
    count = write_video(Painter(film, options, (160, 90), "sheet"), path, 0.2, quiet)
    assert most - 1 <= count <= most
    assert encoder.count_frames_and_secs(str(path))[0] == count


def test_without_the_extras_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(TissueError, match=r'pip install "tissuec\[plot\]"'):
        need_matplotlib()
    with pytest.raises(TissueError, match=r'pip install "tissuec\[animate\]"'):
        need_ffmpeg()


def test_an_encoder_that_is_installed_serves_as_well(shown, tmp_path, monkeypatch):
    encoder = pytest.importorskip("imageio_ffmpeg", reason="needs the extra animate")
    (tmp_path / "ffmpeg").symlink_to(encoder.get_ffmpeg_exe())
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert need_ffmpeg() == str(tmp_path / "ffmpeg")
    options = Options(frames=2)
    painter = Painter(read_film(shown(Show(grid(4, 4), frames=6)), options), options, SIZE, "")
    assert write_video(painter, tmp_path / "few.mp4", None, quiet) >= 2
    assert (tmp_path / "few.mp4").stat().st_size > 0
    with pytest.raises(FileNotFoundError):
        write_video(painter, tmp_path / "none" / "few.mp4", None, quiet)


def test_points_behind_the_eye_are_left_out():
    camera = Camera(np.zeros(3), 1.0, 0.0, 0.0, 1.0)
    _, depth = camera.seen(np.array([[5.0, 0.0, 0.0]]))
    assert depth < 0.0


def test_a_spring_that_broke_is_no_longer_drawn(shown):
    bare = replace(grid(4, 4), skin=np.zeros((0, 3), dtype="i4"))
    film = read_film(shown(Show(bare, frames=6)), Options())
    film.lines.life[:, 1] = 2.5
    painter = Painter(film, Options(), SIZE, "")
    assert (painter.scene(2.4) != 255).any() and (painter.scene(2.5) == 255).all()


@pytest.mark.parametrize("outlier", [1.0, 50.0])
def test_arrows_of_forces_end_within_the_picture(shown, outlier):
    """Also at the outer nodes of a net that is as wide as the picture, and of outliers."""
    film = read_film(shown(Show(grid(12, 12), frames=3)), Options())
    outwards = film.position - film.position.mean(axis=1, keepdims=True)
    film.force[:] = outwards
    film.force[-1, 0] *= outlier
    painter = Painter(film, Options(), SIZE, "", forces=True)
    for row in range(3):
        corners = painter._arrows(InterpolatedFrame.of(film, float(row))).corners.reshape(-1, 3)
        places, depth = painter.home.seen(corners)
        assert len(corners) and (depth > 0.0).all()
        assert np.abs(places).max() <= 1.0
    texts = [text.get_text() for text in painter.draw(2.0).axes[0].texts]
    assert any("arrows end at" in text for text in texts) == (outlier > 4.0)


def test_names_of_laws_are_not_cut_off(shown):
    film = replace(
        read_film(shown(Show(grid(4, 4))), Options()),
        laws=("linear", "a measured curve of the mesosalpinx, stretched"),
    )
    painter = Painter(film, Options(colour="law"), (600, 300), "")
    figure = painter.draw(0.0)
    figure.canvas.draw()
    for text in figure.axes[0].texts:
        box = text.get_window_extent()
        assert box.x0 >= 0.0 and box.x1 <= 600.0


def opened(data):
    """Return the pixels of a picture, shape (height, width, 3)."""
    return np.asarray(pytest.importorskip("PIL.Image").open(BytesIO(data)))


def test_the_still_of_a_page_is_its_first_picture_as_png(shown):
    film = read_film(shown(Show(grid(6, 5), frames=4)), Options())
    address = still(film, Options(time=0.2))
    data = b64decode(address.removeprefix("data:image/png;base64,"))
    assert len(address) <= 40_000
    decoded = opened(data)
    at = float(Timeline(film.times).frame_of(0.2))
    drawn = Painter(film, Options(), decoded.shape[1::-1], "").scene(at)
    assert np.array_equal(decoded, drawn) and np.ptp(drawn) > 50
    noise = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert np.array_equal(opened(png(noise)), noise)
