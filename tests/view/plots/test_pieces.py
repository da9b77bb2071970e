"""What plots are made of: units of axes, places of names, views, marks."""

import numpy as np
import pytest

from tests.every import every
from tissuec.core.scale import readable, scale_of
from tissuec.core.units import DIMENSION_NAMES, parse_unit
from tissuec.results.recording import Event
from tissuec.script.measures import MEASURES
from tissuec.view.plots.axes import MOST, clusters
from tissuec.view.plots.curves import spread, thinned, thinned_band
from tissuec.view.plots.projection import Projection, viewpoint

UNITS = sorted({unit for _, unit in DIMENSION_NAMES.values()} - {"1/s"})  # which has no symbol


@pytest.mark.parametrize("unit", UNITS)
def test_what_stands_at_an_axis_is_the_same_quantity(unit):
    """Numbers times factor, in the unit that is shown, are the numbers in SI units."""
    for size in 10.0 ** np.arange(-14.0, 12.0):
        scale = scale_of(unit, [size])
        shown = scale.unit.replace("·", "*").replace("²", "^2").replace("³", "^3")
        if not unit:
            assert (scale.unit, scale.factor) == ("", 1.0)
            continue
        found = parse_unit(shown)
        assert found.dimension == parse_unit(unit).dimension
        assert scale.factor * found.factor == pytest.approx(parse_unit(unit).factor)


@every(
    ("unit", "highest"),
    [("N", 11.5), ("Pa", 11.5), ("J", 11.5), ("N/m", 11.5), ("N*s/m", 11.5), ("m/s", 2.5),
     ("m", 5.5), ("s", 2.5)],
)  # fmt: skip
def test_numbers_at_an_axis_lie_between_one_and_a_thousand(unit, highest):
    """From the smallest unit that the language has, to the largest that people use."""
    for size in 10.0 ** np.linspace(-8.5, highest, 70):
        assert 0.999 <= scale_of(unit, [-size]).of(size) < 1000.5


def test_prefixes_are_those_that_people_expect():
    for unit, size, wanted in (
        ("m", 0.064, "mm"), ("m", 1.2, "m"), ("m", 0.0, "m"), ("N", 0.02, "mN"),
        ("N", 0.0, "N"), ("s", 0.4, "ms"), ("s", 1.4, "s"), ("s", 4000.0, "s"),
        ("m^3", 1.3e-4, "ml"), ("m^3/s", 5e-6, "ml/s"), ("kg", 3e-5, "mg"), ("kg", 20.0, "kg"),
        ("N*s/m", 0.2, "mN·s/m"), ("m^2", 1e-6, "m²"), ("1/s", 5.0, "1/s"), ("", 0.3, ""),
        ("J", 1e-7, "nJ"), ("J", 2e-5, "µJ"), ("m^3", 0.0, "l"),
    ):  # fmt: skip
        assert scale_of(unit, [size]).unit == wanted, (unit, size)
    assert scale_of("N", [np.nan, np.inf, 0.02]).unit == "mN"
    assert readable("kg*m^3") == "kg·m³"


def test_every_measure_has_a_label_with_its_unit():
    from tissuec.core.units import NUMBER, si_unit

    for measure in MEASURES.values():
        label = scale_of(si_unit(measure.dimension), [1e-3]).label("it")
        assert ("[" in label) == (measure.dimension != NUMBER)


@every("seed", range(30))
def test_names_are_apart_in_order_and_as_near_as_can_be(seed):
    random = np.random.default_rng(seed)
    wanted, gap = random.random(random.integers(2, 7)), 0.1
    found = np.array(spread(wanted.tolist(), gap))
    assert (found >= 0.0).all() and (found <= 1.0 + 1e-12).all()
    order = np.argsort(wanted)
    assert (np.diff(found[order]) >= gap - 1e-12).all()
    alone = np.diff(np.sort(wanted)).min() >= gap
    if alone and wanted.max() <= 1.0:
        assert found == pytest.approx(wanted)
    # Small moves of the block that stay allowed bring no name nearer on the whole.
    best = ((found - wanted) ** 2).sum()
    for _ in range(200):
        other = np.sort(found + random.normal(0.0, 0.02, len(found)))
        allowed = (np.diff(other) >= gap).all() and other[0] >= 0.0 and other[-1] <= 1.0
        if allowed:
            assert ((other - wanted[order]) ** 2).sum() >= best - 1e-9


