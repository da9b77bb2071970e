"""Fluids in cavities against energies, closed forms, differences and the reference."""

import numpy as np
import pytest

from tests.derivatives import agree, follow_from_the_energy, forces
from tests.forces.test_pressure import network_of, shaken
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out, same_on_threads, same_when_resumed
from tissuec.core.structs import replace
from tissuec.forces.enclosed.fluids import FluidCavities
from tissuec.forces.enclosed.pressed_sides import NoSide, Pressed, pressed_faces
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.model.profiles import TimeProfile
from tissuec.validate.forces.fluids import FluidField

MODULUS, DENSITY, GRAVITY = 1e4, 1010.0, np.array([2.0, -1.0, -9.0])


def fluid_in(network, name, *, caps=False, density=DENSITY, inside=False, nodes=None):
    part = next(body for body in network.bodies if body.name == name)
    if nodes is None:
        nodes = np.arange(part.nodes.start, part.nodes.stop)
    faces = pressed_faces(network, Pressed(name, nodes, inside))
    made = FluidCavities.of(network, name, faces, MODULUS, density, part.span, has_caps=caps)
    return replace(made, gravity=GRAVITY)


@pytest.mark.parametrize(("name", "caps"), [("ball", False), ("tube", True)])
def test_forces_and_matrix_follow_from_the_energy(name, caps):
    network = network_of(name)
    # So light a modulus that the weight counts in each term.
    fluid = replace(fluid_in(network, name, caps=caps), modulus=300.0)
    follow_from_the_energy(
        fluid, shaken(network, 5e-4), every=7, force=1e-6, matrix=1e-5, rounding=1e-12
    )


def test_large_cavities_are_columns_apart_from_a_sparse_matrix():
    network = network_of("ball")
    fluid, count = fluid_in(network, "ball"), network.node_count
    sparse, wide = fluid.split(0.0, network.position, np.arange(count), count)
    assert wide.shape == (3 * count, 1)
    assert sparse.nnz < 0.5 * (3 * count) ** 2


@pytest.mark.parametrize(("name", "caps"), [("ball", False), ("tube", True)])
def test_all_forces_of_a_fluid_are_its_weight_wherever_it_is(name, caps):
    network = network_of(name)
    fluid = fluid_in(network, name, caps=caps)
    for away in (0.0, 3.0):
        found = forces(fluid, shaken(network, 5e-4) + away)
        weight = DENSITY * fluid.drawn.sum() * GRAVITY
        assert found.sum(axis=0) == pytest.approx(weight, rel=1e-9 if not away else 1e-7)
    # The energy is that of its mass at its centroid.
    moved = np.array([0.2, -0.3, 0.4])
    change = fluid.energy(0.0, network.position + moved) - fluid.energy(0.0, network.position)
    assert change == pytest.approx(-DENSITY * fluid.drawn.sum() * GRAVITY @ moved, rel=1e-9)


def test_without_weight_a_fluid_in_a_closed_wall_is_an_enclosed_volume():
    network = network_of("ball")
    fluid = fluid_in(network, "ball", density=0.0)
    kept = Enclosure.of(network, "ball", MODULUS, fluid.span)
    position = shaken(network, 5e-4)
    assert fluid.volumes(position) == pytest.approx(kept.volumes(position), rel=1e-12)
    np.testing.assert_allclose(forces(fluid, position), forces(kept, position), atol=1e-12)
    assert fluid.energy(0.0, position) == pytest.approx(kept.energy(0.0, position))
    assert np.array_equal(np.unique(fluid.walls), np.unique(kept.walls))


def test_the_pressure_at_the_wall_grows_with_the_depth():
    network = network_of("ball")
    fluid = fluid_in(network, "ball")
    found, position = forces(fluid, network.position), network.position
    # At rest as drawn, there is no pressure at the centroid.
    radius = np.linalg.norm(position, axis=1).mean()
    depth = position @ GRAVITY / np.linalg.norm(GRAVITY)
    outwards = np.einsum("nk,nk->n", found, position) / radius
    area = forces(fluid_in(network, "ball", density=0.0).swollen(1.0, TimeProfile(
        "constant", 0.0, np.inf)), position)  # fmt: skip
    area = np.linalg.norm(area, axis=1) / MODULUS
    hydrostatic = DENSITY * np.linalg.norm(GRAVITY) * depth * area
    assert np.abs(outwards - hydrostatic).max() < 0.1 * np.abs(hydrostatic).max()


@pytest.mark.parametrize(("name", "caps"), [("ball", False), ("tube", True)])
def test_forces_energy_power_and_matrix_are_those_of_the_reference(name, caps):
    network = network_of(name)
    fluid = fluid_in(network, name, caps=caps)
    fluid = replace(fluid, modulus=500.0).swollen(0.3, TimeProfile("ramp", -1.0, 2.0))
    position, velocity = shaken(network, 5e-4), shaken(network, 1.0, 9)
    reference = FluidField(fluid)
    agree(
        fluid, reference, position, velocity, force=1e-11, matrix=1e-9, energy=1e-10,
        lost=1e-12,
    )  # fmt: skip
    supplied = fluid.powers(0.0, position, velocity)[0]
    assert supplied == pytest.approx(reference.pumping(0.0, position, velocity), rel=1e-9)
    # Energy changes by what is put in, and by what moving the wall takes.
    step = 1e-6
    ahead, behind = (
        float(fluid.energy(sign * step, position + sign * step * velocity)) for sign in (1, -1)
    )
    taken = np.vdot(forces(fluid, position), velocity)
    assert (ahead - behind) / (2.0 * step) == pytest.approx(supplied - taken, rel=1e-5)


