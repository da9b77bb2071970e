"""Elastic constants of a given net.

A body is stretched evenly by ε: the nodes of its boundary go by ε x, and those inside go to
where they are in balance, by one linear system. What its springs store is then ½ V ε : C : ε,
which gives the stiffness C. It bounds that of a body with a free boundary from above, and is
exact if an even strain leaves all nodes in balance, as in a net that passes the patch test.
(R. Hill, J. Mech. Phys. Solids 11:357, 1963; C. Huet, J. Mech. Phys. Solids 38:813, 1990.)

A wall is stretched in its own plane, which turns with it, each spring half by the directions at
either end; a tube is widened, drawn out and twisted, with the springs through its inside. Nodes
inside a rim are relaxed within the wall if it is a grid or flat; elsewhere even strains do not
fit together.

Strains are in Voigt's order xx, yy, zz, yz, zx, xy, shear strains being changes of angles.
"""

from typing import TYPE_CHECKING, Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import unknowns
from tissuec.geometry.edges import Edges
from tissuec.matter.linear import elongations, solution, stiffness, with_cells
from tissuec.model.network import Floats, Grid

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Pairs = NDArray[np.int32]
Unit = Literal["Pa", "N/m", "N"]
VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))
IN_PLANE = ((0, 0), (1, 1), (0, 1))  # the same of two dimensions
NONE = 1e-6  # of the largest: what is less stiff gives way
_FLAT = 1e-6  # sine of an angle between normals that is rounding
_SAMPLES = 400  # directions in which Young's modulus is compared


class Elasticity(Struct, frozen=True):
    """Young's modulus and what belongs to it.

    Attributes:
        unit: "Pa"; or, of a wall without a thickness, "N/m": all is multiplied by its
            thickness; or, of bars without a section, "N": by their section.
        directions: Those of ``young``: "x", "y", "z" in a solid; "around" and "along" in a
            tube; "first edge" and "second edge" in a sheet; the longest side of its bounding
            box and "across" it in other walls; "along" bars, or the "least" and the "largest"
            value of all bars.
        young: Young's modulus in each direction [unit].
        shear: Shear modulus in yz, zx and xy of a solid, or of a wall; none of bars [unit].
        poisson: Mean Poisson's ratio; None of bars and of what gives way.
        anisotropy: The largest over the least Young's modulus of all directions; infinite if
            nothing resists in one of them, None of bars.
        matrix: C in Voigt's order, 6 x 6 of a solid, 3 x 3 of a wall (first direction, second
            one, shear) [unit]; none of bars.
    """

    unit: Unit
    directions: tuple[str, ...]
    young: tuple[float, ...]
    shear: tuple[float, ...] = ()
    poisson: float | None = None
    anisotropy: float | None = None
    matrix: tuple[tuple[float, ...], ...] = ()

    @property
    def mean(self) -> float:
        """Return the mean Young's modulus of the directions [unit]."""
        return sum(self.young) / len(self.young)


def of_solid(
    position: Floats,
    ends: Pairs,
    constant: Floats,
    cells: "csr_matrix | None",
    boundary: NDArray[np.integer],
    volume: float,
) -> Elasticity:
    """Return the elastic constants of a solid.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        constant: dT/dL of each spring [N/m], shape (spring,).
        cells: √(K/V) ∂V/∂x of cells that keep their volume [(N/m)^½], shape (3 node, cell).
        boundary: Nodes of its surface.
        volume: Of the body [m³].
    """
    rows, constant = with_cells(elongations(position, ends), constant, cells)
    even = rows @ np.stack([_evenly(position, *pair) for pair in VOIGT], axis=1)
    inside = np.ones(len(position), dtype=bool)
    inside[boundary] = False
    free = unknowns(np.flatnonzero(inside))
    return _constants(_relaxed(rows[:, free], constant, even) / volume, "Pa", ("x", "y", "z"))


