"""Smooth surfaces over the coarse skins of bodies: a member is one way to draw them.

Every member is a linear map from the nodes of a body to the points of its surface, which
depends on which springs are there and not on where the nodes are. It is therefore made once for
each topology, and applied to all frames at once.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, cast

from msgspec import Struct
from msgspec.structs import asdict

from tissuec.core.registry import Family
from tissuec.geometry.surfaces.skin import Refinement, Skin

MOST_POINTS = 2_000_000
"""Points of one surface: 48 MB in each frame, and up to 2 GB while the map is made."""


class Smoothing(Protocol):
    """Interface of members of ``SURFACES``; their fields are entries in the language.

    Attributes:
        needs_grid: Whether it is for nodes in rows and columns only.
        subdivisions: How often every edge of the skin is halved.
    """

    __struct_fields__: ClassVar[tuple[str, ...]]
    needs_grid: ClassVar[bool]

    def __init__(self, *, subdivisions: int = ...) -> None: ...

    @property
    def subdivisions(self) -> int: ...

    def refine(self, skin: Skin) -> Refinement:
        """Return the map from the nodes of a skin to its smooth surface."""
        ...


SURFACES: Family[type[Smoothing]] = Family("tissuec.geometry.surfaces", "surface")

ON_GRIDS, ELSEWHERE = "interpolating spline", "loop subdivision"
"""What is drawn where a scene names none: on nodes in rows and columns, and on all others."""


def entries_of(smoothing: Smoothing) -> Mapping[str, Any]:
    """Return the entries that a smoothing was made with, to make the same again."""
    return asdict(cast(Struct, smoothing))
