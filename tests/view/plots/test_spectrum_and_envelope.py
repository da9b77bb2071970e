"""Spectra of logs, and means of several runs."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from tests.view.plots.conftest import carry_out
from tests.view.plots.test_x_y import SWUNG
from tissuec.core.errors import TissueError
from tissuec.results.trajectory import Trajectory
from tissuec.view.plots import draw
from tissuec.view.plots.quantities import LoggedQuantity
from tissuec.view.plots.quantity_plots import common, spectrum_of

pytestmark = pytest.mark.usefixtures("unplaced")

AMPLITUDE, FREQUENCY = 0.3, 50.0  # N, Hz


def sine(time):
    value = 2.0 + AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time)
    return LoggedQuantity("force", "N", 2.3, time, value)


def test_a_sine_has_its_peak_and_by_parseval_its_variance():
    found = spectrum_of(sine(np.arange(9000) * 1e-3), segment=2.0)
    assert (found.segment, found.count, found.is_interpolated) == (2000, 8, False)
    assert found.peak == pytest.approx(FREQUENCY, abs=1e-9)
    assert found.variance == pytest.approx(AMPLITUDE**2 / 2.0, rel=1e-9)
    # A Hann window spreads a sine over three lines: 1/4, 1, 1/4 of amplitude² · segment / 3.
    assert found.density.max() == pytest.approx(AMPLITUDE**2 * 2.0 / 3.0, rel=1e-9)
    assert (found.density > 1e-9).sum() == 3


def test_noise_has_its_variance():
    value = np.random.default_rng(3).normal(0.0, 1.5, 100_000)
    time = np.arange(len(value)) * 1e-4
    found = spectrum_of(LoggedQuantity("noise", "m", 5.0, time, value))
    assert found.variance == pytest.approx(value.var(), rel=0.02)
    assert found.count == 8
    assert trapezoid(found.density, found.frequency) == pytest.approx(found.variance, rel=1e-3)


def test_uneven_logs_are_brought_to_even_steps():
    time = np.arange(9000) * 1e-3
    uneven = time + np.random.default_rng(1).uniform(-2e-4, 2e-4, len(time))
    found = spectrum_of(sine(uneven), segment=2.0)
    assert found.is_interpolated and found.peak == pytest.approx(FREQUENCY, rel=1e-4)
    assert found.variance == pytest.approx(AMPLITUDE**2 / 2.0, rel=0.02)
    # Both sides of an event are no step.
    twice = np.insert(time, 100, time[100])
    assert not spectrum_of(sine(twice)).is_interpolated


@pytest.fixture(scope="module")
def swings(tmp_path_factory):
    """Return two runs of an end that swings, the second one logged more coarsely."""
    folder = tmp_path_factory.mktemp("swings")
    coarse = SWUNG.replace("force of hand every 0.1 ms", "force of hand every 0.3 ms")
    paths = [
        carry_out(text, folder / f"{name}.vtkhdf")
        for name, text in (("fine", SWUNG), ("coarse", coarse.replace("20.0 N/m", "30.0 N/m")))
    ]
    with Trajectory.open(paths[0]) as one, Trajectory.open(paths[1]) as other:
        yield one, other


def test_the_spectrum_of_a_log_states_its_method(swings):
    figure = draw(None, swings[0], spectrum="force of hand along x", segment=0.1)
    assert figure.kind == "spectrum"
    found = figure.numbers["spectra"]["fine"]
    assert (found["window"], found["overlap"], found["unit"]) == ("hann", 0.5, "N^2/Hz")
    assert found["segment"] == pytest.approx(0.1) and found["peak"] == pytest.approx(10.0)
    assert sum(found["density"]) * 10.0 == pytest.approx(found["variance"])
    assert any("Hann window" in note and "overlap 50 %" in note for note in figure.notes)
    (axes,) = figure.axes
    label = axes.get_ylabel().replace("\n", " ")
    assert label == "power spectral density of force of hand along x [mN²/Hz]"
    (line,) = axes.get_lines()
    assert np.asarray(line.get_ydata()) == pytest.approx(1e6 * np.array(found["density"][1:]))


def test_an_envelope_contains_all_runs(swings):
    figure = draw(None, *swings, envelope="force of hand along x")
    assert figure.kind == "envelope"
    found = figure.numbers["envelope"]["force of hand along x"]
    fine, coarse = (run.logs["force of hand"] for run in swings)
    assert found["interpolated"] and found["time"] == pytest.approx(fine.time.tolist())
    values = fine.value[:, 0], np.interp(fine.time, coarse.time, coarse.value[:, 0])
    assert found["mean"] == pytest.approx(np.mean(values, axis=0), abs=1e-12)
    assert found["low"] == pytest.approx(np.min(values, axis=0), abs=1e-12)
    assert found["high"] == pytest.approx(np.max(values, axis=0), abs=1e-12)
    assert any("3001 times of the finest log" in note for note in figure.notes)


def test_equal_times_are_not_interpolated():
    time = np.linspace(0.0, 1.0, 30)
    logs = [LoggedQuantity("force", "N", 1.0, time, k * time) for k in (1.0, 3.0)]
    both = common(logs)
    assert not both.is_interpolated and both.value.mean(axis=0) == pytest.approx(2.0 * time)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "spectrum"}, "--spectrum is missing"),
        ({"kind": "envelope"}, "--envelope is missing"),
        ({"spectrum": "force of hnd"}, "force of hand"),
        ({"spectrum": "length of net", "segment": 9.0}, "must be between"),
        ({"spectrum": "length of net", "stop": 2e-3}, "needs 16 or more"),
    ],
)
def test_what_is_wrong_is_said(swings, options, message):
    with pytest.raises(TissueError, match=message):
        draw(options.pop("kind", None), swings[0], **options)


def test_runs_without_a_common_time_have_no_envelope():
    logs = [
        LoggedQuantity("force", "N", 1.0, start + np.linspace(0.0, 1.0, 30), np.zeros(30))
        for start in (0.0, 2.0)
    ]
    with pytest.raises(TissueError, match="no common time"):
        common(logs)
