"""The reference's own formulas against the engine's, force by force, and both against laws.

Both are written from docs/numerics.md; a mistake in either of them parts them.
"""

import numpy as np
import pytest

from tests.contact.scenes import by_loops, contact_of, contact_with, meeting
from tests.every import every
from tests.test_jets import SUBMERGED, ball, jet_in, net_of, plate
from tests.validate.scenes import compiled_scene
from tissuec.forces.enclosed.volume import Enclosure, open_edges
from tissuec.geometry.nearest import CAPSULE, TRIANGLE
from tissuec.laws import LINEAR, REST, SPRING_LAWS, VISCOSITY_LAWS, C, D, E, Law, W
from tissuec.laws.evaluation import Behaviour
from tissuec.laws.formula import apply, exp
from tissuec.validate.forces.contact import ContactForce, nearest
from tissuec.validate.forces.jets import JetForce, points_of
from tissuec.validate.forces.laws import ReferenceLaws
from tissuec.validate.forces.pressure import VolumeField

SPRINGS = {
    "tension only": {},
    "dead band": {"slack": 2e-3},
    "toe": {"strain": 0.1},
    "exponential": {"stiffening": 4.0},
    "polynomial": {"square": 30.0, "cube": 4e3},
    "curve": {"elongations": (-1e-2, 0.0, 1e-3, 2e-2), "forces": (-0.1, 0.0, 0.2, 0.3)},
}
FORMULAS = {
    "power": C * E + apply("max", (E, E * 0.0)) ** 1.5,
    "steps": apply("abs", (E,)) * C - exp(E * 30.0) / (C + E),
    "waves": apply("sin", (E * 200.0,)) * 0.1 - apply("sqrt", (E * E + 1e-6,)),
}


def both(law, rng, count=40):
    numbers = rng.uniform(5.0, 50.0, count), rng.uniform(0.1, 2.0, count)
    which, rest = np.ones(count, dtype=int), rng.uniform(0.01, 0.05, count)
    laws = (LINEAR, law)
    return ReferenceLaws(laws, which, *numbers, rest), Behaviour(laws, which, *numbers, rest)


