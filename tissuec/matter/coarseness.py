"""How much too stiff its cells make a solid in bending and torsion.

Both are compared along the longest principal axis x of the body, with y and z across. The net
is loaded, free in space, by the forces of a continuum whose displacement u is known exactly:
σ N at nodes of the boundary and -V div σ at all nodes. If the continuum stores E, and the
forces do the work f · u on it, it would store ½ (f · u)² / 2E under these forces, which are
those of a stress at points. The net stores ½ f · u', and is as many times as stiff as the
former energy is the latter.

- Bending: σ_xx = y or z, which is exact in a body of any shape.
- Torsion: u = (w(y, z), -x z, x y) with the warping w that stores least, as in a bar with free
  sides (S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, 1951, § 90), among polynomials
  of degree 4. In a square section, these store 0.1 % more than the exact warping.

The elastic constants of the continuum are those that uniform strains find in the net (see
``elasticity``), so that the ratios are due to its cells alone. They tend to 1 with the square
of the cells.
"""

from itertools import permutations
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from msgspec import Struct
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from tissuec.matter.elasticity import VOIGT
from tissuec.matter.linear import elongations, solution, stiffness, with_cells
from tissuec.matter.solid import Solid
from tissuec.model.network import Floats

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

DEGREE = 4  # of warping
#: Powers of y and z of the terms of warping, without the constant.
_POWERS = [(a, d - a) for d in range(1, DEGREE + 1) for a in range(d + 1)]
_ORDER = 2 * (DEGREE - 1)  # of what is integrated
_SYMMETRIC = 1e-6  # of all moments: products of inertia below are rounding
_FLOPPY = 1e-3  # ratio of a net that gives way, whose equations have no solution
_SAME = 1e-10  # terms of warping that do not differ in a section


class Coarseness(Struct, frozen=True):
    """Stiffness of a solid net over that of a continuum with its elastic constants.

    Attributes:
        bending: In the transverse direction in which it is larger.
        torsion: About the longest axis; 0 if nothing resists.
    """

    bending: float
    torsion: float


def coarseness(
    position: Floats,
    ends: NDArray[np.int32],
    constant: Floats,
    cells: "csr_matrix | None",
    solid: Solid,
    skin: NDArray[np.int32],
    matrix: Floats,
) -> Coarseness:
    """Return how much too stiff a solid is in bending and torsion.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        constant: dT/dL of each spring [N/m], shape (spring,).
        cells: √(K/V) ∂V/∂x of cells that keep their volume [(N/m)^½], shape (3 node, cell).
        solid: The solid that the nodes represent.
        skin: Triangles that face outwards, shape (triangle, 3).
        matrix: C in Voigt's order [Pa], shape (6, 6).
    """
    body = _Body.of(position, solid, skin, matrix)
    loads = [_bending(body, 1), _bending(body, 2), _torsion(body)]
    force = _in_balance(body.x, np.stack([load.force.ravel() for load in loads], axis=1))
    turned = None if cells is None else _turned(cells, body.axes)
    rows, constant = with_cells(elongations(body.x, ends), constant, turned)
    moved = solution(stiffness(rows, constant / body.size), force)
    found = [
        load.work**2 / load.energy / float(f @ u)
        for load, f, u in zip(loads, force.T, moved.T, strict=True)
    ]
    ratios = [one if one > _FLOPPY else 0.0 for one in found]
    return Coarseness(max(ratios[:2]), ratios[2])


def principal_axes(second: Floats) -> Floats:
    """Return the principal axes of a body as columns, the longest first, shape (3, 3).

    Those of a body that is as wide as thick stay along x, y and z as far as they can.

    Args:
        second: ∫ x x dV [m⁵] or a like sum, shape (3, 3).
    """
    second = np.where(np.abs(second) < _SYMMETRIC * np.trace(second), 0.0, second)
    axes = np.linalg.eigh(second)[1][:, ::-1]
    return np.asarray(axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))]))