def test_each_space_is_a_cavity_of_its_own_and_leaks_alone():
    network = network_of("ball", "tube", "block")
    tube = fluid_in(network, "tube", caps=True)
    both = np.concatenate(
        [np.arange(part.nodes.start, part.nodes.stop) for part in network.bodies[:2]]
    )
    fluid = fluid_in(network, "ball", caps=True, nodes=both)
    assert fluid.item_count == 2
    volumes = fluid.volumes(network.position)
    assert volumes[1] == pytest.approx(tube.volumes(network.position)[0])
    position = shaken(network, 5e-4)
    alone = forces(tube, position)
    np.testing.assert_allclose(forces(fluid.only(np.array([1])), position), alone, atol=1e-12)
    alive = np.ones(network.entity_count, dtype=bool)
    alive[fluid.walls[fluid.walled == 0][0]] = False
    assert fluid.lost_items(alive).tolist() == [0]
    np.testing.assert_allclose(forces(fluid.intact(alive), position), alone, atol=1e-12)


def test_an_open_wall_keeps_no_fluid():
    network = network_of("tube", "sheet")
    with pytest.raises(NoSide, match="tube is open, so that it cannot keep a fluid") as error:
        fluid_in(network, "tube")
    assert error.value.hint == "close its open ends: with caps"
    with pytest.raises(NoSide, match="sheet encloses no space"):
        fluid_in(network, "sheet", caps=True)


GALLBLADDER = """language 1
tissue wall {
  Young's modulus = 200 kPa; Poisson's ratio = 0.49; density = 1060 kg/m^3
}
body gallbladder {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 15 mm; subdivisions = 1 }
  tissue is wall; thickness = 1.5 mm
}
set neck = nodes of gallbladder where z > 12 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: { fix neck; preserve volume of gallbladder with 1 MPa weighing 1.01 g/ml }
  at 0 s: { inflate gallbladder to 16 ml; settle }
  at 1 us: { change gravity to (0, 3, -4) m/s^2; settle }
}
simulate { duration = 2 us; integrator is dop853 }
output { force of neck every 1 us }
"""


def test_a_gallbladder_weighs_what_its_bile_and_its_wall_weigh():
    compiled = compiled_scene(GALLBLADDER)
    _, recording = carried_out(compiled)
    carried = recording.log_arrays("force of neck")[1]
    neck = compiled.network.position[:, 2] > 12e-3
    mass = compiled.network.mass[~neck].sum() + 1010.0 * 16e-6
    assert carried[0] == pytest.approx([0.0, 0.0, mass * 9.81], rel=1e-9, abs=1e-9)
    assert carried[2] == pytest.approx([0.0, -3.0 * mass, 4.0 * mass], rel=1e-9, abs=1e-9)


MOVING = """language 1
tissue wall { spring constant = 60 N/m; viscosity = 40 mN*s/m; mass = 40 mg }
body duct {
  mesh is tube {
    axis from (0, 0, 0) mm to (0, 0, 20) mm; radius = 5 mm; rings = 5; sides = 6
    diagonals is both
  }
  tissue is wall
}
body ball {
  mesh is sphere { centre = (30, 0, 0) mm; radius = 8 mm; subdivisions = 1 }; tissue is wall
}
set top = nodes of duct where z > 19 mm
set pole = nodes of ball where z > 6.5 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: { fix top; fix pole; preserve volume of ball with 3 kPa weighing 2 g/ml }
  at 0 s: preserve volume of duct with 1 kPa with caps
  from 0 s to 8 ms: press duct with 300 Pa using smooth profile
  from 0 s to 9 ms: inflate ball to 2.4 ml using smooth profile
}
simulate { duration = 30 ms; integrator is dop853; tolerance = 1e-5 }
output { trajectory every 3 ms; energy every 3 ms; pressure of duct every 3 ms }
"""


def test_pressures_and_fluids_are_the_same_on_threads(tmp_path, threads_in_small_nets):
    path = tmp_path / "scene.tis"
    fine = MOVING.replace("rings = 5; sides = 6", "rings = 52; sides = 42")
    path.write_text(fine.replace("duration = 30 ms", "duration = 9 ms"), encoding="utf-8")
    same_on_threads(path, 2)


def test_a_run_with_pressures_and_fluids_goes_on_as_if_it_had_not_stopped():
    compiled = compiled_scene(MOVING)
    same_when_resumed(compiled, "pressure of duct", 2)


def test_what_happens_to_a_moving_duct_is_what_the_reference_says():
    validation = validated(MOVING)
    assert validation.verdict == "kept"
    assert quantity(validation, "energy balance").error < 1e-6
