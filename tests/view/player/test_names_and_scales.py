"""Arrows say whose forces they are, what is held is seen, and colours follow logarithms."""

import numpy as np
import pytest

import tissuec
from tissuec.core.errors import TissueError
from tissuec.view.player.fields import NodeField
from tissuec.view.player.node_values import FieldValues, field_colours
from tissuec.view.player.options import Options
from tissuec.view.player.reading import read_film

BLOCK = """language 1
tissue gel {
  Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms
  cutting resistance = 100 J/m^2
}
body block { mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }; tissue is gel }
set bed = nodes of block where z == 0 mm
tool shears { kind is scissors }
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: { fix bed; settle }
  from 1 ms to 5 ms: cut block along stroke from (8, -2, 11) mm to (8, 12, 11) mm by (0, 0, -4) mm with shears
}
simulate { duration = 6 ms; tolerance = 1e-3 }
output { trajectory every 1 ms; force(shears) every 0.5 ms; force(bed) every 0.5 ms }
"""  # noqa: E501


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cut")
    return tissuec.run(BLOCK, out=folder / "cut.vtkhdf", companion="off")


def test_arrows_have_the_names_of_sets_and_of_scissors(cut):
    film = read_film(cut, Options())
    named = {one.name: one for one in film.resultants}
    assert set(named) == {"bed", "shears"}
    log = cut.logs["force of shears"]
    at = int(np.argmin(np.abs(film.times - 3e-3)))
    logged = log.value[int(np.argmin(np.abs(log.time - film.times[at])))]
    assert named["shears"].force[at] == pytest.approx(logged, abs=1e-9)
    # 100 J/m^2 times a depth of 3 mm, of which the block sags by 0.04 mm under its weight.
    assert np.linalg.norm(logged) == pytest.approx(0.3, rel=0.02)
    begin, end = named["shears"].life
    assert begin < at < end


def test_a_body_that_is_held_is_not_in_the_jaws_of_forceps(tmp_path):
    text = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body punch { mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 5) mm }; tissue is gel }
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: hold punch; from 0 s to 4 ms: move punch by (0, 0, -1) mm using constant speed }
simulate { duration = 4 ms; tolerance = 1e-3 }
output { trajectory every 2 ms }
"""  # noqa: E501
    film = read_film(
        tissuec.run(text, out=tmp_path / "punch.vtkhdf", companion="off"), Options()
    )
    assert film.instruments == ()
    assert (film.held.patches[:, 1] > 0.0).all()
    assert len(film.held.rims) == 0  # a closed patch has no rim


def test_held_patches_have_a_rim(cut):
    held = read_film(cut, Options()).held
    # Around the bed of 4 by 2 cells.
    assert len(held.rims) == 2 * (4 + 2)
    ends = cut.network.position[cut.nodes[held.rims]]
    assert (ends[..., 2] == 0.0).all()


def values(numbers, **looks):
    field = NodeField("stress", "Pa", "", lambda nodes: None, **looks)
    return FieldValues.of(field, np.array(numbers, dtype=float))


def test_colours_of_logarithms_distinguish_decades():
    found = values([[1e3, 1e4, 1e5] * 40]).on_logarithms()
    assert (found.low, found.high) == (1e3, 1e5)
    assert found.middle == pytest.approx(1e4)
    assert found.part(np.array([1e3, 1e4, 1e5, 0.0, 1e9])) == pytest.approx([0, 0.5, 1, 0, 1])
    few = field_colours(found, np.array([1e3, 1e4]))
    assert np.abs(few[0] - few[1]).max() > 0.2  # linear colours differ by 0.03
    assert np.isfinite(field_colours(found, np.array([np.nan, -1.0]))).all()


def test_a_scale_has_four_decades_at_most():
    found = values([np.geomspace(1e-9, 1e3, 200)]).on_logarithms()
    assert found.high / found.low == pytest.approx(1e4, rel=0.05)


def test_a_field_with_numbers_below_0_has_no_logarithms():
    with pytest.raises(TissueError, match="numbers below 0"):
        values([[-1.0, 2.0, 3.0]], signed=True).on_logarithms()