class _Body(NamedTuple):
    """A body in its own principal axes, in units of its size.

    Attributes:
        size: [m].
        axes: Principal axes as columns, the longest first, shape (3, 3).
        x: Of nodes from the centre, shape (node, 3).
        outward, volume: As of ``Solid``.
        moments: ∫ y^a z^b dV, shape (_ORDER + 1, _ORDER + 1).
        law: C in Voigt's order [Pa], shape (6, 6).
    """

    size: float
    axes: Floats
    x: Floats
    outward: Floats
    volume: Floats
    moments: Floats
    law: Floats

    @classmethod
    def of(
        cls, position: Floats, solid: Solid, skin: NDArray[np.int32], matrix: Floats
    ) -> Self:
        """Return a body; arguments as of ``coarseness``."""
        size = float(solid.volume.sum()) ** (1.0 / 3.0)
        x, outward = (position - solid.middle) / size, solid.outward / size**2
        points, weight = _within(x[skin])
        second = points.T @ (weight[:, None] * points) / 5.0
        axes = principal_axes(second)
        y, z = (np.vander(points @ axes[:, k], _ORDER + 1, increasing=True) for k in (1, 2))
        degree = np.add.outer(np.arange(_ORDER + 1), np.arange(_ORDER + 1))
        moments = (weight[:, None] * y).T @ z / (3.0 + degree)
        tensor = np.zeros((3, 3, 3, 3))
        for row, one in zip(matrix, VOIGT, strict=True):
            for value, other in zip(row, VOIGT, strict=True):
                for i, j in permutations(one):
                    for k, m in permutations(other):
                        tensor[i, j, k, m] = value
        turned = np.einsum("ijkm,ia,jb,kc,md->abcd", tensor, axes, axes, axes, axes)
        law = np.array([[turned[(*one, *other)] for other in VOIGT] for one in VOIGT])
        return cls(size, axes, x @ axes, outward @ axes, solid.volume / size**3, moments, law)


class _Load(NamedTuple):
    """Forces on nodes, shape (node, 3), their work on the continuum, and twice its energy."""

    force: Floats
    work: float
    energy: float


def _bending(body: _Body, across: int) -> _Load:
    """Return the load of σ_xx = y (``across`` is 1) or z (2)."""
    force = np.zeros_like(body.x)
    force[:, 0] = body.outward[:, 0] * body.x[:, across]
    soft = float(np.linalg.inv(body.law)[0, 0])
    second = body.moments[2, 0] if across == 1 else body.moments[0, 2]
    work = soft * float(force[:, 0] @ (body.x[:, 0] * body.x[:, across]))
    return _Load(force, work, soft * float(second))


def _torsion(body: _Body) -> _Load:
    """Return the load of a twist of 1 with the warping that stores least."""
    slopes, terms = _slopes()
    shear = body.law[np.ix_([5, 4], [5, 4])]  # of xy and xz
    both = np.add.outer(np.arange(DEGREE), np.arange(DEGREE))  # powers of a product
    moments = body.moments[both[:, None, :, None], both[None, :, None]]
    stored: Floats = np.einsum(
        "piab,ij,qjcd,abcd->pq", slopes, shear, slopes, moments, optimize=True
    )
    share = np.ones(len(slopes))
    share[1:] = -np.linalg.pinv(stored[1:, 1:], _SAME, hermitian=True) @ stored[1:, 0]
    # Changes of angles as polynomials: of xy and xz, shape (2, DEGREE, DEGREE).
    angle = np.einsum("p,piab->iab", share, slopes)
    power = np.arange(1, DEGREE)
    along_y, along_z = angle[:, 1:] * power[:, None], angle[:, :, 1:] * power
    x, y, z = body.x.T
    force = np.einsum("nij,nj->ni", _stresses(body.law, angle, y, z), body.outward)
    inside = _stresses(body.law, along_y, y, z)[:, :, 1]
    inside += _stresses(body.law, along_z, y, z)[:, :, 2]
    force -= body.volume[:, None] * inside
    (warping,) = _values(np.einsum("p,pab->ab", share[1:], terms)[None], y, z)
    work = float(np.sum(force * np.stack([warping, -x * z, x * y], axis=1)))
    return _Load(force, work, float(share @ stored @ share))


