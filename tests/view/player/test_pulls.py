"""Resultant forces are those of the logs, and their arrows stay in the picture."""

import numpy as np
import pytest

import tissuec
from tissuec.results.moments import Moments
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.holds import read_pulls
from tissuec.view.player.options import Options
from tissuec.view.player.reading import read_film

pytest.importorskip("matplotlib", reason="needs the extra plot")


@pytest.fixture(scope="module")
def lifted(sterilisation):
    with Trajectory.open(sterilisation) as trajectory:
        moments = Moments.of(trajectory, np.arange(len(trajectory.times)))
        yield trajectory, moments, read_pulls(moments)


def test_the_force_of_forceps_is_that_of_the_log(lifted):
    trajectory, moments, pulls = lifted
    (pull,) = [one for one in pulls if one.name == "forceps A"]
    log = trajectory.logs["force of forceps A"]
    inside = (moments.frames >= 0) & (moments.times > 0.1) & (moments.times < 1.4 - 1e-9)
    assert pull.life == pytest.approx((0.1, 1.4))
    # Both are of double precision, and sums of the same forces.
    rows = np.searchsorted(log.time, moments.times[inside] - 1e-9)
    shared = np.abs(log.time[rows] - moments.times[inside]) < 1e-9
    assert shared.sum() > 20
    np.testing.assert_allclose(
        pull.force[inside][shared], log.value[rows[shared]], rtol=0.0, atol=1e-12
    )


def test_both_ends_of_a_tube_are_fixed_by_themselves(lifted):
    _, moments, pulls = lifted
    ends = [one for one in pulls if one.name in ("uterine end", "fimbrial end")]
    assert sorted(round(one.place[0, 0] * 1e3) for one in ends) == [0, 64]
    # At rest before the grasp, both ends pull with the prestress, against each other.
    assert ends[0].force[0] == pytest.approx(-ends[1].force[0], rel=1e-6, abs=1e-9)
    assert len(moments.times) == len(ends[0].force)


def test_a_probe_has_the_force_of_its_log():
    scene = """language 1
tissue rubber { spring constant = 100 N/m; viscosity = 0.1 N*s/m; mass = 1 g }
body plate {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 5; rows = 5; diagonals is both
  }
  tissue is rubber
}
set rim = nodes of plate where x < 1 mm or x > 19 mm
tool finger { kind is probe; radius = 6 mm; centre = (10, 10, 6.5) mm }
environment {
  gravity = (0, 0, 0) m/s^2; damping = 10 mN*s/m
  contact is tools only; contact stiffness = 200 N/m
}
script {
  at 0 s: fix rim
  from 0 s to 0.1 s: move finger by (0, 0, -3) mm using smooth profile
}
simulate { duration = 0.1 s; tolerance = 1e-3 }
output { trajectory every 10 ms; force of finger every 10 ms }
"""
    result = tissuec.run(scene, companion="off")
    film = read_film(result, Options())
    (one,) = [each for each in film.resultants if each.name == "finger"]
    log = result.logs["force of finger"]
    frames = ~film.is_side
    np.testing.assert_allclose(one.force[frames], log.value, rtol=1e-12)
    assert one.force[-1, 2] < 0.0  # on the tissue: the finger presses downwards


def test_what_is_not_wholly_recorded_has_no_arrow():
    scene = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 11; 3 20 }
table springs of pair with columns "a b" { 1 2; 2 3 }
set first = nodes of pair where id == 1
environment { gravity = (0, 0, -9.81) m/s^2 }
script { at 0 s: fix pair }
simulate { duration = 10 ms }
output { trajectory of [first] every 5 ms }
"""
    assert read_film(tissuec.run(scene, companion="off"), Options()).resultants == ()


def test_a_support_that_is_cut_is_one_support():
    scene = """language 1
tissue gel {
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms
}
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }
  made of elements; tissue is gel
}
set base = nodes of block where z == 0 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: fix base
  at 2 ms: cut block along plane through (11, 5, 5) mm facing (1, 0, 0.2)
}
simulate { duration = 4 ms; tolerance = 1e-4 }
output { trajectory every 1 ms; force of base every 1 ms }
"""
    result = tissuec.run(scene, companion="off")
    film = read_film(result, Options())
    assert {each.name for each in film.resultants} == {"base"}
    first, last = sorted(film.resultants, key=lambda one: one.life)
    assert first.life[1] == last.life[0]
    expected = result.logs["force of base"].value[-1]
    np.testing.assert_allclose(last.force[~film.is_side][-1], expected, rtol=1e-9, atol=1e-15)
