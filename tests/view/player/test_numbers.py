"""What pages hold: numbers in steps, lives, fewer nodes, curves, marks, units."""

import base64
import zlib
from types import SimpleNamespace

import numpy as np
import pytest

from tests.view.player.conftest import Show, grid
from tissuec.results.recording import Event
from tissuec.view.player.curves import BREAKING, SIGNS, marks, outline
from tissuec.view.player.facts import near, pace
from tissuec.view.player.lifetimes import FOREVER, Register, Timeline, lives
from tissuec.view.player.options import Options
from tissuec.view.player.packing import ORDERS, Pack, box_scale, to_bytes
from tissuec.view.player.reading import choose_frames, read_film


def unpacked(pack: Pack, name: str) -> np.ndarray:
    """Read an array back, by sums of Python's own whole numbers."""
    raw = zlib.decompress(base64.b64decode(pack.packed()), -15)
    spec = pack.specs[name]
    count = int(np.prod(spec["shape"]))
    planes = [raw[spec["from"] + k * count :][:count] for k in range(spec["bytes"])]
    folded = [sum(plane[i] << 8 * k for k, plane in enumerate(planes)) for i in range(count)]
    steps = [n // 2 if n % 2 == 0 else -(n + 1) // 2 for n in folded]
    width = count // spec["shape"][0] if spec["shape"][0] else 0
    for _ in range(spec["order"]):
        for i in range(width, count):
            steps[i] += steps[i - width]
    numbers = [spec["low"] + n % 2 ** (8 * spec["bytes"]) for n in steps]
    return np.array(numbers, dtype=np.int64).reshape(spec["shape"])


@pytest.mark.parametrize("most", [1, 200, 60_000, 3_000_000_000])
@pytest.mark.parametrize("shape", [(1, 7), (6, 4, 3), (2, 0), (0, 3)])
def test_whole_numbers_come_back(most, shape):
    numbers = np.random.default_rng(1).integers(-most // 2, most // 2 + 1, shape)
    pack = Pack()
    pack.add("other", np.arange(5)[:, None])
    pack.add("numbers", numbers)
    assert np.array_equal(unpacked(pack, "numbers"), numbers)


@pytest.mark.parametrize("order", ORDERS)
def test_smooth_motion_needs_few_bytes(order):
    time = np.arange(100.0)[:, None]
    numbers = np.rint(3e4 + 2e4 * np.sin(0.05 * time + np.arange(50.0))).astype(np.uint32)
    sizes = [len(zlib.compress(to_bytes(numbers, k, 2), 9)) for k in ORDERS]
    pack = Pack()
    pack.add("numbers", numbers)
    assert pack.specs["numbers"]["order"] == int(np.argmin(sizes)) == 2


def test_positions_are_wrong_by_half_a_step_at_most():
    position = np.random.default_rng(2).uniform(-3.0, 5.0, (4, 30, 3))
    scale = box_scale(position)
    back = np.array(scale.origin) + scale.step * scale.steps(position)
    # And by the rounding of numbers of that size.
    assert np.abs(back - position).max() <= 0.5 * scale.step + 1e-12
    assert scale.step == pytest.approx(np.ptp(position, axis=(0, 1)).max() / 65535)


def test_what_flies_away_does_not_coarsen_the_net():
    position = np.random.default_rng(3).uniform(0.0, 0.1, (20, 30, 3))
    position[-1, 0] = 1e3
    scale = box_scale(position)
    assert scale.step < 0.1 / 60_000
    back = np.array(scale.origin) + scale.step * scale.steps(position)
    assert np.abs(back - position).max() <= 0.5 * scale.step + 1e-9


def test_lives_are_spans_of_frames():
    there = np.array([[1, 1, 0], [1, 0, 0], [0, 1, 1], [0, 1, 1]], dtype=bool)
    found = lives(list(enumerate(there)), 3)
    assert found.of.tolist() == [0, 1, 1, 2]
    assert found.life.tolist() == [[0, 2], [0, 1], [2, FOREVER], [2, FOREVER]]


def test_springs_end_when_the_log_says():
    timeline = Timeline(np.array([0.0, 0.1, 0.2, 0.4]))
    there = np.array([[1, 1, 1], [1, 1, 1], [1, 0, 1], [0, 0, 0]], dtype=bool)
    found = lives(list(enumerate(there)), 3)
    events = [
        Event(0.05, "cut", (7,), "of another life", ""),
        Event(0.12, "cut", (9,), "", ""),
        Event(0.3, "rupture", (7,), "", ""),
        Event(0.15, "slip", (11,), "of another life as well", ""),
    ]
    sharp = timeline.sharpened(found, np.array([7, 9, 11]), events)
    assert sharp.life[:, 1] == pytest.approx([2.5, 1.2, 3.0])


def test_rows_are_numbered_once():
    register = Register(100, 3)
    first = np.array([[5, 6, 7], [1, 2, 3], [5, 6, 7]])
    assert register.numbers(first).tolist() == [0, 1, 0]
    assert register.numbers(np.array([[1, 2, 3], [3, 2, 1]])).tolist() == [1, 2]
    assert register.rows.tolist() == [[5, 6, 7], [1, 2, 3], [3, 2, 1]]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (Options(), list(range(11))),
        (Options(frames=3), [0, 5, 10]),
        (Options(every=0.3), [0, 3, 6, 9, 10]),
        (Options(every=0.3, frames=2), [0, 10]),
        (Options(every=9.0), [0, 10]),
    ],
)
def test_frames_are_chosen(options, expected):
    assert choose_frames(np.arange(11) / 10.0, options).tolist() == expected


