"""The compiled network: read-only arrays, each of which can name the line it came from.

Nodes and springs stand in the order of the scene and keep their numbers for good; the engine
may renumber inside, never visibly. The signed incidence matrix of the paper is the pair of
columns ``ends``: row ``s`` has -1 at ``ends[s, 0]`` and +1 at ``ends[s, 1]``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.laws import Law
from tissuec.laws.evaluation import Behaviour

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Origin:
    """Why an entry of an array has its value."""

    span: Span
    how: str  # such as "rules", "written", "otherwise", "table", "drawn length"


@dataclass(frozen=True, slots=True, eq=False)
class Provenance:
    """The origin of every entry of one array, shape of ``index`` (entry,)."""

    index: NDArray[np.int32]
    origins: tuple[Origin, ...]

    def __getitem__(self, entry: int) -> Origin:
        return self.origins[self.index[entry]]


class Grid(NamedTuple):
    """Nodes in rows and columns, numbered row by row.

    The skin of a grid has two triangles to a cell, cell by cell in the same order: of the
    corners (0, 0), (0, 1), (1, 1) and of (0, 0), (1, 1), (1, 0), as (row, column).
    """

    rows: int
    columns: int
    closed: bool  # whether the last column is followed by the first


@dataclass(frozen=True, slots=True)
class BodyPart:
    """Where the nodes and springs of a body stand in the arrays, and its grid if it has one."""

    name: str
    nodes: slice
    springs: slice
    span: Span
    grid: Grid | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """All mass points and springs of a scene, in SI units.

    Attributes:
        position: Drawn positions [m], shape (node, 3).
        velocity: Initial velocities [m/s], shape (node, 3).
        mass: Masses [kg], shape (node,); positive.
        ends: Node pair of each spring, shape (spring, 2).
        stiffness: Spring constants c [N/m], shape (spring,).
        damping: Viscosities d [N s/m], shape (spring,).
        rest: Rest lengths L0 [m], shape (spring,).
        strength: Fraction forces [N], shape (spring,); infinite where nothing may rupture.
        law: Law of each spring as a number among ``laws``, shape (spring,).
        laws: The laws of springs and dashpots; the first is the linear one.
        skin: Triangles of the bodies' surfaces, for viewers, shape (triangle, 3).
        node_ids: Ids of the author (table ids, or the number within the body), shape (node,).
        spring_ids: The same for springs, shape (spring,).
        bodies: The parts of the arrays that belong to each body.
        provenance: Origins by array name ("mass", "stiffness", …).
    """

    position: Floats
    velocity: Floats
    mass: Floats
    ends: NDArray[np.int32]
    stiffness: Floats
    damping: Floats
    rest: Floats
    strength: Floats
    law: NDArray[np.int32]
    laws: tuple[Law, ...]
    skin: NDArray[np.int32]
    node_ids: Indices
    spring_ids: Indices
    bodies: tuple[BodyPart, ...]
    provenance: Mapping[str, Provenance]

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def node_count(self) -> int:
        return len(self.position)

    @property
    def spring_count(self) -> int:
        return len(self.ends)

    def behaviour(self) -> Behaviour:
        """Return what the springs do at the start of a run."""
        return Behaviour(self.laws, self.law, self.stiffness, self.damping, self.rest)

    @property
    def extent(self) -> float:
        """Return the largest side of the bounding box of the drawing [m]; 0 without nodes."""
        return float(np.ptp(self.position, axis=0).max()) if len(self.position) else 0.0