def of_wall(
    position: Floats,
    ends: Pairs,
    constant: Floats,
    skin: NDArray[np.integer],
    grid: Grid | None,
    thickness: float | None,
) -> Elasticity:
    """Return the elastic constants of a wall.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring of the wall, of a tube also through its inside, shape
            (spring, 2).
        constant: dT/dL of each spring [N/m], shape (spring,).
        skin: Triangles of the wall, shape (triangle, 3).
        grid: Arrangement of the nodes in rows and columns, if there is one.
        thickness: [m]; None if it has none.
    """
    normal, area = _normals(position, skin)
    directions, first = _first_direction(position, grid)
    frame = _frames(normal, first)
    if grid is not None and grid.closed:
        even = elongations(position, ends) @ evenly_as_tube(position, grid)
    else:
        ends, constant = _from_both_ends(ends, constant)
        even = _even_in_wall(position, ends, normal, frame[:, 0])
    rows = _within(position, ends, frame)
    free = np.zeros(0, dtype=np.int64)
    if grid is not None or np.abs(np.cross(normal, normal[skin[0, 0]])).max() < _FLAT:
        edges = Edges.among(skin.astype(np.int64))
        inner = np.setdiff1d(np.unique(skin), edges.ends[edges.count == 1])
        free = (2 * inner[:, None] + np.arange(2)).ravel()
    across = 1.0 if thickness is None else thickness
    matrix = _relaxed(rows[:, free], constant, even) / (area * across)
    return _constants(matrix, "N/m" if thickness is None else "Pa", directions)


def of_space(young: float, poisson: float, more: Floats) -> Elasticity:
    """Return the elastic constants of a solid of isotropic matter.

    Args:
        young: Young's modulus [Pa].
        poisson: Poisson's ratio.
        more: Stiffness that fibres add, in Voigt's order [Pa], shape (6, 6) or ().
    """
    shear = 0.5 * young / (1.0 + poisson)
    matrix = np.diag([2.0 * shear] * 3 + [shear] * 3)
    matrix[:3, :3] += 2.0 * shear * poisson / (1.0 - 2.0 * poisson)
    return _constants(matrix + more, "Pa", ("x", "y", "z"))


def of_plane_stress(
    young: float, poisson: float, position: Floats, grid: Grid | None, more: Floats
) -> Elasticity:
    """Return the elastic constants of a wall of isotropic matter.

    Args:
        young: Young's modulus [Pa].
        poisson: Poisson's ratio.
        position: Of its nodes [m], shape (node, 3).
        grid: Arrangement of these in rows and columns, if any.
        more: Stiffness that fibres add, in Voigt's order [Pa], shape (3, 3) or ().
    """
    directions, _ = _first_direction(position, grid)
    matrix = np.diag([1.0, 1.0, 0.5 * (1.0 - poisson)])
    matrix[0, 1] = matrix[1, 0] = poisson
    return _constants(young / (1.0 - poisson**2) * matrix + more, "Pa", directions)


def frames_of_triangles(
    position: Floats, corners: NDArray[np.integer], grid: Grid | None
) -> Floats:
    """Return the directions of ``Elasticity.directions`` in triangles, shape (triangle, 2, 3).

    Args:
        position: Of the nodes of a wall [m], shape (node, 3).
        corners: Of its triangles, shape (triangle, 3).
        grid: Arrangement of the nodes in rows and columns, if there is one.
    """
    corner = position[corners]
    sides = corner[:, 1:] - corner[:, :1]
    first = _first_direction(position, grid)[1][corners].mean(axis=1)
    return _frames(_unit(np.cross(sides[:, 0], sides[:, 1])), first)


def wall_springs(skin: NDArray[np.integer], ends: Pairs) -> NDArray[np.bool_]:
    """Return which springs lie in a surface, as sides or diagonals of faces, shape (spring,).

    Args:
        skin: Triangles, shape (triangle, 3).
        ends: Node pair of each spring, shape (spring, 2).
    """
    edges = Edges.among(skin.astype(np.int64))
    one, other, _ = edges.pairs
    shared = edges.ends[edges.count == 2].sum(axis=1)
    diagonals = np.stack([edges.triangles[t].sum(axis=1) - shared for t in (one, other)], 1)
    size = int(max(skin.max(initial=0), ends.max(initial=0))) + 1
    known, asked = (
        np.sort(pairs.astype(np.int64), axis=1) @ np.array([size, 1])
        for pairs in (np.concatenate([edges.ends, diagonals]), ends)
    )
    return np.isin(asked, known)


