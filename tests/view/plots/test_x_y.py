"""One quantity against another, and the work in its loops."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from tests.view.plots.conftest import carry_out
from tissuec.core.errors import TissueError
from tissuec.results.trajectory import Trajectory
from tissuec.view.plots import draw
from tissuec.view.plots.quantities import LoggedQuantity, quantity
from tissuec.view.plots.quantity_plots import joined

pytestmark = pytest.mark.usefixtures("unplaced")

SPRING, DAMPER, SPAN, ROUNDS = 20.0, 0.5, 2e-3, 10.0  # N/m, N*s/m, m, 1/s
#: A spring with a damper whose end swings; two measures of different times.
SWUNG = f"""language 1
tissue gum {{ spring constant = {SPRING} N/m; viscosity = {DAMPER} N*s/m; mass = 1 mg }}
body net {{ mesh is explicit; tissue is gum }}
table nodes of net in mm with columns "id x" {{ 1 0; 2 100 }}
table springs of net with columns "a b" {{ 1 2 }}
set wall = nodes of net in [1]
set hand = nodes of net in [2]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix wall
  from 0 s to 0.3 s: move hand by ({1e3 * SPAN}, 0, 0) mm using sine of {ROUNDS} Hz
}}
simulate {{ duration = 0.3 s; tolerance = 1e-6 }}
output {{
  position of hand every 0.1 ms; force of hand every 0.1 ms
  length of net every 0.7 ms; tension of net every 0.7 ms
}}
"""


@pytest.fixture(scope="module")
def swung(tmp_path_factory):
    """Return the run of a spring whose end swings three times."""
    folder = tmp_path_factory.mktemp("swung")
    with Trajectory.open(carry_out(SWUNG, folder / "swung.vtkhdf")) as run:
        yield run


def test_a_damper_loses_in_each_loop_what_its_formula_says(swung):
    """π c ω A² for a Kelvin–Voigt spring moved as a sine; chords of 1000 rows lose 1e-5."""
    figure = draw(
        "x-y", swung, x="displacement of hand along x", y="force of hand along x",
        start=0.1, stop=0.2,
    )  # fmt: skip
    area = figure.numbers["areas"]["swung"]
    assert area["unit"] == "J"
    lost = np.pi * DAMPER * (2.0 * np.pi * ROUNDS) * SPAN**2
    assert abs(area["value"]) == pytest.approx(lost, rel=1e-4)
    (axes,) = figure.axes
    assert axes.get_xlabel() == "displacement of hand along x [mm]"
    assert axes.get_ylabel() == "force of hand along x [mN]"


def test_the_area_is_that_of_the_log(swung):
    place, force = swung.logs["position of hand"], swung.logs["force of hand"]
    rows = (place.time >= 0.1 - 1e-12) & (place.time <= 0.25 + 1e-12)
    found = draw(
        "x-y", swung, x="position of hand along x", y="force of hand along x",
        start=0.1, stop=0.25,
    )  # fmt: skip
    area = trapezoid(force.value[rows, 0], place.value[rows, 0])
    assert found.numbers["areas"]["swung"]["value"] == pytest.approx(area, rel=1e-9)


def test_different_times_are_interpolated_and_it_is_said(swung):
    figure = draw("x-y", swung, x="length of net", y="force of hand along x")
    assert any("different times" in note for note in figure.notes)
    figure = draw("x-y", swung, x="position of hand along x", y="force of hand along x")
    assert not any("different times" in note for note in figure.notes)


def test_displacements_begin_where_one_says(swung):
    place = swung.logs["position of hand"]
    for zero, row in ((None, 0), (0.1, int(np.searchsorted(place.time, 0.1)))):
        found = quantity(swung, "displacement of hand along x", zero)
        assert found.value == pytest.approx(place.value[:, 0] - place.value[row, 0], abs=1e-15)
    distance = quantity(swung, "displacement of hand")
    assert distance.value == pytest.approx(
        np.linalg.norm(place.value - place.value[0], axis=1), abs=1e-15
    )


def test_a_circle_encloses_its_area():
    time = np.linspace(0.0, 1.0, 2001)
    turn = 2.0 * np.pi * time
    x, y = (
        LoggedQuantity("one", "m", 1.0, time, value) for value in (np.cos(turn), np.sin(turn))
    )
    assert joined(x, y).area == pytest.approx(-np.pi, rel=1e-5)  # anticlockwise


def test_times_begin_where_one_says(swung):
    figure = draw("x-y", swung, x="time", y="force of hand", zero=0.1, start=0.11, stop=0.2)
    (axes,) = figure.axes
    assert axes.get_xlabel() == "time after 100 ms [ms]"
    times = np.asarray(axes.get_lines()[0].get_xdata())
    assert (times[0], times[-1]) == pytest.approx((10.0, 100.0))
    assert not figure.numbers


def test_logarithmic_axes(swung):
    (axes,) = draw("x-y", swung, x="time", y="force of hand", scale=("x=log", "y=log")).axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"x": "time"}, "--y is missing"),
        ({"x": "time", "y": "force of hnd"}, "force of hand"),
        ({"x": "position of hand", "y": "force of hand"}, 'write "position of hand along z"'),
        ({"x": "time", "y": "force of hand", "scale": "y=lin"}, "not a scale of an axis"),
        ({"x": "time", "y": "force of hand", "start": 2.0}, "nothing to show"),
    ],
)
def test_what_is_wrong_is_said_with_a_remedy(swung, options, message):
    with pytest.raises(TissueError, match=message):
        draw("x-y", swung, **options)


def test_over_time_there_is_no_area(result):
    figure = draw("x-y", result, x="time", y="force of right end along z")
    assert figure.numbers == {}
