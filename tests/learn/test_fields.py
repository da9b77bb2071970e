"""Volumes, bending walls, foundations and ambient damping have exact derivatives."""

from typing import NamedTuple

import numpy as np
import pytest
from msgspec.structs import astuple
from scipy import sparse

from tests.learn.test_motion import motion_of
from tests.learn.trials import difference
from tests.validate.scenes import compiled_scene
from tissuec.compiled.calls import kernel_on
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.structs import replace
from tissuec.forces.acting.foundation import Bed
from tissuec.forces.fields import acts_of
from tissuec.forces.matrices import ForceDerivatives, numbers_of
from tissuec.kernels.records import IntegerRows, Rows
from tissuec.learn.parameters.numbers import derivatives_of

#: A bag of 42 nodes: a wall that encloses a volume and lies on a foundation.
BAG = """language 1
tissue wall { spring constant = 28 N/m; density = 1000 kg/m^3; retardation time = 0.3 ms }
body bag {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  tissue is wall; thickness = 1 mm }
force bed { kind is foundation; acts on bottom; stiffness = 200 kPa/m; damping = 30 Pa*s/m }
set bottom = nodes of bag where z < -5 mm
set top = nodes of bag where z > 9 mm
set side = nodes of bag where x > 6 mm
environment { gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m; mass damping = 3 Hz
  surface damping = 20 Pa*s/m }
script { at 0 s: preserve volume of bag with 8 kPa
  from 0 s to 20 ms: inflate bag to 5 ml using smooth profile
  from 5 ms to 25 ms: move top by (2, 0, 3) mm using smooth profile
  at 15 ms: cut bag along plane through (0, 0, 2) mm facing (0, 0, 1) }
simulate { duration = 30 ms; tolerance = 1e-8 }
"""
TIMES = np.array([3.3e-3, 17e-3, 30e-3])
STEPS = {"velocity verlet": 5e-5, "dop853": 5e-4, "esdirk43": 3e-3}
RELATIVE = {"rest": 0.01, "position": 0.002, "velocity": 0.05}  # changes that are small enough


@pytest.fixture(scope="module")
def bag():
    return compiled_scene(BAG)


def derived(scene, name, step, times):
    """Return a motion, its numbers, and the derivatives of a sum with weights by these."""
    motion, vector = motion_of(scene, name, step, times, times[-1])
    weights = np.random.default_rng(3).standard_normal(motion.forward(vector).x.shape)
    return motion, vector, weights, motion.backward(weights, np.zeros_like(weights))


def check_both_directions(scene, name, step, times, size=1e-3):
    """Compare derivatives backwards with those forwards and with differences."""
    motion, vector, weights, gradient = derived(scene, name, step, times)
    some = np.random.default_rng(2).standard_normal((len(vector), 2)) * np.abs(vector)[:, None]
    total = np.zeros(2)

    def visit(sample, tx, tv):
        total[:] += weights[sample] @ tx

    motion.forward_with(vector, sparse.csr_matrix(some), visit)
    # Both are exact up to rounding.
    scale = (np.abs(gradient) @ np.abs(some)).max()
    assert np.abs(total - gradient @ some).max() < 1e-12 * scale
    way = size * some[:, 0]
    found = difference(motion, vector, way, weights)
    assert gradient @ way == pytest.approx(found, rel=1e-7)


@pytest.mark.parametrize("name", STEPS)
def test_derivatives_of_both_directions_are_those_of_the_steps(bag, name):
    check_both_directions(bag, name, STEPS[name], TIMES)


def test_all_numbers_have_their_derivatives(bag):
    motion, vector, weights, gradient = derived(
        bag, "velocity verlet", STEPS["velocity verlet"], TIMES
    )
    order = motion.order
    parts = {name: order.places[name] for name in (*RELATIVE, "mass", "damping", "drag")}
    first = order.places["fields"].start
    for name, field in order.fields.items():
        for column in derivatives_of(field).columns:
            size = np.size(getattr(field, column))
            parts[f"{column} of {name}"] = slice(first, first + size)
            first += size
    assert first == order.places["fields"].stop
    random = np.random.default_rng(4)
    for name, part in parts.items():
        way = np.zeros_like(vector)
        size = RELATIVE.get(name, 0.02) * np.abs(vector[part]).max()
        way[part] = (size or 0.01) * random.standard_normal(way[part].size)
        found = difference(motion, vector, way, weights)
        assert gradient @ way == pytest.approx(found, rel=1e-7, abs=1e-14), name


class Held(NamedTuple):
    """A foundation as loops in Python read it."""

    at: IntegerRows  # places of its components, shape (node, 3)
    home: Rows
    stiffness: Rows  # shape (node, 1)
    damping: Rows


def hold(time, x, v, f, power, bed):
    f[bed.at] -= bed.stiffness * (x[bed.at] - bed.home) + bed.damping * v[bed.at]
    power[1] += (bed.damping * v[bed.at] ** 2).sum()


