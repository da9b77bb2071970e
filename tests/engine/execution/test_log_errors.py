"""The companion tells the error of logs, and whether it decides expectations otherwise."""

import re
import warnings

import numpy as np
import pytest

import tissuec
from tests.every import every
from tissuec.core.errors import SimulationError
from tissuec.core.source import Source
from tissuec.engine.execution import courses
from tissuec.engine.execution.courses import Courses, Observations
from tissuec.engine.method import Samples
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.verbs import LoggedEvent

METHODS = "dop853", "rkn4", "trbdf2", "esdirk43"
#: Eight elements with a retardation time that settle and are pushed; then those of the upper
#: layer are removed. Their nodes fly away, and errors are relative to their way, while the
#: force is that of the lower half.
CUT = """language 1
tissue gel {{
  Young's modulus = 40 kPa; Poisson's ratio = 0.25; density = 1050 kg/m^3
  retardation time = 0.46 ms{more}
}}
body block {{
  made of elements; tissue is gel
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }}
}}
set low = nodes of block where z < 0.1 mm
set upper = springs of block where z > 7.4 mm and z < 7.6 mm
set high = nodes of block where z > 9.9 mm
set corner = nodes of block where z > 9.9 mm and x < 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix low
  {script}
}}
simulate {{ duration = 16 ms; tolerance = 1e-3; integrator is dop853 }}
output {{ trajectory every 1 ms; force(low) every {rate}; kinetic energy(block) every 1 ms }}
"""
PUSHED = """at 0 s: settle
  from 2 ms to 12 ms: push corner with (0.1, -0.09, -0.06) N
  at 4.5 ms: cut upper"""
PRESSED = """from 0 s to 12 ms: press block with 2 kPa using ramp
  at 7 ms: cut upper"""
MOVED = "from 0 s to 6 ms: move high by (1, 0.5, -1) mm using constant speed"


def scene(script=PUSHED, more="", rate="1 ms", further=""):
    return CUT.format(script=script, more=more, rate=rate) + further


