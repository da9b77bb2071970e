"""Learning on workers gives the bits of learning without; intervals by bootstrap are right."""

from functools import cache

import numpy as np
import pytest

import tissuec
from tissuec.core.workers.processes import Processes
from tissuec.core.workers.workers import LOST, OwnProcess
from tissuec.learn.fit import evaluations, learning
from tissuec.learn.fit.bootstrap import intervals, resampled
from tissuec.learn.fit.learning import learn
from tissuec.learn.fit.session import prepare
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SWING = """language 1
tissue gum {{ spring constant = {c} N/m; viscosity = {d} mN*s/m; mass = 2 g }}
body net {{ mesh is explicit; tissue is gum }}
table nodes of net in mm with columns "id x" {{ 1 0; 2 100; 3 200 }}
table springs of net with columns "a b" {{ 1 2; 2 3 }}
set wall = nodes of net in [1]
set tip = nodes of net in [3]
{tool}
environment {{ gravity = (0, 0, 0) m/s^2; contact is {contact} }}
script {{ at 0 s: fix wall; at 0 s: change velocity of tip to (0.5, 0, 0) m/s }}
simulate {{ duration = 0.1 s; tolerance = 1e-5 }}
output {{ position of tip every 2 ms }}
"""
LEARN = """learn gum {{
  data = "data.csv"
  fit = position(tip along (1, 0, 0)) using column "position of tip" in m
  adjust = [spring constant, viscosity]
  {more}
}}
"""
TOUCHED = {
    "tool": "tool ball { kind is probe; radius = 5 mm; centre = (230 mm, 0 mm, 0 mm) }",
    "contact": "tools only; friction = 0.1; contact stiffness = 1 N/mm",
}


def measured(folder, *, noise=1e-4, more="", start=(2.0, 8.0), tool="", contact="off"):
    """Return a scene that begins elsewhere than the truth of its data, and its request."""

    def text(c, d):
        return SWING.format(c=c, d=d, tool=tool, contact=contact)

    run = tissuec.run(text(3.0, 12.0), companion="off").logs["position of tip"]
    random = np.random.default_rng(1)
    x = run.value[:, 0] + noise * random.standard_normal(len(run.time))
    table = np.column_stack([run.time, x])
    np.savetxt(
        folder / "data.csv", table, "%.17g", ",", header="t_s,position of tip", comments=""
    )
    path = folder / "scene.tis"
    path.write_text(text(*start) + LEARN.format(more=more))
    request = Request.file(path)
    return compile_request(request)[0], request


def learnt(scene, workers=None):
    compiled, request = scene
    return learn(compiled, compiled.fit_problems[0], request, workers=workers)


def numbers(found):
    return [
        (one.value.tolist(), one.low.tolist(), one.high.tolist()) for one in found.estimates
    ]


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Return a function that gives what is learnt without workers, found once for all tests."""

    @cache
    def found(**given):
        return learnt(measured(tmp_path_factory.mktemp("alone"), **given))

    return found


@pytest.fixture
def processes(monkeypatch):
    """Return two processes that do all but the first evaluation."""
    monkeypatch.setattr(evaluations, "PAYS", 0.0)
    monkeypatch.setattr(evaluations, "GOES_ON", 0.0)
    with Processes(2) as both:
        yield both


@pytest.mark.parametrize(
    "given",
    [
        {"more": "bootstrap = 60"},
        # So far off that starts are sampled.
        pytest.param({"start": (300.0, 0.1)}, marks=pytest.mark.slow),
        # With differences of whole runs.
        pytest.param(TOUCHED, marks=pytest.mark.slow),
    ],
    ids=["bootstrap", "starts", "whole runs"],
)
def test_workers_find_the_same_bits(tmp_path, processes, alone, given):
    scene = measured(tmp_path, **given)
    handed, inner = [], processes.map

    def counting(work, common, items):
        handed.append(len(items))
        return inner(work, common, items)

    processes.map = counting
    known, together = alone(**given), learnt(scene, processes)
    assert handed and numbers(known) == numbers(together)
    assert known.evaluations == together.evaluations
    assert known.notes == together.notes


@pytest.mark.parametrize("fits", [60, pytest.param(400, marks=pytest.mark.slow)])
def test_intervals_by_bootstrap_are_those_of_derivatives(alone, fits):
    plain, found = alone(), alone(more=f"bootstrap = {fits}")
    assert any(f"bootstrap with {fits} fits" in one for one in found.notes)
    # Noise is white and small, so that the model is linear in its range. The standard error of
    # either percentile of n fits is 2.7 standard deviations / sqrt(n), of a width of 3.9: three
    # of these.
    close = 3.0 * 2.7 / 3.9 / np.sqrt(fits)
    for one, other in zip(plain.estimates, found.estimates, strict=True):
        assert one.value == other.value
        width, known = other.high - other.low, one.high - one.low
        assert width == pytest.approx(known, rel=close)
        assert np.abs(other.low + other.high - one.low - one.high) < close * known
        assert (width != known).all()


def test_a_seed_gives_other_resamples(tmp_path, monkeypatch):
    monkeypatch.setattr(
        learning,
        "intervals",
        lambda evaluator, end, draws, _, done: intervals(evaluator, end, draws, 3, done),
    )
    first, other = (
        numbers(learnt(measured(tmp_path, more=f"bootstrap = 40; seed = {seed}")))
        for seed in (0, 1)
    )
    assert first != other


def test_resampled_data_have_the_gaps_and_the_noise_of_the_measured(tmp_path):
    compiled, request = measured(tmp_path, start=(3.0, 12.0))
    problem = prepare(compiled, compiled.fit_problems[0], request).problem
    theta = np.zeros(problem.size)
    problem.freeze(theta)
    problem.data[7] = np.nan
    predicted = problem.predicted(theta)
    noise, slow = 0.3, 0.8
    many = np.array(
        [
            resampled(problem, theta, [(noise, slow, 0.0)], np.random.default_rng(k))
            for k in range(400)
        ]
    )
    assert np.isnan(many[:, 7]).all() and np.isnan(many).sum() == 400
    left = many - predicted
    # 400 paths of 50 rows that are correlated by 0.8: some 2000 independent numbers.
    assert np.nanstd(left) == pytest.approx(noise, rel=0.05)
    assert abs(np.nanmean(left)) < 0.1 * noise
    for apart in (1, 2):
        pairs = left[:, 8 + apart :] * left[:, 8:-apart]
        assert np.mean(pairs) == pytest.approx(noise**2 * slow**apart, rel=0.1)
    # The gap is two rows long.
    assert np.mean(left[:, 8] * left[:, 6]) == pytest.approx(noise**2 * slow**2, rel=0.25)


class Dying(OwnProcess):
    """A worker that dies of everything."""

    def map(self, work, common, items):
        yield from ((number, LOST) for number in range(len(items)))


def test_fits_that_workers_died_of_are_told(tmp_path, monkeypatch, alone):
    monkeypatch.setattr(evaluations, "PAYS", 0.0)
    monkeypatch.setattr(evaluations, "GOES_ON", 0.0)
    monkeypatch.setattr(evaluations, "OwnProcess", Processes)  # so that it is asked at all
    found = learnt(measured(tmp_path, more="bootstrap = 40"), Dying())
    assert "more than 20% of 40 fits" in " ".join(found.notes)
    assert numbers(found) == numbers(alone())  # the intervals are from derivatives
    with pytest.raises(tissuec.TissueError, match="workers died"):
        learnt(measured(tmp_path, **TOUCHED), Dying())