# --- even strains -----------------------------------------------------------------------------


def _evenly(position: Floats, one: int, other: int) -> Floats:
    """Return displacements ε x under a unit strain [m], shape (3 node,)."""
    strain = np.zeros((3, 3))
    strain[one, other] += 0.5
    strain[other, one] += 0.5
    return (position @ strain).ravel()


def evenly_as_tube(position: Floats, grid: Grid) -> Floats:
    """Return displacements of a tube that is widened, drawn out and twisted by a unit strain.

    Returns:
        [m], shape (3 node, 3).
    """
    rings = position.reshape(grid.rows, grid.columns, 3)
    axis = _unit(rings[-1].mean(axis=0) - rings[0].mean(axis=0))
    outward = (rings - rings.mean(axis=1, keepdims=True)).reshape(-1, 3)
    along = (position @ axis)[:, None]
    turned = along * np.cross(axis, _unit(outward))
    return np.stack([one.ravel() for one in (outward, along * axis, turned)], axis=1)


def _relaxed(rows: "csr_matrix", constant: Floats, even: Floats) -> Floats:
    """Return the common energy of two even strains after unknowns are balanced [J].

    Args:
        rows: From unknowns to elongations, shape (spring, unknown).
        constant: [N/m], shape (spring,).
        even: Elongations under even strains, shape (spring, strain).

    Returns:
        Shape (strain, strain).
    """
    pulled = constant[:, None] * even
    stored = even.T @ pulled
    if rows.shape[1]:  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
        matrix, force = stiffness(rows, constant), -(rows.T @ pulled)
        stored = stored - force.T @ solution(matrix, force)
    return 0.5 * (stored + stored.T)


def _normals(position: Floats, skin: NDArray[np.integer]) -> tuple[Floats, float]:
    """Return the normal of a surface at each node, shape (node, 3), and its area [m²]."""
    a, b, c = position[skin].swapaxes(0, 1)
    double = np.cross(b - a, c - a)
    total = np.zeros_like(position)
    for corner in skin.T:
        np.add.at(total, corner, double)
    return _unit(total), 0.5 * float(np.linalg.norm(double, axis=1).sum())


def _first_direction(position: Floats, grid: Grid | None) -> tuple[tuple[str, str], Floats]:
    """Return how directions in a wall are called, and about the first one, shape (node, 3)."""
    if grid is None:
        longest = int(np.argmax(np.ptp(position, axis=0)))
        names = ("xyz"[longest], f"across {'xyz'[longest]}")
        return names, np.broadcast_to(np.eye(3)[longest], position.shape)
    rows = position.reshape(grid.rows, grid.columns, 3)
    if grid.closed:
        steps = np.roll(rows, -1, axis=1) - np.roll(rows, 1, axis=1)
        return ("around", "along"), steps.reshape(-1, 3)
    return ("first edge", "second edge"), np.asarray(np.gradient(rows, axis=1)).reshape(-1, 3)


def _from_both_ends(ends: Pairs, constant: Floats) -> tuple[Pairs, Floats]:
    """Return each spring twice, from either end, with half of its constant."""
    return np.concatenate([ends, ends[:, ::-1]]), np.tile(0.5 * constant, 2)


def _frames(normal: Floats, first: Floats) -> Floats:
    """Return two directions in a wall at right angles, shape (…, 2, 3)."""
    along = first - np.einsum("...i,...i->...", first, normal)[..., None] * normal
    lost = np.linalg.norm(along, axis=-1) < NONE * np.linalg.norm(first, axis=-1)
    if lost.any():  # where a direction is that of the normal, any other will do
        beside = np.eye(3)[np.argmin(np.abs(normal[lost]), axis=-1)]
        along[lost] = np.cross(normal[lost], beside)
    along = _unit(along)
    return np.stack([along, np.cross(normal, along)], axis=-2)