def test_more_names_than_there_is_room_for_share_it():
    assert spread([0.5] * 5, 0.4) == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])


def test_short_curves_are_drawn_as_they_are_and_long_ones_keep_their_extremes():
    x = np.linspace(0.0, 1.0, 5000)
    assert thinned(x, x)[0] is x
    x = np.linspace(0.0, 1.0, 200_000)
    y = np.sin(40.0 * x)
    y[123_457], y[77_777] = 9.0, -9.0
    few, values = thinned(x, y)
    assert len(few) <= 5002
    assert (values.max(), values.min()) == (9.0, -9.0)
    assert (np.diff(few) > 0.0).all()
    assert np.interp(few, x, y) == pytest.approx(values)
    t, low, high = thinned_band(x, y - 1.0, y + 1.0)
    assert (len(t), low.min(), high.max()) == (2501, -10.0, 10.0)
    # A band is nowhere narrower than the one that it stands for.
    row = np.searchsorted(t, x, side="right") - 1
    assert (low[row] <= y - 1.0 + 1e-9).all() and (high[row] >= y + 1.0 - 1e-9).all()


@pytest.mark.parametrize("azimuth", [-170.0, -110.0, 0.0, 35.0])
@pytest.mark.parametrize("elevation", [-90.0, -10.0, 22.0, 90.0])
def test_a_view_is_a_rotation(azimuth, elevation):
    view = Projection(azimuth, elevation)
    frame = view.frame
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert frame[1, 2] >= -1e-12  # what is up stays up
    points = np.random.default_rng(1).normal(size=(5, 3))
    both = np.column_stack([view.flat(points), view.nearness(points)])
    assert both @ frame == pytest.approx(points)


def test_views_along_axes_know_their_axes():
    assert Projection(-90.0, 0.0).axes == ("x", "z")
    assert Projection(0.0, 0.0).axes == ("y", "z")
    assert Projection(-90.0, 90.0).axes == ("x", "y")
    assert Projection(90.0, 0.0).axes == ("−x", "z")
    assert Projection(-90.0, 10.0).axes is None


def test_flat_nets_are_looked_at_from_straight_before_them():
    corners = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
    for turn, axes in ((0, ("x", "y")), (1, ("y", "z")), (2, ("x", "z"))):
        assert Projection(*viewpoint(np.roll(corners, turn, axis=1))).axes == axes
    assert Projection(*viewpoint(np.random.default_rng(0).random((9, 3)))).axes is None
    assert viewpoint(np.zeros((0, 3))) == viewpoint(np.ones((1, 3)))


def event(time, kind):
    return Event(time, kind, (), "", "")


def test_marks_tell_what_happened_close_together_and_leave_out_no_news():
    events = [
        event(0.0, "fix"), event(0.5, "cut"), event(0.501, "rupture"), event(0.502, "rupture"),
        event(0.7, "end"), event(0.9, "note"), event(1.0, "release"), event(3.0, "cut"),
    ]  # fmt: skip
    assert clusters(events, (0.0, 2.0)) == [(0.5, "cut, rupture × 2"), (1.0, "release")]
    assert clusters(events, (0.6, 4.0)) == [(1.0, "release"), (3.0, "cut")]


def test_of_many_marks_those_of_motions_are_left_out():
    moves = [event(0.1 * n, "move") for n in range(1, MOST + 1)]
    assert len(clusters(moves, (0.0, 2.0))) == MOST
    assert clusters([*moves, event(1.5, "cut")], (0.0, 2.0)) == [(1.5, "cut")]


def test_a_sheet_is_seen_from_where_its_motion_is_seen():
    sheet = np.array([[x, y, 0.0] for x in (0.0, 3.0) for y in (0.0, 2.0)])
    above = viewpoint(sheet)
    lifted, shifted, trembling = np.zeros((3, 4, 3))
    lifted[:, 2], shifted[:, 0], trembling[:, 2] = [0.0, 0.0, 1.0, 1.0], 1.0, 1e-4
    assert Projection(*above).axes == ("x", "y")
    assert viewpoint(sheet, [shifted]) == viewpoint(sheet, [trembling]) == above
    aslant = Projection(*viewpoint(sheet, [shifted, lifted]))
    seen = np.ptp(aslant.flat(sheet + lifted) - aslant.flat(sheet), axis=0)[1]
    assert seen > 0.7
