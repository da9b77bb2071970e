"""Cracks advance at the toughness of a tissue on every mesh; statics with code of its own."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.matter.elastic import findings, moved, scene, stiffness

YOUNG, TOUGH = 10e3, 8.0
TISSUE = f"Young's modulus = {YOUNG} Pa; density = 1000 kg/m^3; retardation time = 1 ms"
WIDTH, HEIGHT = 96.0, 40.0  # of strips that are drawn across [mm]


def sheet(rows):
    """Return a wall in the plane of x and y."""
    columns = round(WIDTH / HEIGHT * rows)
    return (
        f"mesh is sheet {{ corner = (0, 0, 0) mm; first edge = ({WIDTH}, 0, 0) mm; "
        f"second edge = (0, {HEIGHT}, 0) mm; columns = {columns + 1}; rows = {rows + 1}; "
        "diagonals is both }; thickness = 2 mm",
        1,
    )


def block(kind, rows, reach="second neighbours"):
    """Return a bar two cells thick along y."""
    cell = HEIGHT / rows
    columns = round(WIDTH / cell)
    return (
        f"mesh is lattice {{ kind is {kind}; reach is {reach}; cell = {cell} mm; "
        f"box from (0, 0, 0) mm to ({columns * cell}, {2 * cell}, {HEIGHT}) mm }}",
        2,
    )


def toughness_found(body, up, steps):
    """Return the energy per area at which a crack between clamped edges advances [J/m²].

    A strip that is drawn across holds the energy W per volume far ahead of a crack. One that
    advances by da relieves a height H of it: G = W H (Rivlin and Thomas 1953). The springs
    nearest to breaking are taken out in some steps, and the largest G that this needs is what
    drives a crack along the strip.
    """
    network, plan = scene(f"{TISSUE}; toughness = {TOUGH} J/m^2", f"{body}; rupture is allowed")
    springs = SimpleNamespace(
        ends=network.springs.ends, stiffness=network.springs.stiffness.copy()
    )
    net = SimpleNamespace(position=network.position, springs=springs)
    x, ends = net.position, springs.ends
    low, high = x.min(axis=0), x.max(axis=0)
    along = x[ends[:, 1]] - x[ends[:, 0]]
    n = along / np.linalg.norm(along, axis=1, keepdims=True)
    held = {}
    for edge, by in ((low[up], 0.0), (high[up], 1.0)):
        for node in np.flatnonzero(np.isclose(x[:, up], edge)).tolist():
            held |= {3 * node + axis: by * (axis == up) for axis in range(3)}

    def elongations():
        u, _ = moved(stiffness(net, plan), held)
        return np.einsum("sk,sk->s", u[ends[:, 1]] - u[ends[:, 0]], n)

    middle = x[ends].mean(axis=1)
    limit = network.springs.strength / np.where(
        springs.stiffness > 0.0, springs.stiffness, np.inf
    )
    # Of the strip without a crack, weighted towards its middle, per square of the elongation.
    half = 0.25 * (high[0] - low[0])
    weight = np.clip(1.5 - np.abs(middle[:, 0] - 0.5 * (low + high)[0]) / half, 0.0, 1.0)
    thickness = 2e-3 if up == 1 else np.ptp(x[:, 1])
    energy = 0.5 * weight @ (springs.stiffness * elongations() ** 2)
    per_square = energy / (2.0 * half * thickness)
    across = np.prod(x[ends][:, :, up] - 0.5 * (low + high)[up], axis=1) < 0.0
    springs.stiffness[across & (middle[:, 0] < 0.35 * high[0])] = 0.0
    found = []
    for _ in range(steps):
        with np.errstate(divide="ignore", invalid="ignore"):
            nearness = np.where(springs.stiffness > 0.0, elongations() / limit, 0.0)
        found.append(per_square / nearness.max() ** 2)
        springs.stiffness[nearness > nearness.max() * (1.0 - 1e-6)] = 0.0
    return max(found)


# Springs hold the energy of a crack on average only, and which of them break first depends on
# the net. By a breaking strain, a crack would need twice as much with cells twice as large.
@pytest.mark.parametrize(
    ("strip", "steps", "off"),
    [
        (sheet(11), 16, 0.1),
        (sheet(21), 16, 0.05),
        (block("sodium chloride", 7), 30, 0.15),
        (block("caesium chloride", 7), 30, 0.15),
        (block("sodium chloride", 11), 30, 0.4),
        (block("caesium chloride", 11), 30, 0.4),
        (block("diamond", 4, "third neighbours"), 30, 0.15),
    ],
    ids=[
        "sheet",
        "finer sheet",
        "sodium",
        "caesium",
        "finer sodium",
        "finer caesium",
        "diamond",
    ],
)
def test_a_crack_needs_the_toughness_on_every_mesh(strip, steps, off):
    assert toughness_found(*strip, steps) == pytest.approx(TOUGH, rel=off)


BAR = (
    "mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; pieces = 4 }; "
    "rupture is allowed"
)


@pytest.mark.parametrize(
    "law",
    ["", "; stress of strain = 10 kPa * strain + 100 kPa * strain^3"],
    ids=["line", "curve"],
)
def test_a_bar_breaks_where_it_holds_the_energy_of_its_section(law):
    network, _ = scene(f"{TISSUE}; toughness = 2 J/m^2{law}", BAR)
    pieces = network.springs.ends[:, 1] - network.springs.ends[:, 0] == 1
    length, section = 10e-3, np.pi * 1e-6
    # ½ 1e4 ε² + ¼ 1e5 ε⁴ per volume, or only the first, times the length is the toughness.
    root = np.roots([0.25e5, 0.5e4, -2.0 / length]) if law else [2.0 * 2.0 / (length * 1e4)]
    strain = np.sqrt(max(root))
    stress = 1e4 * strain + (1e5 * strain**3 if law else 0.0)
    assert network.springs.strength[pieces] == pytest.approx(section * stress, rel=1e-9)


def test_toughness_says_the_same_as_the_force_of_springs():
    found = findings(f"{TISSUE}; toughness = 2 J/m^2; breaking force = 3 N", BAR)
    assert [one.code for one in found] == ["TIS306"]
