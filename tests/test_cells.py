"""Lattices whose cells keep their volumes, each by its own pressure."""

from functools import partial
from itertools import product

import numpy as np
import pytest

from tests.derivatives import forces, slopes, stiffness
from tests.engine.running import Bench
from tests.hand_net import span
from tests.validate.scenes import compiled_scene, quantity, validated
from tissuec.core.structs import replace
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.stability import spectral_radius
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.mechanics import observables
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.model.profiles import TimeProfile

KINDS = ("sodium chloride", "caesium chloride", "diamond", "braced cubes")
CELL, MODULUS = 5e-3, 1e5
SCENE = """language 1
tissue gel {{ spring constant = {stiffness}; viscosity = {viscosity}; mass = 10 mg
             breaking force = 10 mN }}
body block {{
  mesh is lattice {{ kind is {kind}; cell = 5 mm; reach is {reach}
                    box from (0, 0, 0) mm to ({size}) mm }}
  tissue is gel
}}
set floor = nodes of block where z < 0.1 mm
set lid = nodes of block where z > {height} mm
environment {{ gravity = (0, 0, 0) m/s^2; damping = {drag} }}
script {{ {script} }}
simulate {{ duration = {duration}; tolerance = 1e-5 }}
output {{ trajectory every 2 ms; energy every 2 ms; volume of block every 2 ms }}
"""


def scene(kind="sodium chloride", script="", *, size="10, 15, 10", reach="second neighbours",
          stiffness="20 N/m", viscosity="10 mN*s/m", drag="0 N*s/m",
          duration="0.1 s"):  # fmt: skip
    height = float(size.split(",")[2]) - 0.1
    return SCENE.format(kind=kind, script=script, size=size, reach=reach, drag=drag,
                        stiffness=stiffness, viscosity=viscosity, height=height,
                        duration=duration)  # fmt: skip


def block(kind="sodium chloride", **more):
    net = compiled_scene(scene(kind, **more)).network
    return net, Enclosure.of(net, "block", MODULUS, span())


def shaken(net, size=0.1):
    noise = np.random.default_rng(7).normal(size=net.position.shape)
    return net.position + size * CELL * noise


# --- geometry -------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_cells_fill_the_block_and_go_on_doing_so_when_it_is_bent(kind):
    net, enclosure = block(kind)
    assert enclosure.item_count == 2 * 3 * 2
    assert enclosure.drawn == pytest.approx(CELL**3)
    linear = np.array([[1.2, 0.3, -0.1], [0.0, 0.9, 0.4], [0.2, 0.1, 1.1]])
    turned = net.position @ linear.T + [1.0, 2.0, 3.0]
    assert enclosure.volumes(turned) == pytest.approx(np.linalg.det(linear) * CELL**3)
    # Nodes inside take part in the surfaces of their cells only: none gains what none loses.
    bent, inner = net.position.copy(), np.all(
        (net.position > 0.1e-3) & (net.position < net.position.max(axis=0) - 0.1e-3), axis=1
    )  # fmt: skip
    assert inner.any()
    bent[inner] += shaken(net)[inner] - net.position[inner]
    assert enclosure.volumes(bent).sum() == pytest.approx(12 * CELL**3, rel=1e-12)
    assert np.ptp(enclosure.volumes(bent)) > 0.01 * CELL**3


