"""Learning where there is little to learn from, or where it cannot go on."""

import io
import warnings

import numpy as np
import pytest

from tests.learn.test_learning import FIT, START, fit_problem
from tissuec.core.errors import CompileError
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.learning import Unlearnable, learn
from tissuec.learn.fit.search import KeptSearch
from tissuec.learn.fit.session import prepare

HEAD = "t_s,node,x_mm,y_mm,z_mm\n"
MOVED = "".join(f"{t},3,{20 + 30 * t},{20 * t},0\n" for t in (0.01, 0.02, 0.03, 0.04, 0.05))
ADJUST = "adjust spring constant of line\n"
WARNED = (RuntimeWarning, UserWarning)


def begin(folder, rows, entries, **start):
    arguments = fit_problem(folder, FIT + entries, START | start)
    (folder / "measured.csv").write_text(HEAD + rows)
    return arguments


def test_a_single_row_is_not_held_out(tmp_path):
    session = prepare(*begin(tmp_path, "0.02,2,10.1,0.1,0\n", ADJUST + "hold out = 20 %\n"))
    assert len(session.learning) == 1
    assert session.held_out == ()


def test_what_is_measured_at_the_beginning_only_tells_the_beginning(tmp_path):
    rows = "".join(f"0,{node},{10 * node - 8},0,0\n" for node in (2, 3, 4))
    learnt = learn(*begin(tmp_path, rows, "adjust start position of inner along (1, 0, 0)\n"))
    assert learnt.estimates[0].value - learnt.estimates[0].start == pytest.approx(2e-3)


def test_a_row_where_nothing_has_moved_tells_nothing(tmp_path):
    learnt = learn(*begin(tmp_path, "0,2,10,0,0\n", ADJUST))
    assert learnt.blind[0].sentence == (
        "1 parameter has no influence on the measurements: spring constant of line"
    )
    assert learnt.passes <= 2  # no further start can help


def test_fewer_numbers_than_parameters_are_refused_at_once(tmp_path):
    entries = "adjust spring constant of chain per spring\n"
    with pytest.raises(CompileError) as refused:
        prepare(*begin(tmp_path, "0.1,2,10,0,0\n", entries))
    (found,) = refused.value.diagnostics
    assert found.message == "measured.csv: 3 numbers, fewer than the 4 parameters of the fit"


def test_nodes_that_were_never_measured_are_left_aside_in_silence(tmp_path):
    with warnings.catch_warnings():
        for kind in WARNED:
            warnings.simplefilter("error", kind)
        arguments = begin(tmp_path, MOVED + "0.05,2,,,\n", ADJUST)
        problem = prepare(*arguments).problem
    assert int(problem.counted.sum()) == 15
    assert np.isfinite(problem.spread).all()


def test_nothing_held_out_has_no_error(tmp_path):
    session = prepare(*begin(tmp_path, MOVED, ADJUST))
    judged = session.judged((), session.problem)
    assert judged.relative(np.zeros(judged.size)) == 0.0


def test_a_number_at_its_limit_is_told(tmp_path):
    entries = "adjust spring constant of line from 9.9 N/m to 10.1 N/m\n"
    notes = learn(*begin(tmp_path, MOVED, entries)).notes
    assert "at a limit, which the interval ignores: spring constant of line" in notes


def test_a_number_that_begins_outside_its_limits_is_told(tmp_path):
    entries = "adjust spring constant of line from 11 N/m to 1 kN/m\n"
    notes = learn(*begin(tmp_path, MOVED, entries)).notes
    expected = "outside its limits, so the fit starts at the nearer limit: "
    assert f"{expected}spring constant of line" in notes


def test_a_first_motion_without_numbers_is_told_in_a_sentence(tmp_path):
    entries = ADJUST + "integrator is velocity verlet; step = 100 ms\n"
    with pytest.raises(Unlearnable, match="the motion is not finite after"):
        learn(*begin(tmp_path, MOVED.replace("0.05,", "0.5,"), entries, c="1e80"))


def test_a_first_error_beyond_all_measure_is_told_in_a_sentence(tmp_path):
    far = MOVED + "0.05,2,1e200,0,0\n"
    with pytest.raises(Unlearnable, match="too far from the data"):
        learn(*begin(tmp_path, far, ADJUST + "error is absolute\n"))


def test_a_step_without_a_solution_is_a_motion_without_numbers(tmp_path, monkeypatch):
    compiled, own, request = begin(tmp_path, MOVED, ADJUST + "integrator is esdirk43\n")
    model = prepare(compiled, own, request).learning[0].model

    def singular(*_):
        raise RuntimeError("the matrix is singular")

    monkeypatch.setattr("tissuec.learn.derivatives.methods.stage_matrix", singular)
    model.choose = None  # the method stays
    model.freeze(np.zeros(1))
    with pytest.raises(Diverged, match="no solution was found for the step"):
        model.predict(np.zeros(1))


def test_a_broken_file_of_a_search_is_none(tmp_path):
    (tmp_path / "state").write_bytes(b"PK\x03\x04 and nothing else")
    with KeptSearch(tmp_path / "state", "key") as kept:
        assert kept.before is None and "damaged" in kept.note


def test_data_without_any_change_have_an_error_of_their_own_size(tmp_path):
    """Numbers that differ by rounding, as their mean does, have no deviation."""
    rows = "".join(f"{t},3,20.1,0.3,0.7\n" for t in (0.01, 0.02, 0.03, 0.04, 0.05, 0.06))
    rows += "0.07,3,20.10000000001,0.3,0.7\n"
    problem = prepare(*begin(tmp_path, rows, ADJUST)).problem
    theta = np.zeros(problem.size)
    problem.freeze(theta)
    assert problem.relative(theta) < 1.0
    assert problem.spread[0] > 1e-5


@pytest.mark.parametrize(
    ("place", "byte"),
    [(8, 1), (10, 99), (16, 77), (42, 200)],
    ids=["encrypted", "unknown compression", "checksum", "offset"],
)
def test_a_state_with_one_wrong_byte_is_told_and_learning_begins_again(tmp_path, place, byte):
    content = io.BytesIO()
    np.savez(content, key="key")
    damaged = bytearray(content.getvalue())
    central = damaged.index(b"PK\x01\x02")  # the directory of the archive
    damaged[central + place] = byte
    damaged[6 if place == 8 else 8] = byte if place in (8, 10) else damaged[8]
    (tmp_path / "state").write_bytes(damaged)
    with KeptSearch(tmp_path / "state", "key") as kept:
        assert kept.before is None
        assert kept.note == f'"{tmp_path / "state"}" is damaged, so learning has begun again'
