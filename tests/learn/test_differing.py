"""Whole runs predict what exact models predict, and find what these cannot."""

import numpy as np
import pytest

from tests.learn.lessons import fit_problem
from tests.learn.trials import (
    adjust,
    differing,
    experiment,
    fit,
    measured_at,
    moving,
    series,
    sheet,
)
from tissuec.core.structs import replace
from tissuec.learn.derivatives.model import slots_of
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.problem import FittedExperiment, Problem
from tissuec.learn.fit.search import Search

PUSH = "  from 10 ms to 60 ms: push right with (0, 0.05, 0.1) N using smooth profile"
FELT = (adjust("spring constant", "felt"), adjust("viscosity", "felt"))
TIMES = np.linspace(0.0, 0.1, 11)


def looked_at(compiled):
    """Return series of every shape, whose times differ."""
    fits = [
        fit(compiled, "positions", "middle"),
        fit(compiled, "positions", "right", along=(0, 1, 0)),
        fit(compiled, "force", "left"),
        fit(compiled, "force", "left", columns=3),
        fit(compiled, "force", "left", along=(0, 0, 1)),
        fit(compiled, "position", "right"),
        fit(compiled, "position", "right", along=(0, 0, 1)),
        fit(compiled, "distance", "left", "right"),
        fit(compiled, "length", "sheet"),
    ]
    return [series(one, TIMES[k % 3 :: 1 + k % 2]) for k, one in enumerate(fits)]


def test_runs_predict_what_exact_steps_predict():
    compiled = sheet(PUSH + "\n  at 50 ms: fix middle")
    arguments = compiled, FELT, looked_at(compiled)
    theta = np.array([0.1, -0.2])
    exact, runs = moving(*arguments, step=1e-3), differing(*arguments)
    expected, found = exact.predict(theta), runs.predict(theta)
    # The engine keeps errors to 1e-11 of the displacements, and exact steps are as fine.
    assert np.abs(found - expected).max() < 1e-9
    slopes, by_runs = exact.jacobian(theta), runs.jacobian(theta)
    for slot in slots_of(tuple(arguments[2])):
        mine = slice(slot.start, slot.start + slot.rows * slot.width)
        allowed = 1e-5 * np.abs(slopes[mine]).max()  # the square of the step, and more
        assert np.abs(by_runs[mine] - slopes[mine]).max() < allowed
    weights = np.random.default_rng(0).standard_normal(len(found))
    assert runs.gradient(theta, weights) == pytest.approx(by_runs.T @ weights)


def test_a_limit_leaves_out_what_is_later():
    compiled = sheet(PUSH)
    all_series = [series(fit(compiled, "position", "right", along=(0, 0, 1)), TIMES)]
    runs = differing(compiled, FELT, all_series)
    whole = runs.predict(np.zeros(2))
    runs.limit(0.043)
    found, slopes = runs.predict(np.zeros(2)), runs.jacobian(np.zeros(2))
    assert found[:5] == pytest.approx(whole[:5], abs=1e-12)  # 1e-11 of 3 mm, and rounding
    assert not found[5:].any()
    assert slopes[4].all()
    assert not slopes[5:].any()
    runs.limit(np.inf)
    assert np.array_equal(runs.predict(np.zeros(2)), whole)


def test_what_is_before_the_first_row_is_not_run():
    compiled = sheet(PUSH)
    runs = differing(compiled, FELT, [series(fit(compiled, "force", "left"), TIMES[1:])])
    runs.limit(1e-3)
    assert not runs.predict(np.zeros(2)).any()


def test_a_run_that_diverges_says_so():
    compiled = sheet(PUSH, simulate="integrator is velocity verlet; step = 2 ms")
    runs = differing(compiled, FELT, [series(fit(compiled, "force", "left"), TIMES)])
    assert np.isfinite(runs.predict(np.zeros(2))).all()
    with pytest.raises(Diverged) as caught:
        runs.predict(np.array([8.0, 0.0]))
    assert 0.0 <= caught.value.args[0] < 0.1


def test_slopes_beside_a_limit_are_from_one_side():
    compiled = sheet(PUSH)
    free, above = (
        differing(
            compiled,
            (adjust("spring constant", "felt", low=low, high=high),),
            [series(fit(compiled, "force", "left"), TIMES)],
        ).jacobian(np.zeros(1))
        for low, high in ((0.0, np.inf), (40.0, np.inf))
    )
    # The error of a difference from one side is as large as its step, not as its square.
    assert np.abs(above - free).max() < 1e-2 * np.abs(free).max()
    assert not np.array_equal(above, free)


def test_notes_say_why():
    probe = "tool probe { kind is probe; radius = 3 mm; centre = (10, 15, 9) mm }"
    compiled = sheet(sets=probe, contact="tools only; friction = 0.1")
    runs = differing(compiled, FELT, [series(fit(compiled, "force", "left"), TIMES)])
    said = "derivatives are finite differences of whole runs: contact has friction"
    assert runs.notes == (said,)


SCENES = {
    "contact": (
        "spring constant",
        "  from 0 s to 60 ms: move probe by (0, 0, 6) mm using smooth profile",
        {
            "sets": "tool probe { kind is probe; radius = 3 mm; centre = (10, 20, -5) mm }",
            "contact": "tools only",
        },
        "probe",
    ),
    "contact of faces": (
        "spring constant",
        "  from 0 s to 60 ms: move probe by (0, 0, 6) mm using smooth profile",
        {
            "sets": "tool probe { kind is probe; radius = 5 mm; centre = (10, 20, -7) mm }",
            "contact": "tools only; contact places is faces"
            "; contact surface stiffness = 1 MPa/m",
        },
        "probe",
    ),
    "relaxing": (
        "relaxation time",
        "  from 0 s to 20 ms: move right by (0, 3, 1) mm using smooth profile",
        {"tissue": "; relaxing constant = 60 N/m; relaxation time = 20 ms"},
        "right",
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_what_the_engine_was_run_with_is_found_again(name):
    what, script, options, pressed = SCENES[name]
    compiled = sheet(script, simulate="integrator is dop853; tolerance = 1e-3", **options)
    asked = (adjust(what, "felt"),)
    blank = [series(fit(compiled, "force", pressed, columns=3), TIMES[1:])]
    truth = np.array([np.log(1.02)])
    data = measured_at(blank, differing(compiled, asked, blank).predict(truth))
    model = differing(compiled, asked, data)
    task = replace(fit_problem(*(one.fit for one in data)), adjusts=asked, passes=1)
    problem = Problem(task, [FittedExperiment(experiment(data), model)], model.shaping.size, [])
    search = Search(problem, model.shaping.bounds(), lambda standing: None)
    found = search.go(search.begin())
    # Data and predictions come from runs with errors of 1e-6 of the displacements.
    assert found.theta == pytest.approx(truth, abs=1e-4)