def test_a_cell_with_warped_faces_has_the_volume_of_its_trilinear_map():
    net, enclosure = block(size="5, 5, 5", reach="third neighbours")
    position = shaken(net, 0.2)
    # Gauss's rule of three points is exact for the determinant, of second degree by axis.
    points, weights = np.polynomial.legendre.leggauss(3)
    total = 0.0
    sign = np.rint(2.0 * net.position / CELL - 1.0)
    for (u, a), (v, b), (w, c) in product(list(zip(points, weights, strict=True)), repeat=3):
        parts = 1.0 + sign * [u, v, w]
        slopes = np.stack(
            [sign[:, k] * np.delete(parts, k, axis=1).prod(axis=1) / 8.0 for k in range(3)]
        )
        total += a * b * c * np.linalg.det(slopes @ position)
    assert enclosure.volumes(position) == pytest.approx([total], rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_forces_are_minus_the_derivative_of_the_energy_and_push_nothing_as_a_whole(kind):
    net, enclosure = block(kind)
    position, h = shaken(net), 1e-8
    found = forces(enclosure, position)
    assert np.abs(found.sum(axis=0)).max() < 1e-13 * np.abs(found).sum()
    spin = np.cross(position, found).sum(axis=0)
    assert np.abs(spin).max() < 1e-13 * np.abs(found).sum() * np.ptp(position)
    nodes = [0, 7, net.node_count // 2]
    expected = slopes(partial(enclosure.energy, 0.0), position, nodes, h)
    # Differences of the energy are known to its rounding over the step.
    assert found[nodes] == pytest.approx(expected, abs=1e-5 * np.abs(found).max())


@pytest.mark.parametrize("kind", KINDS)
def test_stiffness_is_minus_the_derivative_of_the_forces(kind):
    net, enclosure = block(kind)
    position, h, count = shaken(net), 1e-7, net.node_count
    matrix = enclosure.matrix(0.0, position, np.arange(count), count).toarray()
    assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()
    for column in (0, 13, 40):
        slope = stiffness(enclosure, position, column, h)
        assert matrix[:, column] == pytest.approx(slope, abs=1e-7 * np.abs(matrix).max())


def test_a_mirror_image_is_pressed_as_the_mirror_image():
    net, enclosure = block()
    high = net.position.max(axis=0)
    position = shaken(net)
    for axis in range(3):
        flip = np.ones(3)
        flip[axis] = -1.0
        mirrored = net.position * flip + high * (flip < 0.0)
        apart = np.linalg.norm(mirrored[:, None] - net.position[None], axis=2)
        image = apart.argmin(axis=1)
        there = (position * flip + high * (flip < 0.0))[np.argsort(image)]
        found = forces(enclosure, there)[image] * flip
        expected = forces(enclosure, position)
        assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


# --- motion ---------------------------------------------------------------------------------


def test_kernels_and_energy_ledger_agree_on_a_block_that_is_shaken():
    net, enclosure = block(viscosity="0 N*s/m")
    bench = Bench(net, 0.02, tolerance=1e-8, ledger=True)
    bench.state.put(enclosure.swollen(0.2, TimeProfile("smooth", 0.0, 0.01)).block)
    bench.state.position[:] = shaken(net, 0.02)
    ran = bench.run(0.01)
    energies = [
        float(observables.energies(bench.state, t, x, v).total)
        for t, x, v in zip(ran.time, ran.position, ran.velocity, strict=True)
    ]
    gap = np.array(energies) - energies[0] - ran.work
    assert ran.work[-1] > 0.1 * np.max(energies)
    assert np.abs(gap).max() < 1e-7 * np.max(energies)


def test_fastest_motion_knows_the_pressure_of_cells():
    net, enclosure = block()
    state = State.start(net, gravity=np.zeros(3), drag=0.0)
    plain = spectral_radius(state)
    state.put(enclosure.block)
    count = net.node_count
    matrix = enclosure.matrix(0.0, net.position, np.arange(count), count, exact=False).toarray()
    for (a, b), c in zip(net.springs.ends, net.springs.stiffness, strict=True):
        n = net.position[b] - net.position[a]
        n /= np.linalg.norm(n)
        part = c * np.outer(n, n)
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            matrix[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] += sign * part
    fastest = np.sqrt(np.linalg.eigvalsh(matrix / 1e-5)[-1])
    assert plain < 0.9 * fastest < fastest < spectral_radius(state) < 1.1 * fastest


def test_a_block_settles_between_plates_at_half_its_height_and_keeps_its_volume():
    net, enclosure = block(size="10, 10, 20", stiffness="1 N/m")
    # Springs give the block a modulus near 1 N/m / 5 mm = 200 Pa.
    enclosure = replace(enclosure, modulus=2e6)
    volumes = []
    for blocks in ((), (enclosure.block,)):
        state = State.start(net, gravity=np.zeros(3), drag=0.0)
        state.put(*blocks)
        z = net.position[:, 2]
        state.holders["fix"] = np.flatnonzero((z < 1e-4) | (z > 20e-3 - 1e-4))
        for height in (15e-3, 10e-3):
            state.position[:, 2] *= height / np.ptp(state.position[:, 2])
            settle(state, np.ones(net.node_count, dtype=bool))
        volumes.append(enclosure.volumes(state.position).sum() / enclosure.drawn.sum())
    assert volumes[0] < 0.8  # springs alone do not keep it
    assert volumes[1] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_a_block_that_is_squeezed_by_half_its_height_keeps_its_volume(kind):
    script = """at 0 s: { fix floor; PRESERVE }
  from 0 s to 20 ms: move lid by (0, 0, -10) mm using smooth profile"""
    volumes = []
    # Springs give the block a modulus near 0.1 N/m / 5 mm = 20 Pa.
    for preserve in ("", "preserve volume of block with 200 kPa"):
        said = script.replace("PRESERVE", preserve).replace("; }", " }")
        more = {"size": "10, 10, 20", "stiffness": "0.1 N/m", "drag": "1 mN*s/m"}
        more["duration"] = "30 ms"
        compiled = compiled_scene(scene(kind, said, viscosity="0 N*s/m", **more))
        recorder = Recorder(compiled.network, compiled.plan, MemoryRecording())
        end = run(compiled.network, compiled.plan, recorder).state.position
        cells = Enclosure.of(compiled.network, "block", 1.0, span())
        volumes.append(cells.volumes(end).sum() / cells.drawn.sum())
    assert volumes[0] < 0.8  # springs alone do not keep it
    assert volumes[1] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_a_cut_opens_the_cells_it_goes_through_and_no_others(kind):
    script = """at 0 s: fix floor
  at 0 s: preserve volume of block with 10 kPa
  at 10 ms: cut block along plane through (0, 7.5, 0) mm facing (0, 1, 0)"""
    compiled = compiled_scene(scene(kind, script))
    recorder = Recorder(compiled.network, compiled.plan, MemoryRecording())
    outcome = run(compiled.network, compiled.plan, recorder)
    ((time, leak),) = [(t, h) for t, h in outcome.logged_events if h.kind == "leak"]
    assert time == 0.01
    assert leak.cause.startswith(
        "4 cells of block are torn and no longer hold pressure; torn by"
    )
    left = outcome.state.enclosures["block"]
    assert left.item_count == 8
    middles = compiled.network.position[left.corners].mean(axis=1)
    assert np.abs(middles[:, 1] - 7.5e-3).min() > 2.4e-3


def test_a_single_torn_edge_opens_the_cells_around_it():
    net, enclosure = block(reach="nearest neighbours")
    middle = net.position[net.springs.ends].mean(axis=1) * 1e3
    for place, cells in (((5, 5, 2.5), 4), ((0, 5, 2.5), 2), ((0, 0, 2.5), 1)):
        alive = np.ones(net.entity_count, dtype=bool)
        (edge,) = np.flatnonzero(np.abs(middle - place).max(axis=1) < 1e-6)
        alive[edge] = False
        torn = enclosure.lost_items(alive)
        assert len(torn) == cells
        left = enclosure.without(torn)
        assert left.item_count == 12 - cells
        stays = np.delete(np.arange(12), torn)
        position = shaken(net)
        assert left.volumes(position) == pytest.approx(enclosure.volumes(position)[stays])
        assert len(left.lost_items(alive)) == 0
        alive[:] = False
        assert len(left.lost_items(alive)) == left.item_count


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_the_reference_squeezes_and_cuts_every_kind_alike(kind):
    _validate(kind)


def test_the_reference_squeezes_and_cuts_a_block_alike():
    _validate("sodium chloride")


def _validate(kind):
    script = """at 0 s: { fix floor; preserve volume of block with 10 kPa }
  from 0 s to 10 ms: move lid by (0, 0, -3) mm using smooth profile
  at 12 ms: cut block along plane through (0, 7.5, 0) mm facing (0, 1, 0)"""
    found = validated(scene(kind, script, drag="5 mN*s/m", duration="18 ms"))
    assert found.verdict == "kept"
    assert quantity(found, "energy balance").error < 1e-5


def test_measures_look_at_all_cells_whether_they_leak_or_not():
    script = """at 0 s: { fix floor; preserve volume of block with 10 kPa }
  at 10 ms: cut block along plane through (0, 7.5, 0) mm facing (0, 1, 0)"""
    text = scene(script=script) + "expect volume(block) between 1.49 ml and 1.51 ml over run\n"
    compiled = compiled_scene(text)
    recorder = Recorder(compiled.network, compiled.plan, MemoryRecording())
    assert run(compiled.network, compiled.plan, recorder).failures == ()
