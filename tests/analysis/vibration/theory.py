"""Scenes whose natural frequencies are known, and the modes of theirs that are meant."""

from typing import Any

import numpy as np

import tissuec
from tissuec.analysis.vibration.modes import Mode, Modes

YOUNG, DENSITY = 10e3, 1000.0

BAR = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body bar {
  mesh is lattice {
    cell = CELL mm; box from (0, 0, 0) mm to (LENGTH, HEIGHT, HEIGHT) mm
  }
  tissue is gel
}
set left = nodes of bar where x < 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix left }
simulate { duration = 1 s }
"""

WALL = """language 1
tissue wall { Young's modulus = 10 kPa; Poisson's ratio = 1/3; density = 1000 kg/m^3
  retardation time = 5 ms }
body ball {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 20 mm; subdivisions = TIMES }
  tissue is wall; thickness = 1 mm; bending is none
}
environment { gravity = (0, 0, 0) m/s^2 }
SCRIPT
simulate { duration = 1 s }
"""
PRESERVED = "script { at 0 s: preserve volume of ball with 500 Pa }"


def bar(length: float, height: float, cell: float, **given: Any) -> Modes:
    """Return the lowest modes of a bar that is clamped at one end; sizes in mm."""
    sizes = {"LENGTH": length, "HEIGHT": height, "CELL": cell}
    text = BAR
    for name, size in sizes.items():
        text = text.replace(name, f"{size:g}")
    return tissuec.modes(text, **given)


def extensional(modes: Modes) -> Mode:
    """Return the mode that carries most of the momentum along x."""
    mass = modes.state.mass
    return max(modes, key=lambda mode: abs(mass @ mode.shape[:, 0]))


def breathing(modes: Modes) -> tuple[Mode, float]:
    """Return the mode of a sphere about the origin that is most like a change of its radius.

    And how much of such a change is in it, 1 being all.
    """
    mass, place = modes.state.mass, modes.state.position
    outward = place / np.linalg.norm(place, axis=1)[:, None]
    outward /= np.sqrt(mass.sum())
    found = [abs(np.einsum("n,nk,nk->", mass, mode.shape, outward)) for mode in modes]
    best = int(np.argmax(found))
    return modes[best], found[best]


def ball(times: int, *, preserved: bool) -> Modes:
    """Return all modes of a wall that is a sphere of radius 20 mm."""
    text = WALL.replace("TIMES", str(times)).replace("SCRIPT", PRESERVED if preserved else "")
    return tissuec.modes(text, count=1000)


def breathing_rate(*, preserved: bool) -> float:
    """Return ω [1/s] of a membrane shell: 2E/(ρR²(1-ν)) + 3K/(ρhR), ν = 1/3."""
    square = 2.0 * YOUNG / (DENSITY * 0.02**2 * (1.0 - 1.0 / 3.0))
    return float(np.sqrt(square + preserved * 3.0 * 500.0 / (DENSITY * 1e-3 * 0.02)))


ROD = """language 1
tissue cord { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body rod {
  mesh is thread { pieces = PIECES; thickness = 2 mm; line from (0, 0, 0) mm to (40, 0, 0) mm }
  tissue is cord
}
set left = nodes of rod where x < 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix left }
simulate { duration = 1 s }
"""


def rod(pieces: int) -> Modes:
    """Return the three lowest extensional modes of a thread of 40 mm, clamped at one end."""
    return tissuec.modes(ROD.replace("PIECES", str(pieces)), above=0.0, count=3)


def bar_frequencies(length: float, count: int) -> np.ndarray:
    """Return √(E/ρ) (2j-1)/4L [Hz] of a bar that is clamped at one end; its length in mm."""
    return np.sqrt(YOUNG / DENSITY) * (2 * np.arange(1, count + 1) - 1) / (4e-3 * length)