def _slopes() -> tuple[Floats, Floats]:
    """Return changes of the angles xy and xz in a twist, and terms of warping.

    Returns:
        Coefficients of powers of y and z: of angles by the twist alone and by each term, shape
        (1 + term, 2, DEGREE, DEGREE); and of terms, shape (term, DEGREE + 1, DEGREE + 1).
    """
    slopes = np.zeros((1 + len(_POWERS), 2, DEGREE, DEGREE))
    slopes[0, 0, 0, 1], slopes[0, 1, 1, 0] = -1.0, 1.0
    terms = np.zeros((len(_POWERS), DEGREE + 1, DEGREE + 1))
    for number, (a, b) in enumerate(_POWERS):
        terms[number, a, b] = 1.0
        if a:
            slopes[1 + number, 0, a - 1, b] = a
        if b:
            slopes[1 + number, 1, a, b - 1] = b
    return slopes, terms


def _values(polynomials: Floats, y: Floats, z: Floats) -> Floats:
    """Return values of polynomials, shape (polynomial, node).

    Args:
        polynomials: Coefficients of y^a z^b, shape (polynomial, a, b).
        y, z: Of each node, shape (node,).
    """
    powers = (
        np.vander(one, count, increasing=True)
        for one, count in zip((y, z), polynomials.shape[1:], strict=True)
    )
    return np.asarray(np.einsum("pab,na,nb->pn", polynomials, *powers, optimize=True))


def _stresses(law: Floats, angle: Floats, y: Floats, z: Floats) -> Floats:
    """Return stresses [Pa] at nodes, shape (node, 3, 3).

    Args:
        law: C in Voigt's order [Pa], shape (6, 6).
        angle: Changes of the angles xy and xz as polynomials, shape (2, a, b).
        y, z: Of each node, shape (node,).
    """
    each = law[:, [5, 4]] @ _values(angle, y, z)
    found = np.zeros((len(y), 3, 3))
    for (i, j), one in zip(VOIGT, each, strict=True):
        found[:, i, j] = found[:, j, i] = one
    return found


def _within(corners: Floats) -> tuple[Floats, Floats]:
    """Return points on a closed skin, and weights that integrate within it.

    A polynomial of degree d without lower terms, integrated from the origin to a triangle, is
    the mean over the triangle times three times the volume of that pyramid over d + 3.

    Args:
        corners: Of triangles, shape (triangle, 3, 3).

    Returns:
        Shapes (point, 3) and (point,).
    """
    node, share = leggauss(_ORDER // 2 + 1)
    node, share = 0.5 + 0.5 * node, 0.5 * share
    first, second = (one.ravel() for one in np.meshgrid(node, node, indexing="ij"))
    weight = 2.0 * np.outer(share * (1.0 - node), share).ravel()
    second = second * (1.0 - first)
    points = np.einsum(
        "pk,tki->tpi", np.stack([1.0 - first - second, first, second], axis=1), corners
    )
    pyramid = np.linalg.det(corners) / 2.0
    return points.reshape(-1, 3), np.outer(pyramid, weight).ravel()


def _in_balance(x: Floats, force: Floats) -> Floats:
    """Return forces without resultant and moment, shape (3 node, load)."""
    turned = np.cross(np.eye(3)[:, None], x)
    rigid = np.concatenate([np.broadcast_to(np.eye(3)[:, None], turned.shape), turned])
    basis, _ = np.linalg.qr(rigid.reshape(6, -1).T)
    return np.asarray(force - basis @ (basis.T @ force))


def _turned(cells: "csr_matrix", axes: Floats) -> "csr_matrix":
    """Return cells for node coordinates along other axes, shape (3 node, cell)."""
    from scipy.sparse import csr_matrix, eye, kron

    return csr_matrix(kron(eye(cells.shape[0] // 3), axes.T) @ cells)  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