def pull(time, x, v, weight, by_x, by_v, by, bed):
    w = weight[bed.at]
    by_x[bed.at] -= bed.stiffness * w
    by_v[bed.at] -= bed.damping * w
    own = -w * (x[bed.at] - bed.home), -w * v[bed.at]
    by += np.concatenate([*(each.sum(axis=1) for each in own), (bed.stiffness * w).ravel()])


def push(time, x, v, dx, dv, dn, df, room, bed):
    dx, dv, df = (each.reshape(len(x), -1) for each in (dx, dv, df))
    stiffer, thicker, home = np.split(dn.reshape(-1, room.size), [len(bed.at), 2 * len(bed.at)])
    away, moves = (x[bed.at] - bed.home)[..., None], v[bed.at][..., None]
    gone = dx[bed.at] - home.reshape(*bed.at.shape, -1)
    df[bed.at] -= bed.stiffness[..., None] * gone + bed.damping[..., None] * dv[bed.at]
    df[bed.at] -= stiffer[:, None] * away + thicker[:, None] * moves


class OwnBed(Bed, frozen=True):
    """A foundation as a plug-in may have it: its loops run as Python."""

    @property
    def kernel(self):
        return hold

    def table(self, place, acts, position):
        at = 3 * place[self.nodes] + np.arange(3)
        return Held(at, self.home, self.stiffness[:, None], self.damping[:, None])

    @property
    def derivatives(self):
        return ForceDerivatives(self.learnt, pull, push)


def test_a_force_of_ones_own_gives_its_derivatives(bag):
    bed = next(block for block in bag.network.blocks if block.kind == "foundation")
    own = replace(bed, field=OwnBed(*astuple(bed.field)))
    scene = replace(bag, network=bag.network.with_blocks(own))
    found, expected = (derived(one, "dop853", 5e-4, TIMES)[-1] for one in (scene, bag))
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())


def test_matrices_are_those_of_changes(bag):
    state = state_at_start(bag)
    random = np.random.default_rng(5)
    place = np.arange(len(state.position))
    position = state.position + 1e-3 * random.standard_normal(state.position.shape)
    velocity = 0.1 * random.standard_normal(position.shape)
    one, none = np.eye(position.size).ravel(), np.zeros(position.size**2)
    for name, field in state.named_fields.items():
        table = field.table(place, acts_of(field.changes, 0.0, 0.0), position)
        columns, _, forward = derivatives_of(field)
        still = np.zeros(len(numbers_of(field, columns)) * position.size)
        by_x, by_v = np.zeros((2, position.size, position.size))
        for dx, dv, df in ((one, none, by_x), (none, one, by_v)):
            x, v, room = position.ravel(), velocity.ravel(), np.zeros(position.size)
            call = kernel_on(forward, table, 7)
            call(0.0, x, v, dx, dv, still, df.reshape(-1), room)
        sparse_part, wide = field.split(0.0, position, place, len(place))
        stiff, slow = sparse_part.toarray() + wide @ wide.T, 0.0
        if (
            damping := field.damping_matrices(position, velocity, place, len(place))
        ) is not None:
            stiff, slow = stiff + damping[0].toarray(), damping[1].toarray()
        assert np.abs(by_x + stiff).max() < 1e-12 * np.abs(stiff).max(), name
        assert np.abs(by_v + slow).max() <= 1e-12 * np.abs(slow).max(), name


BESIDE_A_PLANE = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 20 mN*s/m; mass = 5 g }
body net { mesh is explicit; tissue is gum }
table nodes of net in mm with columns "id x y" { 1 0 10; 2 100 0; 3 200 12 }
table springs of net with columns "a b" { 1 2; 2 3 }
set end = nodes of net in [1]
set far = nodes of net in [3]
environment { gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0) }
script { at 0 s: fix far
  from 0 s to 0.1 s: move end by (4, 1, 0) mm using smooth profile }
simulate { duration = 0.1 s; tolerance = 1e-9 }
"""


def test_springs_beside_a_plane_of_symmetry():
    times = np.array([0.033, 0.1])
    check_both_directions(compiled_scene(BESIDE_A_PLANE), "dop853", 1e-3, times)


def test_springs_of_nodes_that_slide():
    """Weight and a force act across what holds the middle node, which bears them."""
    text = BESIDE_A_PLANE.replace("(0, 0, 0) m/s^2", "(1, -2, 0) m/s^2").replace(
        "\n  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)", ""
    )
    text = text.replace("environment", "set middle = nodes of net in [2]\nenvironment")
    sliding = """at 0 s: fix middle along (0, 3, 4)
  at 0 s: push middle with (0.01, 0.02, 0) N using sine of 20 Hz
  """
    text = text.replace("from 0 s to 0.1 s", f"{sliding}from 0 s to 0.1 s")
    times = np.array([0.033, 0.1])
    check_both_directions(compiled_scene(text), "dop853", 1e-3, times)
