"""Natural frequencies against theory.

Takes about two minutes, and needs what the tests need.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import click
import numpy as np

import tissuec
from benchmarks.publishing import publish, write_option
from tests.analysis.vibration.theory import (
    DENSITY,
    YOUNG,
    ball,
    bar,
    bar_frequencies,
    breathing,
    breathing_rate,
    extensional,
    rod,
)
from tissuec.core.markdown import table

MEMBRANE = """language 1
tissue cord { spring constant = 50 N/m; viscosity = 0 N*s/m; mass = 1 g; prestress = 5 % }
body net {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 40, 0) mm
    columns = COUNT; rows = COUNT
  }
  tissue is cord
}
set rim = nodes of net where x < 0.1 mm or x > 39.9 mm or y < 0.1 mm or y > 39.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix rim }
simulate { duration = 1 s }
"""

SHELL = (
    MEMBRANE.replace(
        "spring constant = 50 N/m; viscosity = 0 N*s/m; mass = 1 g; prestress = 5 %",
        "Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms",
    )
    .replace("tissue is cord\n", "tissue is cord; thickness = 2 mm; bending is elastic\n")
    .replace("rows = COUNT\n", "rows = COUNT; diagonals is both\n")
)

PLATE = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body plate {
  mesh is lattice {
    kind is sodium chloride; reach is second neighbours
    cell = CELL mm; box from (0, 0, 0) mm to (60, 60, 3) mm
  }
  tissue is gel
}
set rim = nodes of plate where x < 0.1 mm or x > 59.9 mm or y < 0.1 mm or y > 59.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix rim }
simulate { duration = 1 s }
"""


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure everything."""
    head = ("motion", "theory", "mesh", "error")
    publish("modes", {"theory": table(head, list(rows()))}, write=write)


def rows() -> Iterator[tuple[str, str, str, str]]:
    """Yield the rows of the table."""
    for number in range(3):
        found = {pieces: rod(pieces)[number].frequency for pieces in (16, 32, 64)}
        due = bar_frequencies(40, 3)[number]
        yield (
            f"clamped thread, along, mode {number + 1}", f"√(E/ρ) {2 * number + 1}/4L",
            *compared("pieces", found, due),
        )  # fmt: skip
    found = {
        f"{8 // cell}": extensional(bar(40, 8, cell, count=8)).frequency for cell in (4, 2, 1)
    }
    name = "cells of thickness"
    yield (
        "clamped block, along",
        "√(E/ρ) 1/4L",
        *compared(name, found, bar_frequencies(40, 1)[0]),
    )
    bent = {f"{8 // cell}": bar(120, 8, cell, count=2) for cell in (4, 2, 1)}
    due = 1.8751**2 / (2 * np.pi) * np.sqrt(YOUNG * 0.008**2 / 12 / DENSITY) / 0.12**2
    found = {cells: modes[0].frequency for cells, modes in bent.items()}
    yield "clamped block, bending", "1.875² √(EI/ρA) / 2πL²", *compared(name, found, due)
    found = {cells: membrane(cells) for cells in (8, 16, 32)}
    # The net has the tension T/l per length, and m/l² per area.
    yield "square membrane, fixed rim", "√(2 s/μ) / 2a", *compared("cells", found, 1.0)
    found = {cells: supported(cells) for cells in (8, 16, 32)}
    due = np.pi / 0.04**2 * np.sqrt(YOUNG * 0.002**2 / 12 / (1 - 1 / 9) / DENSITY)
    yield "supported square wall, bending", "π √(D/ρh) / a²", *compared("cells", found, due)
    found = {f"{3 / cell:.0f}": plate(cell) for cell in (3, 1.5, 1, 0.75)}
    stiff = YOUNG * 0.003**3 / 12 / (1 - 0.25**2)
    due = 35.985 / (2 * np.pi) * np.sqrt(stiff / (DENSITY * 0.003)) / 0.06**2
    yield "clamped square plate", "35.99 √(D/ρh) / 2πa²", *compared(name, found, due)
    for preserved, formula in ((False, "ω² = 2E/(ρR²(1-ν))"), (True, "ω² = … + 3K/(ρhR)")):
        found = {
            n: breathing(ball(t, preserved=preserved))[0].frequency for t, n in NODES.items()
        }
        due = breathing_rate(preserved=preserved) / (2 * np.pi)
        what = "with a volume that is kept" if preserved else "empty"
        yield f"breathing of a sphere, {what}", formula, *compared("nodes", found, due)


NODES = {1: 42, 2: 162, 3: 642}


def membrane(cells: int) -> float:
    """Return the lowest frequency of a net over that of a membrane of the same tension."""
    found = tissuec.modes(MEMBRANE.replace("COUNT", str(cells + 1)), count=1)
    length = 0.04 / cells
    network = found.state.network
    tension = 50.0 * (length - network.springs.rest[0]) / length  # s, per length
    area = found.state.mass.max() / length**2
    return found[0].frequency / (np.sqrt(2.0 * tension * 1.0 / area) / (2 * 0.04))


def supported(cells: int) -> float:
    """Return the lowest frequency [Hz] of a wall that bends elastically; its rim is held."""
    return _lowest(SHELL.replace("COUNT", str(cells + 1)))


def plate(cell: float) -> float:
    """Return the lowest frequency [Hz] of a plate of a solid; its cells in mm."""
    return _lowest(PLATE.replace("CELL", f"{cell:g}"))


def _lowest(scene: str) -> float:
    frequency = tissuec.modes(scene, count=1)[0].frequency
    assert frequency is not None  # the scene is stable
    return frequency


def compared(name: str, found: Mapping[Any, Any], due: float) -> tuple[str, str]:
    """Return the meshes and the errors of their frequencies in per cent."""
    errors = (f"{100 * (value / due - 1):+.2f} %" for value in found.values())
    return f"{', '.join(map(str, found))} {name}", ", ".join(errors)


if __name__ == "__main__":
    main()