@every("name", [*SPRINGS, *FORMULAS])
def test_springs_of_every_law_pull_store_and_stiffen_alike(name):
    rng = np.random.default_rng(3)
    if name in SPRINGS:
        member = SPRING_LAWS[name](**SPRINGS[name])
        law = Law(name, member.force(), LINEAR.viscous, member, VISCOSITY_LAWS["linear"]())
    else:
        law = Law(name, FORMULAS[name], LINEAR.viscous)
    own, engine = both(law, rng)
    e = rng.uniform(-0.02, 0.03, len(own.rest))
    assert own.pull(e) == pytest.approx(engine.pull(e), rel=1e-12, abs=1e-15)
    assert own.slope(e) == pytest.approx(engine.slope(e), rel=1e-10, abs=1e-12)
    assert own.energy(e) == pytest.approx(engine.energy(e), rel=1e-9, abs=1e-15)
    # The energy is the integral of the force: by differences, whose error is near 1e-8.
    step = 1e-6
    slope = (own.energy(e + step) - own.energy(e - step)) / (2.0 * step)
    assert slope == pytest.approx(own.pull(e), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(
    "dashpot",
    [0.4, 1.0, 2.5, D * W * apply("abs", (W,)), D * W * exp(30.0 * E) + E * E * W * W / REST],
    ids=["0.4", "1", "2.5", "of speed", "of elongation and speed"],
)
def test_dashpots_of_every_law_brake_alike(dashpot):
    rng, linear = np.random.default_rng(4), SPRING_LAWS["linear"]()
    if isinstance(dashpot, float):
        member = VISCOSITY_LAWS["power"](exponent=dashpot, speed=0.3)
        law = Law("power", LINEAR.elastic, member.force(), linear, member)
    else:
        law = Law("free", LINEAR.elastic, dashpot, linear)
    own, engine = both(law, rng)
    e = rng.uniform(-0.02, 0.03, len(own.rest))
    w = np.append(rng.uniform(-1.0, 1.0, len(own.rest) - 1), 0.0)
    assert own.brake(e, w) == pytest.approx(engine.brake(e, w), rel=1e-12)
    assert own.brake_slope(e, w) == pytest.approx(engine.sluggishness(e, w), rel=1e-10)
    assert own.brake_by_stretch(e, w) == pytest.approx(engine.brake_by_e(e, w), rel=1e-10)
    # By differences, whose error is near 1e-8.
    difference = (own.brake(e + 1e-7, w) - own.brake(e - 1e-7, w)) / 2e-7
    assert own.brake_by_stretch(e, w) == pytest.approx(difference, rel=1e-6, abs=1e-6)


def enclosure(position, triangles):
    corners = triangles[:, [0, 1, 2, 2]]
    first, none = np.array([0, len(corners)]), np.zeros(0, dtype=np.int64)
    assert not len(open_edges(triangles))
    empty = Enclosure(none, none, "b", np.ones(1), 2e3, (), None, corners, first)
    return Enclosure(none, none, "b", empty.volumes(position), 2e3, (), None, corners, first)


def test_volumes_press_and_resist_alike():
    rng = np.random.default_rng(5)
    position, triangles = ball(1, 0.02)
    engine = enclosure(position, triangles.astype(np.int64))
    own = VolumeField(engine)
    moved = position + 0.002 * rng.normal(size=position.shape) + 5.0
    assert own.volumes(moved) == pytest.approx(engine.volumes(moved), rel=1e-12)
    forces, others = np.zeros_like(moved), np.zeros_like(moved)
    own.add_forces(0.0, moved, 0.0 * moved, forces)
    engine.add_forces(0.0, moved, 0.0 * moved, others)
    assert np.abs(forces - others).max() < 1e-11 * np.abs(others).max()
    number = np.arange(len(moved))
    one, other = (f.matrix(0.0, moved, number, len(moved)).toarray() for f in (own, engine))
    assert np.abs(one - other).max() < 1e-11 * np.abs(other).max()


@pytest.mark.parametrize("growth", [0.0, SUBMERGED])
@pytest.mark.parametrize("seed", [0, 1])
def test_jets_push_alike_also_where_things_stand_before_one_another(growth, seed):
    rng = np.random.default_rng(seed)
    far = plate(5, 2e-3, centre=(0.0, 0.0, -0.004), tilt=0.3, jitter=0.2)
    near = plate(2, 1.5e-3, centre=(0.5e-3, 0.0, 0.004), tilt=-0.4, jitter=0.2)
    net = net_of(far, near, ball(1, 2e-3, centre=(-1e-3, 1e-3, 0.008)))
    engine = jet_in(net, growth=growth)
    own = JetForce(engine)
    position = net.position + 1e-4 * rng.normal(size=net.position.shape)
    velocity = 0.5 * rng.normal(size=net.position.shape)
    forces, others = np.zeros_like(position), np.zeros_like(position)
    own.add_forces(0.0, position, velocity, forces)
    engine.add_forces(0.0, position, velocity, others)
    # The engine leaves out what is more than 4.5 widths beside the axis: exp(-20) = 2e-9.
    assert np.abs(forces - others).max() < 1e-8 * np.abs(others).max()
    number = np.arange(len(position))
    one, other = (
        f.matrix(0.0, position, number, len(position)).toarray() for f in (own, engine)
    )
    assert np.abs(one - other).max() < 1e-6 * np.abs(other).max()


@pytest.mark.parametrize("parts", [1, 2, 5])
def test_points_of_a_triangle_integrate_second_degrees_exactly(parts):
    share = points_of(parts)
    assert len(share) == 3 * parts**2
    assert share.mean(axis=0) == pytest.approx(np.full(3, 1 / 3))
    assert (share[:, 0] * share[:, 1]).mean() == pytest.approx(1 / 12)
    assert (share[:, 0] ** 2).mean() == pytest.approx(1 / 6)


def compared(contact, position, velocity):
    """Return forces, power lost, bristles' rates and energy of both, as pairs."""
    own, pairs = ContactForce(contact), contact.near(position, 0.01)
    found, forces = own.at(position, velocity, pairs), np.zeros_like(position)
    contact.add_forces(0.0, position, velocity, forces)
    lost = contact.powers(0.0, position, velocity)[1]
    energies = own.energy(position, pairs), float(contact.energy(0.0, position))
    rates = found.bristle_rates, by_loops(contact, position, velocity)[2].bent
    return (found.force, forces), (found.lost, lost), energies, rates


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("friction", ["0", "0.4"])
def test_tools_press_and_rub_alike(friction, seed):
    compiled = compiled_scene(meeting(40, friction=friction, damping="3 s/m"))
    network, rng = compiled.network, np.random.default_rng(seed)
    position = network.position + 1e-3 * rng.normal(size=network.position.shape)
    velocity = 0.2 * rng.normal(size=(network.row_count, 3))
    for one, other in compared(contact_of(compiled), position, velocity):
        assert np.abs(other).max(initial=0.0) > 0.0 or not np.size(one)
        assert np.abs(one - other).max(initial=0.0) < 1e-11 * np.abs(other).max(initial=1e-300)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("tissues", [1, 2])
@pytest.mark.parametrize("shape", ["ball", "plate", "ring"])
def test_surfaces_and_threads_press_and_rub_alike(shape, tissues, seed):
    rng = np.random.default_rng(seed)
    if shape == "ring":
        kind, turn = CAPSULE, np.arange(6) * np.pi / 3.0
        corners = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
        faces = np.stack([np.arange(6), (np.arange(6) + 1) % 6, np.arange(6)], axis=1)
    else:
        kind, (corners, faces) = TRIANGLE, ball(1, 1.0) if shape == "ball" else plate(3, 1.0)
    nodes, faces = 12, faces.astype(np.int64)
    stiffness = rng.uniform(40.0, 60.0, nodes)
    own, rough = 0.3, None
    if tissues > 1:
        own, rough = rng.uniform(0.1, 0.5, nodes), rng.uniform(0.0, 0.4, nodes + len(corners))
    contact = contact_with(
        kind, faces + nodes, nodes, friction=own, radius=0.25, stiffness=stiffness, rough=rough
    )
    corners = corners + 0.02 * rng.normal(size=corners.shape)
    above = corners[faces].mean(axis=1)[rng.integers(len(faces), size=nodes)]
    around = above + 0.12 * rng.normal(size=above.shape)
    position = np.concatenate([around, corners, np.zeros((nodes, 3))])
    velocity = rng.normal(size=position.shape)
    for one, other in compared(contact, position, velocity):
        assert np.abs(one - other).max() < 1e-10 * np.abs(other).max()


def test_nearest_points_are_nearer_than_any_other():
    rng = np.random.default_rng(6)
    for count in (2, 3):
        x, corners = rng.normal(size=(200, 3)), rng.normal(size=(200, count, 3))
        weights = nearest(x, corners)[:, :count]
        assert (weights >= 0.0).all()
        assert weights.sum(axis=1) == pytest.approx(1.0)
        least = np.linalg.norm(x - np.einsum("na,nak->nk", weights, corners), axis=1)
        for other in rng.dirichlet(np.ones(count), 300):
            away = np.linalg.norm(x - np.einsum("a,nak->nk", other, corners), axis=1)
            assert (least <= away + 1e-12).all()
