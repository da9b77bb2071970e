"""Stress of walls and solids against the curve that is written.

Takes some seconds. The pieces are drawn evenly along one axis and are free to become narrower.
"""

import click
import numpy as np
from scipy.optimize import brentq

import tissuec
from benchmarks.publishing import publish, write_option
from tissuec.core.markdown import table
from tissuec.model.network import Network

SIDES = np.array([40e-3, 20e-3, 20e-3])
THICKNESS = 1e-3
STRAINS = (0.02, 0.05, 0.1, 0.2, 0.3)
SCENE = """language 1
tissue gel {
  stress of strain = 2 kPa * (exp(10 * strain) - 1)
  density = 1000 kg/m^3
  retardation time = 5 ms
}
body piece { mesh is MESH; tissue is gel }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
LATTICE = (
    "lattice {{ kind is {}; reach is second neighbours; cell = {} mm; "
    "box from (0, 0, 0) mm to (40, 20, 20) mm }}"
)
#: Of each mesh: its name, how it is written, and its dimensions.
MESHES = {
    "sheet, both diagonals": (
        "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; "
        "second edge = (0, 20, 0) mm; columns = 17; rows = 9; diagonals is both }; "
        "thickness = 1 mm",
        2,
    ),
    "lattice, caesium chloride": (LATTICE.format("caesium chloride", 5), 3),
    "lattice, sodium chloride": (LATTICE.format("sodium chloride", 2.5), 3),
}


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure all meshes."""
    rows = [("thread, explicit", *("1.00" for _ in STRAINS))]
    for name, (mesh, dimensions) in MESHES.items():
        network = tissuec.compile(SCENE.replace("MESH", mesh)).network
        volume = SIDES.prod() if dimensions == 3 else SIDES[0] * SIDES[1] * THICKNESS
        parts = [
            tension(network, strain, dimensions) / volume / (2e3 * np.expm1(10.0 * strain))
            for strain in STRAINS
        ]
        rows.append((name, *(f"{part:.2f}" for part in parts)))
    heads = ("mesh", *(f"{100.0 * strain:.0f} %" for strain in STRAINS))
    publish("curves", {"stress curves": table(heads, rows)}, write=write)


def tension(network: Network, strain: float, dimensions: int) -> float:
    """Return the derivative of the energy by a strain along x with free sides [J]."""

    def along(side: float) -> np.ndarray:
        stretch = np.ones(3)
        stretch[0], stretch[1:dimensions] = 1.0 + strain, 1.0 + side
        position = network.position * stretch
        span = position[network.springs.ends[:, 1]] - position[network.springs.ends[:, 0]]
        length = np.linalg.norm(span, axis=1)
        force = network.springs.behaviour.pull(length - network.springs.rest)
        return (force / length) @ span**2 / stretch

    free = brentq(lambda side: along(side)[1:dimensions].sum(), -0.5, 0.1)
    return float(along(free)[0])  # a tuple only with full_output


if __name__ == "__main__":
    main()
