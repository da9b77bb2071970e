"""Cubes of one element under uniform strain and stress, as text of a scene.

A cube in tension or compression is an eighth of a larger one, bounded by three planes of
symmetry; a uniform stress acts on its other faces. In shear, all nodes of a cube are held or
moved. Neither has a prestress: specimens are cut out, and free of stress at rest.
"""

from collections.abc import Iterator, Sequence

from msgspec import Struct

from tissuec.analysis.lab.bench import TICK
from tissuec.analysis.lab.coupon import AXES, BODY, FREE
from tissuec.scene.tissues.known_curves import ACROSS, EQUIBIAXIAL

SIDE = 0.01  # [m]
PLANES = " ".join(
    f"symmetric about plane through (0, 0, 0) m facing ({axis});"
    for axis in ("1, 0, 0", "0, 1, 0", "0, 0, 1")
)


class Cube(Struct, frozen=True):
    """A cube of one element.

    Attributes:
        has_fibres: Whether fibres run along x.
        is_prestressed: Whether its tissue has a prestress.
        is_inviscid: Whether its viscosity is left out.
        relaxing: Names of shares of branches to leave out, for the response after a long time.
        times: Names and values [s] of relaxation times that it has instead of its own.
    """

    has_fibres: bool
    is_prestressed: bool
    is_inviscid: bool = False
    relaxing: tuple[str, ...] = ()
    times: tuple[tuple[str, float], ...] = ()

    def body(self, tissue: str, *, tabs: str = "", rupture: bool = False) -> Iterator[str]:
        """Yield the cube; it has no tabs."""
        free = ["prestress = 0"] if self.is_prestressed else []
        free += ["retardation time = 0 s"] if self.is_inviscid else []
        free += [f"{share} = 0" for share in self.relaxing]
        free += [f"{name} = {value:.15g} s" for name, value in self.times]
        yield f"tissue {FREE} like {tissue} {{ {'; '.join(free)} }}"
        yield f"body {BODY} {{"
        yield f"  mesh is lattice {{ cell = {SIDE} m; box from (0, 0, 0) m to ({SIDE}, {SIDE}, "
        yield f"  {SIDE}) m }}; tissue is {FREE}"
        if self.has_fibres:
            yield "  fibres = (1, 0, 0)"
        if rupture:
            yield "  rupture is allowed"
        yield "}"

    def faces(self, *names: str) -> Iterator[str]:
        """Yield sets for the nodes of faces: "x1" at the largest x, "y0" at the least y."""
        for name in names:
            sign = "<" if name[1] == "0" else ">"
            yield f"set lab {name} = nodes of {BODY} where {name[0]} {sign} {0.5 * SIDE} m"


def axes_of(mode: str) -> tuple[int, ...]:
    """Return the numbers of the axes along which a stress acts in a mode."""
    return {EQUIBIAXIAL: (0, 1), ACROSS: (1,)}.get(mode, (0,))


def loads(axes: Sequence[int], stresses: Sequence[float]) -> Iterator[str]:
    """Yield orders that apply one stress [Pa] after the other to a cube, one at each tick."""
    before = 0.0
    for number, stress in enumerate(stresses):
        force = (stress - before) * SIDE**2
        before = stress
        for axis in axes:
            way = ", ".join(f"{force if one == axis else 0.0:.15g}" for one in range(3))
            yield f"at {number} {TICK}: push lab {AXES[axis]}1 with ({way}) N"
        yield f"at {number} {TICK}: settle"


def shears(amounts: Sequence[float]) -> Iterator[str]:
    """Yield orders that shear a cube along x by one amount after the other, at odd ticks."""
    yield "at 0 s: fix lab y0"
    before = 0.0
    for number, amount in enumerate(amounts):
        by, before = (amount - before) * SIDE, amount
        yield (
            f"from {2 * number} {TICK} to {2 * number + 1} {TICK}: "
            f"move lab y1 by ({by:.15g}, 0, 0) m using constant speed"
        )
