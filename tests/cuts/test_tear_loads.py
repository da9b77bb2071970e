"""Loads at which tears run, and the energy that they take, against closed forms.

A tear of the toughness G runs where it releases G per area. Elements open one after the other,
so that the load swings around this value, and its peaks are higher.
"""

import numpy as np
import pytest

from tests.contact.scenes import play
from tests.cuts.scenes import sections

YOUNG, POISSON = 10e3, 0.3
SHEAR, PLANE = YOUNG / (2.0 + 2.0 * POISSON), YOUNG / (1.0 - POISSON**2)  # [Pa]
LATTICE = "lattice { cell = CELL mm; box from (0, 0, 0) mm to (LENGTH, HEIGHT, CELL) mm }"
SCENE = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 0.3 ms; LIMIT }
body plate {
  mesh is MESH
  made of MADE; tissue is gel; RUPTURE
}
set low = nodes of plate where LOW
set high = nodes of plate where HIGH
environment {
  gravity = (0, 0, 0) m/s^2; mass damping = AIR
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
  symmetric about plane through (0, 0, CELL) mm facing (0, 0, -1)
  MORE
}
"""


def slow(*counts):
    return [
        pytest.param(*(each if isinstance(each, tuple) else (each,)), marks=pytest.mark.slow)
        for each in counts
    ]


def scene(
    cell, length, height, toughness, air="0 Hz", ends="", more="", mesh=LATTICE, made="elements"
):
    """Return a plate in plane strain, one cell thick, up to its script; all in metres."""
    limit, rupture = f"toughness = {toughness!r} J/m^2", "rupture by faces"
    given = {
        "MESH": mesh,
        "LIMIT": limit if toughness else "", "RUPTURE": rupture if toughness else "",
        "LOW": "y < 0.001 mm" + ends, "HIGH": f"y > {1e3 * height - 1e-3!r} mm" + ends,
        "CELL": repr(1e3 * cell), "LENGTH": repr(1e3 * length), "HEIGHT": repr(1e3 * height),
        "AIR": air, "MORE": more, "MADE": made,
    }  # fmt: skip
    text = SCENE
    for word, each in given.items():
        text = text.replace(word, each)
    return text


def notched(length, side):
    """Return the sentence of a notch of some length, at some height [m]."""
    x, y = 1e3 * length, 1e3 * side
    line = f"line from (-1, {y!r}, 0) mm to ({x!r}, {y!r}, 0) mm"
    return f"at 0 s: cut plate along {line} facing (0, 1, 0)\n"


def opened(played):
    """Return times at which faces became free [s]."""
    return np.array([t for t, one in played.outcome.logged_events if one.kind == "rupture"])


def torn_area(played, notch):
    """Return the area of torn faces [m²], without that of a notch."""
    middle, size, _ = sections(played.outcome.state)
    return 0.5 * size[middle[:, 0] > notch].sum()


# --- a strip that is stretched as a whole -----------------------------------------------------

HEIGHT, STRAIN = 24e-3, 0.02
HELD = HEIGHT * STRAIN


def energy_density(most):
    """Return the function that finds W₀ [Pa] of a tall strip at displacements of its edge [m].

    Args:
        most: Largest displacement [m].
    """
    text = scene(
        8e-3, 8e-3, HEIGHT, 0.0, "0 Hz", "",
        "symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)\n"
        "symmetric about plane through (8, 0, 0) mm facing (-1, 0, 0)",
    ) + (
        f"script {{ at 0 s: fix low\nfrom 0 s to 1 s: move high by (0, {1e3 * most!r}, 0) mm\n"
        "using constant speed }\nsimulate { duration = 1 s; integrator is equilibrium }\n"
        "output { energy every 20 ms }\n"
    )  # fmt: skip
    time, energy = play(text).energies()
    known = energy["elastic"] / (8e-3 * 8e-3 * HEIGHT)
    return lambda edge: np.interp(np.square(edge), np.square(time * most), known)


def pulled_apart(cell, toughness, stored, notch, side, **given):
    """Return the run of a strip until it is apart, and G over toughness where faces open.

    The notch is as long as the strip is high, and what is left at first twice as long: at its
    end, G falls by a tenth. G rises by 17 % in 0.4 s, while waves cross the strip in 7 ms.
    """
    edges = np.sqrt([0.95, 1.12, 4.0]) * HELD
    ways = [repr(each) for each in (1e3 * np.diff(edges, prepend=0.0)).tolist()]
    text = scene(cell, 3.0 * HEIGHT, HEIGHT, toughness, **given) + (
        f"script {{ at 0 s: fix low\n{notched(notch, side)}"
        f"from 0 s to 0.1 s: move high by (0, {ways[0]}, 0) mm using smooth profile\n"
        f"from 0.15 s to 0.55 s: move high by (0, {ways[1]}, 0) mm using constant speed\n"
        f"from 0.55 s to 0.75 s: move high by (0, {ways[2]}, 0) mm using constant speed }}\n"
        "simulate { duration = 0.75 s }\n"
        "output { energy every 5 ms; count(pieces of plate) every 5 ms\n"
        "trajectory every 0.1 s }\n"
    )
    played = play(text)
    edge = np.interp(opened(played), [0.1, 0.15, 0.55], edges[[0, 0, 1]])
    return played, stored(edge) * HEIGHT / toughness


@pytest.mark.parametrize(
    ("count", "made"),
    [
        (8, "elements"),
        *slow((12, "elements"), (16, "elements"), (8, "quadratic elements")),
    ],
)
def test_a_strip_tears_where_its_energy_is_that_of_the_faces(count, made):
    """A long strip held by its edges: G = W₀ H, whatever the length of the tear.

    (R. S. Rivlin, A. G. Thomas, J. Polym. Sci. 10:291, 1953.)
    """
    cell, stored = HEIGHT / count, energy_density(1.3 * HELD)
    toughness = float(stored(HELD) * HEIGHT)
    notch, side = HEIGHT + 0.5 * cell, 0.5 * (HEIGHT + cell)
    played, ratio = pulled_apart(cell, toughness, stored, notch, side, made=made)
    assert (np.abs(ratio[:3] - 1.0) < 0.1).all()
    assert played.log("pieces of plate")[1][-1, 0] == 2
    _, energy = played.energies()
    spent = -energy["switched"][-1]
    assert spent == pytest.approx(toughness * cell * (3.0 * HEIGHT - notch), rel=0.01)
    assert spent == pytest.approx(toughness * torn_area(played, notch), rel=1e-3)


def write_wavy(path, count, wave):
    """Write a strip in mm whose rows of cells rise and fall, as Abaqus' elements.

    Args:
        wave: Height of the waves in the middle over that of the strip; they are twice as long.
    """
    columns, high = 3 * count, 1e3 * HEIGHT
    number = np.arange((columns + 1) * (count + 1) * 2).reshape(columns + 1, count + 1, 2)
    x, y, z = np.unravel_index(number.ravel(), number.shape)
    x, y, z = (each * high / count for each in (x, y, z))
    y = y + wave * high * np.sin(np.pi * x / high) * np.sin(np.pi * y / high)
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = [
        number[i : columns + i, j : count + j, k].ravel() for k in range(2) for i, j in ring
    ]
    lines = ["*NODE"]
    lines += [
        f"{n + 1}, {a:.9g}, {b:.9g}, {c:.9g}"
        for n, (a, b, c) in enumerate(zip(x, y, z, strict=True))
    ]
    lines.append("*ELEMENT, TYPE=C3D8")
    lines += [", ".join(map(str, (n + 1, *(c + 1)))) for n, c in enumerate(np.stack(cells, 1))]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.slow
def test_rows_of_cells_that_are_tilted_change_nothing(tmp_path, monkeypatch):
    """Rows are at up to 27° to the tear; it goes straight on, at the same load."""
    count = 12
    monkeypatch.chdir(tmp_path)
    write_wavy(tmp_path / "wavy.inp", count, 0.16)
    cell, stored = HEIGHT / count, energy_density(1.3 * HELD)
    toughness, notch = float(stored(HELD) * HEIGHT), HEIGHT + 0.5 * cell
    mesh = 'imported { file "wavy.inp" in mm }'
    played, ratio = pulled_apart(cell, toughness, stored, notch, 0.505 * HEIGHT, mesh=mesh)
    assert (np.abs(ratio[:3] - 1.0) < 0.1).all()
    middle, size, normal = sections(played.outcome.state)
    new = middle[:, 0] > notch
    each = np.degrees(np.arccos(np.clip(np.abs(normal[new, 1]), 0.0, 1.0)))
    spent = -played.energies()[1]["switched"][-1]
    assert spent == pytest.approx(toughness * torn_area(played, notch), rel=0.01)
    assert size[new] @ each / size[new].sum() < 1.0
    assert np.abs(middle[new, 1] - 0.505 * HEIGHT).max() < 0.1 * cell


# --- a double cantilever ---------------------------------------------------------------------

ARM, NOTCH, LONG = 13e-3, 2.5, 6.0  # height of an arm [m]; notch and length over this height
STIFF = PLANE * ARM**3 / 12.0  # of an arm of the width 1 [N m]
PEEL = 0.03**2 * PLANE * ARM / 12.0  # toughness [J/m²]: roots are bent by 0.03/c


def root():
    """Return the correction χ for the root of arms: they act as if they were longer by χ c."""
    gamma = 1.18 * PLANE / SHEAR
    return np.sqrt(PLANE / (11.0 * SHEAR) * (3.0 - 2.0 * (gamma / (1.0 + gamma)) ** 2))


@pytest.mark.parametrize("count", [9, *slow(13, 17)])
def test_a_double_cantilever_is_peeled_by_the_load_of_beams(count):
    """Arms of the height c that are beams, with a correction for their root.

    Under the load P per width, G = (P a')²/(E' I), with I = c³/12 and a' = a + χ c; as the
    deflection of an arm is w = P a'³/(3 E' I), P and w alone give G. The length of the notch
    shows χ, which is 0.69 (S. Hashemi, A. J. Kinloch, J. G. Williams, Proc. R. Soc. Lond. A
    427:173, 1990, with E' along and across). Arms are stretched more than what is ahead of the
    tear, yet it goes straight on.
    """
    cell, chi = 2.0 * ARM / count, root()

    def tip(length):  # where a tear of this length runs [m]
        return (length + chi) ** 2 * ARM**2 / 3.0 * np.sqrt(PEEL / STIFF)

    first, last = 0.85 * tip(NOTCH), tip(3.5)
    length = round(LONG * ARM / cell) * cell
    rise, rest = repr(1e3 * float(first)), repr(1e3 * float(last - first))
    text = scene(cell, length, 2.0 * ARM, PEEL, "5 Hz", " and x < 0.001 mm") + (
        f"script {{ {notched(NOTCH * ARM, ARM)}"
        f"from 0 s to 0.4 s: {{ move high by (0, {rise}, 0) mm using smooth profile\n"
        f"  move low by (0, -{rise}, 0) mm using smooth profile }}\n"
        f"from 0.5 s to 3.5 s: {{ move high by (0, {rest}, 0) mm using constant speed\n"
        f"  move low by (0, -{rest}, 0) mm using constant speed }} }}\n"
        "simulate { duration = 3.5 s }\n"
        "output { force of high every 5 ms; energy every 5 ms; trajectory every 0.5 s }\n"
    )
    played = play(text)
    time, force = played.log("force of high")
    force = force[:, 1] / cell
    bend = np.interp(time, [0.4, 0.5, 3.5], [first, first, last])
    longer = np.cbrt(3.0 * STIFF * bend / force)
    ratio = (force * longer) ** 2 / STIFF / PEEL
    still = (time > 0.45) & (time < 0.5)
    assert longer[still].mean() == pytest.approx((NOTCH + chi) * ARM, rel=0.03)
    events = opened(played)
    assert len(events) >= 3
    assert ratio[time > events[0]].mean() == pytest.approx(1.0, abs=0.06)
    assert (np.abs(np.interp(events, time, ratio) - 1.0) < 0.12).all()
    middle, _, _ = sections(played.outcome.state)
    assert np.abs(middle[:, 1] - ARM).max() < 1e-3 * cell
