"""The examples of learning are good, and what they are learnt from gives what the page says."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from tissuec.learn.fit.learning import learn
from tissuec.pipeline import check_request, compile_request
from tissuec.scene.request import Request

NAMES = ("band", "cart", "gel", "gels", "learn_band", "learn_gels", "stretch")
# Their data are results of runs: see test_exact_models.
EXACT = ("exact_block", "exact_tube")
NETS = ("block_net", "tube_net", "words_net")


@pytest.fixture
def examples(repository):
    return repository / "docs" / "examples" / "learning"


def learnt(path: Path):
    request = Request.file(path)
    compiled, _ = compile_request(request)
    return learn(compiled, compiled.fit_problems[0], request)


def assert_known(found, true):
    """The truth is within one and a half times the interval of 95 %: three deviations."""
    for estimates, number in zip(found.estimates, true, strict=True):
        (value,), (low,), (high,) = estimates.value, estimates.low, estimates.high
        assert value - 1.5 * (value - low) < number < value + 1.5 * (high - value)
    assert found.converged and not found.blind


def test_all_are_there(examples):
    assert {path.stem for path in examples.glob("*.tis")} == {*NAMES, *EXACT, *NETS}
    assert sum(path.stat().st_size for path in examples.iterdir() if path.is_file()) < 200_000


@pytest.mark.parametrize("name", NAMES + EXACT)
def test_an_example_is_checked_without_a_warning(name, examples):
    _, warnings = check_request(Request.file(examples / f"{name}.tis"))
    # The cart's springs are stretched as it starts, as those that were measured.
    assert {one.code for one in warnings} <= ({"W309"} if name == "cart" else set())


def test_data_is_made_anew_to_the_last_digits(examples, tmp_path):
    for path in examples.iterdir():
        if path.suffix in (".tis", ".py"):
            (tmp_path / path.name).write_bytes(path.read_bytes())
    runpy.run_path(str(tmp_path / "make_data.py"), run_name="__main__")
    made = sorted(tmp_path.glob("*.csv"))
    assert len(made) == 6
    for path in made:
        new, old = (
            np.genfromtxt(p, delimiter=",", skip_header=1) for p in (path, examples / path.name)
        )
        # Runs differ by their tolerance, which may turn the last written digit.
        np.testing.assert_allclose(
            new, old, rtol=0, atol=0.1 if path.stem == "stretch" else 0.02
        )


def test_the_law_of_a_tendon_is_learnt_without_a_time(examples):
    found = learnt(examples / "stretch.tis")
    assert_known(found, (60.0, 9.0))
    assert found.fitted[1].held_out and found.fitted[1].error < 0.05


@pytest.mark.slow
def test_the_band_is_learnt_by_another_method_than_made_the_data(examples):
    found = learnt(examples / "learn_band.tis")
    assert_known(found, (20e3, 1.2e-3, 1100.0))
    # Noise of 0.5 mN and 20 um alone is 2.3 % of how far the held-out data spreads.
    assert found.fitted[1].held_out and found.fitted[1].error < 0.025
    force, place = found.noise.values()
    # From 151 numbers, a deviation is known to 6 % and, of the fifty forces, to 10 %.
    assert force == pytest.approx(0.5e-3, rel=0.3)
    assert place == pytest.approx(20e-6, rel=0.2)


@pytest.mark.slow
def test_the_cart_comes_back_to_the_noise_of_its_data(examples):
    found = learnt(examples / "cart.tis")
    assert found.converged and not found.blind
    # 0.2 px of tracking, and whole pixels: 1/√12 px. From 218 numbers, it is known to 5 %.
    noise = 1e-3 * np.hypot(0.2, 1.0 / np.sqrt(12.0))
    for one in found.fitted:
        assert next(iter(one.left.values())) == pytest.approx(noise, rel=0.12)
    constant, viscosity = found.estimates[:2]
    assert constant.value[0] == pytest.approx(3.0, rel=2e-4)
    assert viscosity.value[0] == pytest.approx(8e-3, rel=0.02)


@pytest.mark.slow
def test_words_of_gels_come_near_those_that_were_meant(examples):
    found = learnt(examples / "learn_gels.tis")
    assert found.fitted[1].held_out and found.fitted[1].error < 0.1
    (text,) = found.words.values()
    rows = {line.split(" =")[0].strip(): line for line in text.splitlines() if "N/m, " in line}
    peaks = [
        float(rows[word].split(", ")[k].split()[0]) for word, k in (("medium", 1), ("high", 1))
    ]
    assert peaks == pytest.approx([32.0, 120.0], rel=0.03)