def ran(text, method="dop853", tolerance="1e-3", companion="inline", **options):
    text = text.replace("integrator is dop853", f"integrator is {method}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        text = text.replace("tolerance = 1e-3", f"tolerance = {tolerance}")
        return tissuec.run(text, companion=companion, **options)


def check_errors(text, method):
    """Check that no error of a log is larger than what is said of it."""
    exact = ran(text, "dop853", "1e-6", companion="off")  # a thousandth
    result = ran(text, method)
    assert result.promise.logs.keys() == {"force of low", "kinetic energy of block"}
    for name, said in result.promise.logs.items():
        values, right = result.logs[name].value, exact.logs[name].value
        apart, largest = np.abs(values - right).max(), np.abs(values).max()
        # Companions have errors of their own: what is said is more, but no other order of size.
        assert apart <= said.apart < 20.0 * apart, name
        assert said.error == pytest.approx(said.apart / largest)
        assert said.largest == largest and said.unit == result.logs[name].unit


@pytest.mark.parametrize("method", METHODS)
def test_errors_of_logs_are_at_most_what_is_said(method):
    check_errors(scene(), method)


RELAXING = "; relaxing share = 40 %; relaxation time = 2 ms"
OTHERS = {
    "pressed": scene(PRESSED, RELAXING),
    "moved": scene(MOVED),
    "densely logged": scene(rate="0.05 ms"),
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize("method", METHODS)
def test_errors_of_logs_of_other_scenes_are_at_most_what_is_said(method, name):
    check_errors(OTHERS[name], method)


def test_kept_is_said_of_positions_and_errors_of_logs_beside_it():
    result = ran(scene(), "esdirk43")
    promise = result.promise
    assert str(promise) == "kept" and promise.error < 1e-3
    assert promise.logs["force of low"].error > 0.02  # 20 times the tolerance
    assert re.fullmatch(
        r"up to \d\.\de-\d\d of the largest value \(force of low\)", promise.sentence_on_logs
    )


EXPECTING = "expect force(low) < 30 mN over run\nexpect not ruptured(block) over run\n"


@pytest.mark.parametrize("companion", ["inline", "process"])
def test_what_companions_compare_changes_no_bit_of_the_run(companion):
    text = scene(further=EXPECTING)
    alone, accompanied = ran(text, companion="off"), ran(text, companion=companion)
    assert not alone.promise.logs and accompanied.promise.logs
    assert np.array_equal(alone.position[:], accompanied.position[:])
    for name, log in alone.logs.items():
        assert np.array_equal(log.value, accompanied.logs[name].value)
    assert alone.expectations == accompanied.expectations


def test_errors_of_logs_are_the_same_whoever_steps_the_companion():
    one, other = (ran(scene(), companion=mode).promise.logs for mode in ("inline", "process"))
    assert one == other


def test_what_needs_the_energies_of_the_run_is_left_out():
    text = scene().replace("kinetic energy(block)", "energy drift")
    result = ran(text + "expect energy drift < 50 % over run\n")
    assert result.promise.logs.keys() == {"force of low"}
    assert not result.expectations[0].undecided


def undecided(clause, method="rkn4"):
    """Return what is said of an expectation, and whether it holds."""
    (found,) = ran(scene(further=f"expect {clause}\n"), method).expectations
    return found.undecided, found.state


def test_expectations_that_hold_or_fail_by_less_than_the_error_are_told():
    result = ran(scene(), "rkn4")
    log = result.logs["force of low"]
    force = np.linalg.norm(log.value, axis=1)
    highest, error = 1e3 * force.max(), 1e3 * result.promise.logs["force of low"].apart
    for part, is_open in ((1e-4, True), (10.0, False)):
        for sign, state in ((1.0, "holds"), (-1.0, "fails")):
            limit = float(highest + sign * part * error)
            said, found = undecided(f"force(low) < {limit!r} mN over run")
            assert (found, bool(said)) == (state, is_open), (part, state)
            if is_open:
                assert re.fullmatch(rf"{state} by \S+ \S+, but the error is \S+ \S+", said)


@every(
    ("clause", "is_open"),
    [
        ("count(pieces of block) == 2 at 10 ms", False),
        ("count(pieces of block) == 2 and force(low) > 0 N at 10 ms", False),
        ("force(low) > 1 kN or count(pieces of block) == 2 at 10 ms", False),
        ("not (force(low) > 1 kN) at 10 ms", False),
        ("force(low, 6 ms) > force(low, 1 ms) ", False),
        ("force(low) >= force(low, 6 ms) at 6 ms", False),  # equal in every run
    ],
)
def test_what_no_error_decides_otherwise_is_decided(clause, is_open):
    assert bool(undecided(clause)[0]) is is_open


def test_with_strict_an_undecided_expectation_is_an_error():
    def whole(text):  # no force on an edge, of which there would be a warning
        return text.replace("z > 9.9 mm and x < 0.1 mm", "z > 9.9 mm")

    log = ran(whole(scene()), "rkn4").logs["force of low"].value
    highest = np.linalg.norm(log, axis=1).max()
    limit = f"expect force(low) < {1000.0001 * float(highest)!r} mN over run\n"
    text = whole(scene(further=limit)).replace(
        "set high = nodes of block where z > 9.9 mm\n", ""
    )
    with pytest.warns(tissuec.TissueWarning, match="but the error is"):
        tissuec.run(text.replace("dop853", "rkn4"), companion="inline")
    with pytest.raises(SimulationError):
        ran(text, "rkn4", strict=True)


def observed(text):
    """Return observations that no run has filled yet."""
    compiled, _ = compile_request(Request(Source("scene.tis", text)))
    return Observations(Courses(compiled.network, compiled.plan), compiled.network)


def test_a_jump_that_comes_a_moment_earlier_is_no_error():
    def filled(jump):
        found, times = observed(scene()), np.linspace(0.0, 16e-3, 17)
        still = np.zeros((1, found.position.shape[1], 3))
        for place, time in enumerate(found.courses.times):
            if place == jump:
                found.happened(LoggedEvent("rupture", (1,), "", None))
            found.take(Samples(np.array([time]), still, still, *4 * [np.zeros(1)]))
            value = np.full((1, 3), 1.0 if place < jump else 2.0)
            found.log("force of low", np.array([time]), value)
        assert np.allclose(found.courses.times, times)
        return found

    one, other, later = (filled(jump) for jump in (8, 9, 12))
    assert one.log_errors(other.table)["force of low"].error == 0.0
    assert one.log_errors(later.table)["force of low"].error > 0.5


def test_rows_of_every_rate_are_compared():
    text = scene(rate="0.01 ms").replace("energy(block) every 1 ms", "energy(block) every 7 ms")
    found = observed(text)
    counts = [int(course.due.sum()) for course in found.courses.logs.values()]
    assert counts == [courses.COURSE_ROWS, 3]  # some of 1601, and all


def test_large_logs_are_not_compared(monkeypatch):
    text = scene().replace("kinetic energy(block)", "tension(block)")
    text = text.replace("made of elements", "made of springs")
    text = re.sub(
        r"Young's modulus = .*?; Poisson's ratio = [\d.]+;", "spring constant = 40 N/m;", text
    )
    text = text.replace(
        "mesh is lattice {",
        "mesh is lattice { kind is sodium chloride; reach is second neighbours;",
    )
    assert len(observed(text).courses.logs) == 2
    monkeypatch.setattr(courses, "MOST_COLUMNS", 20)
    assert observed(text).courses.logs.keys() == {0}
