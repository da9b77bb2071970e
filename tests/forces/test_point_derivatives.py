"""Derivatives of elements for learning, by positions, velocities and numbers."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tissuec.compiled.calls import kernel_on
from tissuec.forces.matrices import numbers_of, with_numbers
from tissuec.learn.parameters.elements import elements_of, opened, with_open

SOLID = "lattice { cell = 10 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }"
WALL = (
    "sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm; "
    "columns = 3; rows = 2 }"
)
RELAXES = "relaxing share = 0.3; relaxation time = 20 ms"
YIELDS = f"{RELAXES}; yield stress = 5 kPa; flow viscosity = 100 Pa*s"
FIBRES = "fibre modulus = 70 kPa; fibre stiffening = 2; fibre dispersion = 0.1"
YEOH = "solid law is yeoh {{ second = {}; third = 0.1 }}; prestress = {} %"
#: Mesh, what the tissue and the body have, and another region.
CASES = {
    "two laws": (SOLID, YEOH, "prestress along (1, 0, 0)", "region end where x > 9 mm "
                 "{ tissue is jelly }"),
    "fibres": (SOLID, FIBRES, "fibres = (1, 0.2, 0)", ""),
    "solid that yields": (SOLID, YIELDS, "", ""),
    "wall": (WALL, f"{FIBRES}; {RELAXES}", "thickness = 1 mm; fibres = (1, 0.2, 0)", ""),
    "wall that yields": (WALL, YIELDS, "thickness = 1 mm", ""),
}  # fmt: skip


def scene(name, *numbers):
    mesh, tissue, body, region = CASES[name]
    return f"""language 1
tissue gum {{ Young's modulus = 20 kPa; {tissue.format(*numbers)}; density = 1000 kg/m^3
  retardation time = 1 ms; Poisson's ratio = 0.45 }}
tissue jelly {{ Young's modulus = 50 kPa; density = 1000 kg/m^3; Poisson's ratio = 0.4
  solid law is mooney rivlin {{ share = 0.3 }} }}
body cube {{ mesh is {mesh}; tissue is gum; {body}; {region} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 s }}
"""


def in_motion(name):
    """Return elements in a state, and typical sizes of its positions and velocities."""
    network = compiled_scene(scene(name, 0.4, 4)).network
    moved = compiled_scene(scene(name, 0.5, 5)).network
    network = with_open(network, opened(network, moved))
    (field,) = elements_of(network).values()
    chance = np.random.default_rng(1)
    x = network.position + 1.5e-3 * chance.normal(size=network.position.shape)
    x = np.pad(x, ((0, network.row_count - len(x)), (0, 0)))  # as loops have it
    v = 0.02 * chance.normal(size=(network.row_count, 3))
    size = np.full(v.shape, 0.02)
    for stored in field._stored:
        places = stored.places(field.points)
        rate = np.broadcast_to(0.05 * stored.rate[..., None, None], places.shape)
        has = np.broadcast_to((stored.slot >= 0)[..., None, None], places.shape)
        size.reshape(-1)[places[has]] = rate[has]
        v.reshape(-1)[places[has]] = (rate * chance.normal(size=places.shape))[has]
    return field, x, v, size


#: Those whose kernels take least to make; the others have the same loops.
QUICK = ("two laws", "wall")


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CASES],
)
def test_derivatives_are_transposes_and_agree_with_differences(name):
    field, x, v, size = in_motion(name)
    found, chance = field.derivatives, np.random.default_rng(2)
    numbers = numbers_of(field, found.columns)
    table = field.table(np.arange(len(x)), None, x)
    x, v, size = x.ravel(), v.ravel(), size.ravel()

    def forces(x, v, numbers):
        own, to = with_numbers(field, found.columns, numbers), np.zeros(x.size)
        own_table = own.table(np.arange(len(x) // 3), None, x.reshape(-1, 3))
        kernel_on(own.kernel, own_table)(0.0, x, v, to, np.zeros(2))
        return to

    count = 9  # more than there are lanes
    ways = [
        scale[:, None] * chance.normal(size=(len(scale), count))
        for scale in (np.full(x.size, 1e-3), 0.1 * size, 0.1 * np.abs(numbers))
    ]
    df = np.zeros((x.size, count))
    given = [each.ravel() for each in (*ways, df)]
    kernel_on(found.push_forward, table, 7)(0.0, x, v, *given, np.zeros(count))
    pushed = given[-1].reshape(df.shape)
    hidden = np.zeros(len(x) // 3, dtype=bool)
    hidden[field.internal_rows] = True
    parts = [np.repeat(each, 3) for each in (~hidden, hidden) if each.any()]
    # Forces and rates differ in size; both count alike.
    weight = chance.normal(size=x.size)
    for part in parts:
        weight[part] /= np.abs(pushed[part]).max()
    by = [np.zeros(each.size) for each in (x, v, numbers)]
    kernel_on(found.pull_back, table, 6)(0.0, x, v, weight, *by)
    pulled = sum(slope @ way for slope, way in zip(by, ways, strict=True))
    scale = np.abs(weight) @ np.abs(pushed)
    np.testing.assert_allclose(weight @ pushed, pulled, atol=1e-12 * scale.max())

    def at(step):
        dx, dv, dn = (step * way[:, 0] for way in ways)
        return forces(x + dx, v + dv, numbers + dn)

    step = 1e-3
    expected = (8.0 * (at(step) - at(-step)) - at(2 * step) + at(-2 * step)) / (12.0 * step)
    for part in parts:  # differences of fourth order, of steps of 1e-3 of strains of 0.1
        largest = np.abs(expected[part]).max()
        assert pushed[part, 0] == pytest.approx(expected[part], abs=1e-8 * largest)