def _even_in_wall(position: Floats, ends: Pairs, normal: Floats, first: Floats) -> Floats:
    """Return elongations under unit strains along both directions of a wall, and in shear.

    Args:
        ends: Of springs; the directions are those at the first end, shape (spring, 2).
        normal: Of the wall at each node, shape (node, 3).
        first: The first direction at each node, shape (node, 3).

    Returns:
        [m], shape (spring, 3).
    """
    along = position[ends[:, 1]] - position[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    # Springs are chords, which lie in a curved wall halfway.
    halfway = _frames(_unit(normal[ends].sum(axis=1)), first[ends[:, 0]])
    u, v = _unit(np.einsum("si,sdi->sd", along, halfway)).T
    return length[:, None] * np.stack([u * u, v * v, u * v], axis=1)


def _within(position: Floats, ends: Pairs, frame: Floats) -> "csr_matrix":
    """Return the matrix from displacements within a wall to elongations, (spring, 2 node)."""
    from scipy.sparse import block_diag, csr_matrix

    along = block_diag([one.T for one in frame], format="csr")
    return csr_matrix(elongations(position, ends) @ along)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


# --- constants --------------------------------------------------------------------------------


def _constants(matrix: Floats, unit: Unit, directions: tuple[str, ...]) -> Elasticity:
    """Return the moduli of a stiffness in Voigt's order."""
    compliance, count = _compliance(matrix), len(directions)
    moduli = _resisting(1.0 / np.diag(compliance), matrix)
    young, shear, tried = moduli[:count], moduli[count:], young_around(matrix)
    poisson = anisotropy = None
    if tried.max() > 0.0:
        anisotropy = float(tried.max() / tried.min()) if tried.min() else float("inf")
    if young.all():
        ratios = -compliance[:count, :count] * young[:, None]
        poisson = float(ratios[~np.eye(count, dtype=bool)].mean())
    return Elasticity(
        unit, directions, tuple(young.tolist()), tuple(shear.tolist()), poisson, anisotropy,
        tuple(map(tuple, matrix.tolist())),
    )  # fmt: skip


def _compliance(matrix: Floats) -> Floats:
    """Return the inverse of a stiffness; what does not resist is very soft."""
    values, vectors = np.linalg.eigh(matrix)
    least = NONE * NONE * max(float(values[-1]), 1e-300)
    return np.asarray((vectors / np.maximum(values, least)) @ vectors.T)


def _resisting(moduli: Floats, matrix: Floats) -> Floats:
    """Return moduli with 0 for those that are rounding."""
    return np.where(moduli > NONE * np.abs(matrix).max(), moduli, 0.0)


def young_around(matrix: Floats) -> Floats:
    """Return Young's modulus in many directions, in the unit of C, shape (direction,).

    Args:
        matrix: Stiffness C in Voigt's order, shape (3, 3) or (6, 6).
    """
    if len(matrix) == 3:
        angle = np.linspace(0.0, np.pi, _SAMPLES)
        n = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        pairs: tuple[tuple[int, int], ...] = IN_PLANE
    else:
        n, pairs = _around(), VOIGT
    stress = np.stack([n[:, i] * n[:, j] for i, j in pairs], axis=1)
    strain = np.einsum("ni,ij,nj->n", stress, _compliance(matrix), stress)
    return _resisting(1.0 / strain, matrix)


def _around() -> Floats:
    """Return directions in space: axes and diagonals of a cube, and others on a spiral."""
    k = np.arange(_SAMPLES) + 0.5
    height, turn = 1.0 - 2.0 * k / _SAMPLES, np.pi * (1.0 + 5.0**0.5) * k
    ring = np.sqrt(1.0 - height**2)
    spiral = np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    cube = np.indices((3, 3, 3), dtype=np.float64).reshape(3, -1).T - 1.0
    return np.concatenate([_unit(cube[np.any(cube, axis=1)]), spiral])
