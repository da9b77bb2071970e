"""change: what it replaces, and what it leaves alone."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, make_net, order, start
from tissuec.model.inelastic import NAMES
from tissuec.script.verbs.change import PARAMETERS

SETS = {"part": [1, 2]}


def change(state, sentence, **clauses):
    return order(sentence, SETS, **clauses).apply(state, Diary())


@pytest.mark.parametrize("name", [name for name in PARAMETERS if name not in NAMES])
def test_a_parameter_changes_for_the_part_and_not_in_the_network(name):
    network = chain(5, mass=3.0, stiffness=3.0, damping=3.0, rest=3.0, strength=3.0, crush=3.0)
    state = start(network)
    array = PARAMETERS[name].array

    def present():
        return getattr(state if array == "mass" else state.springs, array).tolist()[:4]

    change(state, f"change {name}", of="part", to=7.0)
    assert present() == [3, 7, 7, 3]
    change(state, f"change {name}", of="part", by=0.5)
    assert present() == [3, 3.5, 3.5, 3]
    assert (network.array(array) == 3.0).all()


def test_gravity_and_ambient_damping_change():
    state = start(chain(2))
    change(state, "change gravity", to=(0, 0, -1))
    change(state, "change damping", to=0.25)
    assert state.gravity.tolist() == [0, 0, -1]
    assert state.drag == 0.25


def test_a_velocity_is_given_to_free_nodes_only():
    state = start(chain(4))
    order("fix held", {"held": [2]}).apply(state, Diary())
    change(state, "change velocity", of="part", to=(1, 2, 3))
    assert state.velocity.tolist() == [[0, 0, 0], [1, 2, 3], [0, 0, 0], [0, 0, 0]]


def test_a_spin_keeps_momentum_and_turns_about_the_centre_of_mass():
    position = np.random.default_rng(3).normal(size=(6, 3))
    mass = np.array([1.0, 5.0, 2.0, 1.0, 3.0, 4.0])
    state = start(make_net(position, [], mass=mass, velocity=(1.0, 0.0, -2.0)))
    spin = np.array([0.3, -0.2, 0.9])
    order("change spin", {"all": np.arange(6)}, of="all", to=spin).apply(state, Diary())
    assert mass @ state.velocity == pytest.approx(mass.sum() * np.array([1.0, 0.0, -2.0]))
    apart = position[1] - position[0]
    relative = state.velocity[1] - state.velocity[0]
    assert relative == pytest.approx(np.cross(spin, apart))


@pytest.mark.parametrize(
    ("sentence", "clauses", "code"),
    [
        ("change colour", {"to": 1.0}, "TIS305"),
        ("change mass", {"of": "part"}, "TIS304"),
        ("change mass", {"of": "part", "to": 1.0, "by": 2.0}, "TIS306"),
        ("change mass", {"of": "part", "to": 0.0}, "TIS308"),
        ("change viscosity", {"of": "part", "to": -1.0}, "TIS308"),
        ("change damping", {"to": -1.0}, "TIS308"),
    ],
)
def test_a_change_must_be_complete_and_possible(sentence, clauses, code):
    with pytest.raises(Refused, match=code):
        order(sentence, SETS, **clauses)
