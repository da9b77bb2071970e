"""Between frames, a film shows the motion of the run, also close to events."""

import numpy as np
import pytest

import tissuec
from tissuec.core.resources import library
from tissuec.core.structs import replace
from tissuec.results.moments import curved, slopes
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.film import position_at
from tissuec.view.player.lifetimes import Timeline
from tissuec.view.player.options import Options
from tissuec.view.player.reading import read_film

BESIDE = 1e-4  # [s]
EVENTS = (0.1, 0.15, 0.45, 0.7)


@pytest.fixture(scope="module")
def film(sterilisation):
    with Trajectory.open(sterilisation) as trajectory:
        return read_film(trajectory, Options())


def shown(film, time):
    """Return where the film shows the nodes at a time [m]."""
    return position_at(film, float(Timeline(film.times).frame_of(time)))[: film.node_count]


def test_no_effect_is_shown_before_its_cause(film):
    """Within 2 % of the motion between two frames; linear frames are 50 % off at the cut."""
    times = [time + away for time in EVENTS for away in (-BESIDE, BESIDE)]
    frames = film.times[~film.is_side]
    with tissuec.start(library() / "scenes" / "sterilisation.tis") as run:
        for time in times:
            run.run_until(time)
            low = int(np.searchsorted(frames, time, side="right")) - 1
            ways = [shown(film, frames[low + one]) for one in (0, 1)]
            motion = np.linalg.norm(ways[1] - ways[0], axis=1).max()
            apart = np.linalg.norm(shown(film, time) - run.position, axis=1).max()
            assert apart < 0.02 * motion


def test_springs_end_with_the_cut_and_not_before(film):
    timeline = Timeline(film.times)
    for time, count in ((0.7 - 1e-9, 610), (0.7, 580)):
        assert film.alive(float(timeline.frame_of(time))).sum() == count


def test_events_are_no_frames(film):
    assert film.frame_count == 51 and np.count_nonzero(film.is_side) == 10
    assert not film.curved[np.diff(film.times) <= 0.0].any()


def test_a_smooth_surface_parts_at_the_time_of_the_cut(tmp_path):
    scene = (library() / "scenes" / "sterilisation.tis").read_text(encoding="utf-8")
    path = tmp_path / "smooth.tis"
    path.write_text(
        scene.replace("output {", "output { surface of oviduct every 40 ms;", 1),
        encoding="utf-8",
    )
    result = tissuec.run(path, out=tmp_path / "smooth.vtkhdf", companion="off")
    film = read_film(result, Options())
    cut = float(Timeline(film.times).frame_of(0.7))
    before, after = film.surfaces["oviduct"]
    assert len(after.triangles) < len(before.triangles)
    assert before.frames[-1] == cut - 1 and after.frames[0] == cut


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_cubic_is_exact_for_motions_up_to_degree_three(film, degree):
    times = np.array([0.0, 0.3, 1.0])
    position = np.ones((3, 2, 3)) * times[:, None, None] ** degree
    velocity = degree * np.ones((3, 2, 3)) * times[:, None, None] ** (degree - 1)
    is_curved = curved(times, position, velocity)
    assert is_curved.all()
    film = replace(film, times=times, position=position, velocity=velocity, curved=is_curved)
    middle = position_at(film, 1.4)
    assert middle == pytest.approx(np.full((2, 3), 0.58**degree), rel=1e-14)


def test_what_swings_faster_than_frames_follow_goes_straight():
    times = np.linspace(0.0, 1.0, 12)
    phase = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, (1, 50, 3))
    turns = 2.0 * np.pi * 40.3 * times[:, None, None] + phase
    assert not curved(times, np.sin(turns), 2.0 * np.pi * 40.3 * np.cos(turns)).any()
    slow = np.pi * times[:, None, None] + phase
    assert curved(times, np.sin(slow), np.pi * np.cos(slow)).all()


def test_slopes_do_not_cross_events():
    times = np.array([0.0, 1.0, 1.0, 2.0])
    position = np.array([0.0, 1.0, 1.0, 4.0])[:, None, None] * np.ones((1, 1, 3))
    assert slopes(times, position)[:, 0, 0].tolist() == [1.0, 1.0, 3.0, 3.0]
