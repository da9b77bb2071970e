"""Active fibres against closed forms, differences and the reference."""

import numpy as np
import pytest
from scipy.optimize import fsolve

import tissuec
from tests.derivatives import forces, matrix_follows_from_forces, slopes
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import same_when_resumed
from tissuec.forces.solids.activation import UNLIMITED, Activation, activated
from tissuec.model.profiles import TimeProfile
from tissuec.validate.forces.activation import ActiveFibres

STEADY = TimeProfile("constant", 0.0, np.inf)
STRESS = 3e4  # [Pa]
BUMP = (0.6, 1.5)
TISSUE = (
    "Young's modulus = 15 kPa; fibre modulus = 15 kPa; Poisson's ratio = 0.3; "
    "density = 1060 kg/m^3; retardation time = 2 ms"
)
BODIES = {
    "block": "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }; "
    "fibres = (1, 0, 0)",
    "crossed": "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }; "
    "fibres = (1, 1, 0); second fibres = (1, -1, 0.5)",
    "rod": "mesh is cylinder { axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 5 mm; "
    "cell = 3 mm }; fibres = (1, 0, 0)",
    "stretched": "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }; "
    "fibres = (1, 0, 0); prestress along (1, 0, 0)",
    "wall": "mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = "
    "(0, 10, 0) mm; columns = 5; rows = 3 }; thickness = 2 mm; fibres = (1, 0.3, 0)",
}


def network_of(name, more=""):
    prestress = "; prestress = 10 %" if name == "stretched" else ""
    return compiled_scene(
        f"language 1\ntissue muscle {{ {TISSUE}{prestress} }}\n"
        f"body {name} {{ {BODIES[name]}; tissue is muscle }}\n{more}\n"
        "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
    ).network


def active(network, limits=UNLIMITED, nodes=None, profile=STEADY):
    nodes = np.arange(network.node_count) if nodes is None else nodes
    ((field, items),) = activated(network, nodes)
    span = network.bodies[0].span
    return Activation.of("key", "all", field, items, STRESS, limits, profile, span)


def shaken(network, size=4e-4, seed=3):
    moved = np.random.default_rng(seed).normal(size=network.position.shape)
    return network.position + size * moved


@pytest.mark.parametrize("limits", [UNLIMITED, BUMP])
@pytest.mark.parametrize("name", BODIES)
def test_forces_and_matrix_follow_from_the_potential(name, limits):
    network = network_of(name)
    field, position = active(network, limits), shaken(network)
    found, nodes = forces(field, position), range(0, len(position), 3)
    by_potential = slopes(lambda x: field.potential(0.0, x), position, nodes, 1e-7)
    np.testing.assert_allclose(found[nodes], by_potential, atol=1e-6 * np.abs(found).max())
    assert np.abs(found.sum(axis=0)).max() < 1e-12 * np.abs(found).sum()
    turning = np.cross(position, found).sum(axis=0)
    assert np.abs(turning).max() < 1e-12 * np.abs(position).max() * np.abs(found).sum()
    count = len(position)
    matrix = field.matrix(0.0, position, np.arange(count), count).toarray()
    matrix_follows_from_forces(field, position, matrix, every=17, step=1e-6, allowed=1e-6)
    positive = field.matrix(0.0, position, np.arange(count), count, exact=False).toarray()
    assert np.linalg.eigvalsh(positive).min() > -1e-10 * np.abs(matrix).max()


