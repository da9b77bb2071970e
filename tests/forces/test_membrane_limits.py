"""What breaks triangles of walls, against closed forms and formulas of the reference."""

import numpy as np
import pytest

from tests.forces.test_element_limits import BULK, NONE, bar, energy
from tests.forces.test_membranes import LAWS, PLANE, THICK, deformed, fibres_of, mesh, wall
from tissuec.forces.solids.element_limits import ElementLimits
from tissuec.laws.solid.invariants import NeoHookean, SolidExponential
from tissuec.laws.solid.stretches import Ogden
from tissuec.validate.forces.membranes import MembraneWall

SHEAR = 2e3  # [Pa]
RATIO = (3.0 * BULK - 2.0 * SHEAR) / (6.0 * BULK + 2.0 * SHEAR)
EVERY_LAW = (*LAWS, Ogden(-3.0, second_exponent=7.0, second_share=0.4))


def breakable(law, *, strain=NONE, stress=NONE, toughness=NONE, cells=3, **more):
    """Return triangles with limits, and where their nodes are drawn."""
    count = len(mesh(cells)[1])
    given = [np.full(count, limit) for limit in (strain, stress, toughness)]
    limits = ElementLimits(*given, np.zeros_like(given[0]))
    return wall(law, limits=limits, cells=cells, **more)


@pytest.mark.parametrize("law", [NeoHookean(), SolidExponential(2.0)], ids=["line", "curve"])
@pytest.mark.parametrize("cells", [1, 10])
def test_every_triangle_of_a_drawn_strip_reaches_its_limits_together(cells, law):
    along = 1.35
    across, stress = bar(law, along)
    limits = {
        "strain": along - 1.0,
        "stress": stress,
        "toughness": energy(law, along, across),
    }
    way = np.array([[0.8, 0.6], [-0.6, 0.8]])
    strain = way.T @ np.diag([along, across]) @ way
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    for what, limit in limits.items():
        made, drawn = breakable(law, cells=cells, ratio=RATIO, parts=False, **{what: limit})
        loads = made.breakable.loads(drawn @ PLANE.T @ strain @ PLANE @ turn)
        # E > G t √A, and E is t A times the energy of the bar.
        sides = drawn[made.nodes][:, 1:] - drawn[made.nodes][:, :1]
        area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        due = np.sqrt(area) if what == "toughness" else np.ones(len(loads))
        np.testing.assert_allclose(loads, due, rtol=1e-9)
        assert made.crack_areas == pytest.approx(THICK * np.sqrt(area))


@pytest.mark.parametrize("law", EVERY_LAW, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("what", ["strain", "stress", "toughness"])
def test_the_reference_finds_the_same_loads(what, law):
    more = {"prestress": 0.05} if isinstance(law, Ogden) else {"fibres": fibres_of(18)}
    made, drawn = breakable(law, **{what: 2.0}, ratio=0.45, **more)
    position = deformed(drawn, 1.5e-3)
    loads = np.maximum(made.breakable.loads(position), 0.0)
    np.testing.assert_allclose(loads, MembraneWall(made).burdens(position), rtol=1e-9)
    assert len(set(loads.round(12))) > 10  # no two are strained alike


def test_strain_counts_from_the_shape_without_stress():
    made, drawn = breakable(NeoHookean(), strain=0.25, prestress=0.2)
    np.testing.assert_allclose(made.breakable.loads(drawn), 1.0, rtol=1e-12)


def test_pressure_in_the_plane_breaks_nothing():
    # Not even where the wall becomes thicker.
    made, drawn = breakable(NeoHookean(), strain=0.1, stress=1.0, ratio=0.49)
    assert (made.breakable.loads(0.7 * drawn) <= 0.0).all()


def test_what_has_no_limit_does_not_break():
    made, drawn = breakable(NeoHookean())
    assert made.breakable is None
    strain = np.where(np.arange(18) == 5, 0.2, np.inf)
    limits = ElementLimits(strain, *np.full((2, 18), np.inf), np.zeros(18))
    made, drawn = wall(NeoHookean(), limits=limits)
    assert made.breakable.broken(1.3 * drawn).tolist() == [5]
    assert made.breakable.broken(1.1 * drawn).tolist() == []