def test_the_film_is_what_the_file_holds(shown):
    show = Show(grid(6, 5), frames=6, cut=3)
    film = read_film(shown(show), Options())
    gone = show.crossing()
    assert np.array_equal(film.position[4, : film.node_count], show.place(4))
    assert film.lines.life[gone][:, 1] == pytest.approx(2.5)  # the event lies between frames
    assert (film.lines.life[~gone][:, 1] == FOREVER).all()
    strain = film.strain(2)
    assert film.lines.tension[2] == pytest.approx(
        10.0 * strain * film.lines.rest,
        rel=1e-5,
        abs=1e-9,  # of four bytes
    )
    torn = [
        t for t, life in zip(film.skin.triangles, film.skin.life, strict=True) if life[1] < 9
    ]
    x = show.network.position[np.array(torn)][:, :, 0]
    middle = show.network.position[:, 0].mean()
    assert (
        len(torn) == 2 * 4 and (x.min(axis=1) < middle).all() and (x.max(axis=1) > middle).all()
    )


def test_fewer_nodes_are_spread_and_stay_apart_where_they_were_cut(shown):
    show = Show(grid(40, 40), frames=4, cut=2)
    whole = read_film(shown(show), Options())
    film = read_film(shown(show), Options(nodes=200))
    assert 150 < film.node_count <= 200
    assert film.recorded == (1600, len(show.network.springs.ends), 0)
    # Every node that is drawn is one of the net.
    for frame in range(4):
        places = {tuple(place) for place in whole.position[frame].tolist()}
        drawn = film.position[frame, : film.node_count]
        assert {tuple(place) for place in drawn.tolist()} <= places
    alive = film.lines.life[:, 1] == FOREVER
    x = film.position[3][film.lines.ends][:, :, 0]
    middle = show.network.position[:, 0].mean() + 0.01
    assert not ((x.min(axis=1) < middle) & (x.max(axis=1) > middle))[alive].any()
    assert (~alive).any()


def test_a_line_for_many_springs_has_their_mean(shown):
    show = Show(grid(30, 30), frames=3)
    film = read_film(shown(show), Options(nodes=60))
    one = read_film(shown(show), Options())
    # A sheet at rest has no tension, however it is thinned; one that is not has no more of it.
    assert np.abs(film.lines.tension[0]).max() == pytest.approx(0.0, abs=1e-12)
    assert np.abs(film.strain(0)).max() == pytest.approx(0.0, abs=1e-12)
    assert one.lines.tension[2].min() <= film.lines.tension[2].min()
    assert film.lines.tension[2].max() <= one.lines.tension[2].max()


def test_outlines_keep_every_extreme():
    value = np.random.default_rng(4).normal(size=(10_000, 2))
    value[1234, 0], value[8888, 1] = 50.0, -60.0
    value[5000:6000, 0] = np.nan
    kept = outline(value, 400)
    assert len(kept) < 1000 and kept[0] == 0 and kept[-1] == 9999
    assert np.nanmax(value[kept, 0]) == 50.0 and np.nanmin(value[kept, 1]) == -60.0
    assert {4999, 5000, 5999, 6000} <= set(kept.tolist())  # where numbers end and begin
    assert outline(value[:300], 400).tolist() == list(range(300))


def test_springs_that_break_together_are_one_mark():
    events = [Event(0.5 + 1e-4 * k, "rupture", (k, k + 1), "too much", "") for k in range(9)]
    events += [
        Event(0.9, "rupture", (3,), "too much", ""),
        Event(1.0, "cut", (1,), "cut it", ""),
    ]
    events += [Event(1.5, "rupture", (3, 20, 21), "too much", "")] * 2
    # From 20 on, they are elements.
    found = marks(events, 2.0, SimpleNamespace(spring_count=20, line_count=20))
    assert [mark.text for mark in found] == [
        "18 springs ruptured", "1 spring ruptured", "cut it: 1 spring", "4 elements ruptured",
    ]  # fmt: skip
    assert [mark.sign for mark in found] == ["bolt", "bolt", "cross", "bolt"]


def test_every_kind_of_event_has_a_sign(repository):
    """The words that verbs enter into the log, as far as they stand in the code."""
    import re

    known = {kind for kinds in SIGNS.values() for kind in kinds} | set(BREAKING)
    for path in (repository / "tissuec" / "verbs").glob("*.py"):
        for kind in re.findall(r'Happening\("(\w+)"', path.read_text(encoding="utf-8")):
            assert kind in known, f"{path.name}: {kind}"


@pytest.mark.parametrize(
    ("duration", "expected"), [(2.0, 1.0), (0.0, 1.0), (0.06, 0.01), (60.0, 10.0), (1e-3, 2e-4)]
)
def test_the_pace_is_easy_to_follow(duration, expected):
    assert pace(duration) == expected


def test_steps_are_round_numbers():
    # On a scale of logarithms, where 3.16 lies between 2 and 5.
    assert [near(value) for value in (0.0031, 3.2, 7.2, 14.0)] == [0.002, 5.0, 10.0, 10.0]