@pytest.mark.parametrize("limits", [UNLIMITED, BUMP])
@pytest.mark.parametrize("name", BODIES)
def test_the_reference_has_the_same_forces_powers_and_matrix(name, limits):
    network = network_of(name)
    ramp = TimeProfile("ramp", 0.0, 2.0)
    field, position = active(network, limits, profile=ramp), shaken(network)
    velocity = np.random.default_rng(5).normal(size=position.shape)
    other, count = ActiveFibres(field), len(position)
    theirs = np.zeros_like(position)
    other.add_forces(0.7, position, velocity, theirs)
    ours = np.zeros_like(position)
    field.add_forces(0.7, position, velocity, ours)
    assert np.abs(ours).max() > 0.0
    np.testing.assert_allclose(ours, theirs, atol=1e-13 * np.abs(theirs).max())
    supplied, lost = field.powers(0.7, position, velocity)
    assert supplied == pytest.approx(other.pumping(0.7, position, velocity), rel=1e-12)
    assert supplied == pytest.approx(float(np.vdot(theirs, velocity)), rel=1e-10)
    assert lost == 0.0
    numbers = np.arange(count)
    one = field.matrix(0.7, position, numbers, count).toarray()
    two = other.matrix(0.7, position, numbers, count).toarray()
    np.testing.assert_allclose(one, two, atol=1e-12 * np.abs(two).max())
    again = network.position
    step = field.potential(0.7, position) - field.potential(0.7, again)
    expected = other.potential(0.7, position) - other.potential(0.7, again)
    assert step == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "section"), [("block", 100e-6), ("rod", None), ("stretched", 100e-6)]
)
def test_the_isometric_force_is_the_stress_times_the_section(name, section):
    network = network_of(name)
    found = forces(active(network), network.position)
    left, right = (np.isclose(network.position[:, 0], x) for x in (0.0, 0.02))
    if section is None:  # of the faces of elements at the end
        (field,) = network.elements
        section = field.volume.sum() / 0.02
    if name == "stretched":  # without stress, it is wider
        section /= 0.9
    assert found[left, 0].sum() == pytest.approx(STRESS * section, rel=1e-9)
    assert found[right, 0].sum() == pytest.approx(-STRESS * section, rel=1e-9)
    assert np.abs(found[~(left | right)]).max() < 1e-9 * STRESS * section


def test_fibres_pull_less_and_less_towards_the_limits_of_their_stretch():
    network = network_of("block")
    field, left = active(network, BUMP), np.isclose(network.position[:, 0], 0.0)

    def pull(stretch):
        return forces(field, network.position * [stretch, 1.0, 1.0])[left, 0].sum()

    whole = STRESS * 100e-6
    assert pull(1.05) == pytest.approx(whole, rel=1e-12)
    q = (2 * 1.3 - 2.1) / 0.9
    assert pull(1.3) == pytest.approx(whole * (1 - q * q) ** 2, rel=1e-12)
    assert pull(0.59) == pull(1.51) == 0.0


def test_only_elements_within_a_set_are_active():
    network = network_of("block")
    x = network.position[:, 0]
    field = active(network, nodes=np.flatnonzero(x < 0.0101))
    assert field.item_count == 8
    found = forces(field, network.position)
    assert found[x > 0.0101].any() == False  # noqa: E712  # of NumPy
    assert found[np.isclose(x, 0.01), 0].sum() == pytest.approx(-STRESS * 100e-6, rel=1e-9)


def test_elements_that_are_cut_no_longer_pull():
    network = network_of("block")
    field, alive = active(network), np.ones(network.entity_count, dtype=bool)
    alive[field.walls[field.walled == 3][0]] = False
    assert 0 < field.intact(alive).item_count < field.item_count
    assert 3 in field.lost_items(alive)


COARSE = BODIES["block"].replace("cell = 5 mm", "cell = 10 mm")
SINGLE = COARSE.replace("(20, 10, 10)", "(10, 10, 10)")
SCENE = """language 1
tissue muscle {{ {tissue} }}
body block {{ {body}; tissue is muscle }}
set left = nodes of block where x < 0.1 mm
set right = nodes of block where x > 9.9 mm
{more}
"""
PLANES = """environment {
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
}"""


