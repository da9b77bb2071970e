"""Indentation: a ball is pressed into a block that sticks to its ground.

Of a layer with the thickness h, Young's modulus E and Poisson's ratio ν, a ball with the radius
R that is pressed in by δ feels the force

    F = 4/3 E/(1 - ν²) √R δ^1.5 (1 - 2a χ/π + 4a² χ²/π² - 8/π³ (a³ + 4π²/15 b) χ³
                                 + 16a/π⁴ (a³ + 3π²/5 b) χ⁴),            χ = √(R δ)/h,

    a = -(1.2876 - 1.4678 ν + 1.3442 ν²)/(1 - ν),    b = (0.6387 - 1.0277 ν + 1.5164 ν²)/(1 - ν)

(E. K. Dimitriadis et al., Biophys. J. 82:2798, 2002); for χ = 0 it is that of H. Hertz (1882).
"""

from collections.abc import Iterator
from math import pi, sqrt

from msgspec import Struct

from tissuec.analysis.lab.bench import TICK, TestBench, Unmeasured
from tissuec.analysis.lab.coupon import BODY, FREE, SPRINGS
from tissuec.analysis.lab.statics import TensionTest

CELLS = (16, 20)  # across a block, coarse and fine
WIDTH = 0.04  # [m], of a block of matter
CONTACT = 1.0 / 8.0  # radius of the contact, as part of the width
#: Radius of the ball over that of the contact: a flat ball hardly strains a tissue that
#: stiffens; nets of springs are pressed more deeply, so that more of them carry the ball.
ROUND, ROUND_FOR_SPRINGS = 64.0, 4.0
_HARD = 80.0  # contact stiffness over Young's modulus times the length of a cell
_THIN = 0.04  # contact layer over the depth
_QUARTER = " ".join(
    f"symmetric about plane through (0, 0, 0) m facing ({axis});"
    for axis in ("1, 0, 0", "0, 1, 0")
)


class IndentedBlock(Struct, frozen=True):
    """A block a quarter as high as wide; of elements, a quarter of it, between two mirrors.

    Attributes:
        cells: Across; even.
        width: [m].
        of_springs: Whether it is a net of springs, and not of elements.
        is_prestressed: Whether its tissue has a prestress, which is removed.
    """

    cells: int
    width: float
    of_springs: bool = False
    is_prestressed: bool = False

    @property
    def cell(self) -> float:
        """Return the length of a cell [m]."""
        return self.width / self.cells

    @property
    def height(self) -> float:
        return 0.25 * self.width

    @property
    def radius(self) -> float:
        """Return the radius of the ball [m]."""
        return self.round * CONTACT * self.width

    @property
    def round(self) -> float:
        """Return the radius of the ball over that of the contact."""
        return ROUND_FOR_SPRINGS if self.of_springs else ROUND

    @property
    def depth(self) -> float:
        """Return how deep the ball is pressed in [m]."""
        return (CONTACT * self.width) ** 2 / self.radius

    def body(self, tissue: str, *, tabs: str = "", rupture: bool = False) -> Iterator[str]:
        """Yield the body, its ground and the ball; it has no tabs and does not break."""
        width = self.width if self.of_springs else 0.5 * self.width
        corner = f"({width:.15g}, {width:.15g}, {self.height:.15g}) m"
        if self.is_prestressed:
            yield f"tissue {FREE} like {tissue} {{ prestress = 0 }}"
            tissue = FREE
        springs = SPRINGS if self.of_springs else ""
        yield (
            f"body {BODY} {{ mesh is lattice {{ {springs}cell = {self.cell:.15g} m; "
            f"box from (0, 0, 0) m to {corner} }}; tissue is {tissue} }}"
        )
        yield f"set lab ground = nodes of {BODY} where z < {0.25 * self.cell:.15g} m"
        middle = 0.5 * self.width if self.of_springs else 0.0
        top = self.height + self.radius - self.depth
        yield (
            f"tool lab ball {{ kind is probe; radius = {self.radius:.15g} m; "
            f"centre = ({middle:.15g}, {middle:.15g}, {top:.15g}) m }}"
        )

    def faces(self, *names: str) -> Iterator[str]:
        """Yield nothing: no load acts on a face."""
        yield from ()


def blocks(bench: TestBench) -> tuple[IndentedBlock, IndentedBlock]:
    """Return a coarse block and a fine one, which is larger if quantities belong to springs."""
    widths = (
        (WIDTH, WIDTH) if bench.is_of_matter else [cells * bench.spacing for cells in CELLS]
    )
    coarse, fine = (
        IndentedBlock(*one, bench.of_springs, bench.is_prestressed)
        for one in zip(CELLS, widths, strict=True)
    )
    return coarse, fine


def indentation(bench: TestBench, block: IndentedBlock, tension: TensionTest) -> float:
    """Return the Young's modulus of the layer that resists the ball as the block does [Pa].

    Raises:
        Unmeasured: The run stopped, or the block does not resist.
    """
    stiffness, thickness = _HARD * tension.modulus * block.cell, _THIN * block.depth
    mirrors, part = ("", 1.0) if block.of_springs else (_QUARTER, 4.0)
    reading = bench.run(
        block,
        ["at 0 s: fix lab ground", "at 0 s: settle"],
        (),
        ["force of lab ball"],
        f"duration = 0.5 {TICK}; integrator is dop853",
        interval=f"1 {TICK}",
        environment=f"contact is tools only; contact stiffness = {stiffness:.15g} N/m; "
        f"contact layer = {thickness:.15g} m; {mirrors}",
    )
    if reading.stopped:
        raise Unmeasured(reading.stopped)
    force = -part * float(reading.logs["force of lab ball"][0, 2])
    if not force > 0.0:
        raise Unmeasured("it has no resistance")
    return force / layer_force(1.0, tension.ratio, block.radius, block.depth, block.height)


def layer_force(
    modulus: float, ratio: float, radius: float, depth: float, height: float
) -> float:
    """Return the force on a ball in a layer that sticks to its ground [N]; see the module.

    Args:
        modulus: E [Pa].
        ratio: ν.
        radius: R [m].
        depth: δ [m].
        height: h [m]; infinite for a half space.
    """
    chi = sqrt(radius * depth) / height
    a = -(1.2876 - 1.4678 * ratio + 1.3442 * ratio**2) / (1.0 - ratio)
    b = (0.6387 - 1.0277 * ratio + 1.5164 * ratio**2) / (1.0 - ratio)
    correction = (
        1.0
        - 2.0 * a / pi * chi
        + 4.0 * (a / pi) ** 2 * chi**2
        - 8.0 / pi**3 * (a**3 + 4.0 * pi**2 / 15.0 * b) * chi**3
        + 16.0 * a / pi**4 * (a**3 + 3.0 * pi**2 / 5.0 * b) * chi**4
    )
    return 4.0 / 3.0 * modulus / (1.0 - ratio**2) * sqrt(radius) * depth**1.5 * correction