def free_stretch(stress, shear, bulk):
    """Return the stretch of a free neo-Hookean block that pulls along one axis."""

    def rest(stretches):
        along, across = stretches
        j, first = along * across**2, along**2 + 2 * across**2
        pressure = bulk * np.log(j)

        def cauchy(square):  # J times it
            return shear * j ** (-2 / 3) * (square - first / 3) + pressure

        return [cauchy(along**2) / along + stress, cauchy(across**2)]

    return fsolve(rest, [0.8, 1.1], xtol=1e-13)


def test_free_contraction_is_that_of_the_law(tmp_path):
    more = f"""{PLANES}
script {{
  at 0 s: {{ activate block with 8 kPa; settle }}
  at 1 ms: {{ stop activating block; settle }}
}}
simulate {{ duration = 2 ms }}
output {{ trajectory every 0.5 ms }}
"""
    path = tmp_path / "free.tis"
    path.write_text(SCENE.format(tissue=TISSUE, body=BODIES["block"], more=more))
    run = tissuec.run(path)
    shear, bulk = 15e3 / 2.6, 15e3 / (3 * 0.4)
    along, across = free_stretch(8e3, shear, bulk)
    assert along < 0.9
    middle = run.position[np.searchsorted(run.times, 0.5e-3)]
    drawn = run.position[-1]
    np.testing.assert_allclose(middle[:, 0], drawn[:, 0] * along, atol=1e-8)
    np.testing.assert_allclose(middle[:, 1:], drawn[:, 1:] * across, atol=1e-8)
    np.testing.assert_allclose(drawn[:, 0].max(), 0.02, rtol=1e-7)


MOVING = """environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix left
  from 0 s to 4 ms: activate block with 8 kPa {over} using smooth profile
  from 4 ms to 8 ms: activate block with 8 kPa {over}
}}
simulate {{ duration = 10 ms; tolerance = 1e-4; integrator is {method} }}
output {{ trajectory every 2 ms; force of left every 0.5 ms; energy every 1 ms }}
expect energy drift < 2e-4 over run
"""


@pytest.mark.parametrize("over", ["", "over 70 % to 140 %"])
def test_energy_is_balanced_whatever_the_method(tmp_path, over):
    found = []
    for method in ("dop853", "trbdf2", "esdirk43"):
        more = MOVING.format(over=over, method=method)
        path = tmp_path / f"{method}.tis"
        path.write_text(SCENE.format(tissue=TISSUE, body=COARSE, more=more))
        run = tissuec.run(path)
        assert all(one.state == "holds" for one in run.expectations)
        found.append(run.position)
    scale = np.abs(found[0] - found[0][0]).max()
    assert scale > 5e-4
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=5e-4 * scale)


def test_the_reference_agrees_with_a_run():
    more = MOVING.format(over="over 70 % to 140 %", method="automatic")
    found = validated(SCENE.format(tissue=TISSUE, body=COARSE, more=more))
    assert found.verdict == "kept", found.reasons


def test_a_run_that_is_resumed_gives_the_same_bytes():
    more = MOVING.format(over="over 70 % to 140 %", method="dop853")
    text = SCENE.format(tissue=TISSUE, body=COARSE, more=more)
    same_when_resumed(compiled_scene(text), "force of left", 2)


def test_slow_activation_is_quasistatic(tmp_path):
    more = f"""{PLANES}
script {{ from 0 s to 1 s: activate block with 3 kPa using ramp; from 0 s to 1 s: settle }}
simulate {{ duration = 1 s }}
output {{ trajectory every 0.5 s }}
"""
    path = tmp_path / "slow.tis"
    path.write_text(SCENE.format(tissue=TISSUE, body=SINGLE, more=more))
    run = tissuec.run(path)
    shear, bulk = 15e3 / 2.6, 15e3 / (3 * 0.4)
    for time, place in zip(run.times, run.position, strict=True):
        along, _ = free_stretch(3e3 * float(time), shear, bulk)
        assert place[:, 0].max() == pytest.approx(0.01 * along, rel=2e-4)
