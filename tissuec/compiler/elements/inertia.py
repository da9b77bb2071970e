"""Node masses that give a solid the moments of inertia of the drawn body.

Masses m that are lumped at the nodes of elements have the mass and the centre of mass of the
body, but second moments Σ m x ⊗ x that are too large: in a bar of n hexahedra across, that
about its axis by the factor 1 + 2/n². The masses

    M = m exp p(x)

with a polynomial p of the second degree have all moments up to the second of the density. Of
all masses that do, they differ least from m by the relative entropy Σ M ln(M/m), and they are
positive; the ten coefficients c minimise the convex function Σ m exp p - c·T, T being the
integrals of the density times the monomials (E. T. Jaynes, Phys. Rev. 106:620, 1957). Where
there is one cell across, x² is the same at all nodes and its mean cannot be changed:
polynomials that would have to change masses very much are left out. Light corners shorten
stable steps, so each node keeps at least half of m: with two or three cells across in each
direction, only part of the correction is made.

Where a body ends at a plane of symmetry, p is even about it, as that of the whole is.
"""

from collections.abc import Sequence
from typing import cast

import numpy as np

from tissuec.geometry.elements import CUBE_27  # which determine a polynomial of degree 2
from tissuec.geometry.moments import SolidMoments, moments
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Floats
from tissuec.model.topology import pieces
from tissuec.script.verbs.cut_surface import Blade

ON_PLANE = 1e-6  # of the size of a piece: a node this close to a plane is on it
MOST = 1.0  # largest root mean square that one polynomial may add to p
LEAST = 0.5  # of a lumped mass that remains; 4 x 4 x 4 cells leave 0.57 at their corners
_PARTS = 1.0, 0.75, 0.5, 0.25  # of the correction, tried until no mass falls below LEAST
_ROUNDING = 1e-9  # of the mean square of a polynomial
#: Of Newton's method: how many steps, the largest one and the last one, as mean squares of p.
_STEPS, _LARGEST, _LAST = 50, 0.25, 1e-26
_PAIRS = np.array([0, 1, 2, 1, 2, 0]), np.array([0, 1, 2, 2, 0, 1])


def turning_masses(
    mesh: Mesh, density: Floats, lumped: Floats, planes: Sequence[Blade] = ()
) -> Floats:
    """Return masses that have the second moments of a solid [kg], shape (node,).

    Args:
        mesh: Whose elements are solid.
        density: Of its elements, shape by shape [kg/m³], shape (element,).
        lumped: Mass of each node; together they have the mass and the centre of mass of the
            elements [kg], shape (node,).
        planes: Of symmetry.
    """
    piece, middle = pieces(len(lumped), mesh.ends), mesh.position.mean(axis=0)
    position = mesh.position - middle
    each = [moments(one.shape, position[one.nodes]) for one in mesh.elements]
    every = SolidMoments(*(np.concatenate(parts) for parts in zip(*each, strict=True)))
    of_element = np.concatenate([piece[one.nodes[:, 0]] for one in mesh.elements])
    mirrors = [(one.origin - middle, one.normal) for one in planes]
    found = lumped.copy()
    for number in range(int(piece.max(initial=-1)) + 1):
        nodes = np.flatnonzero((piece == number) & (lumped > 0.0))
        if len(nodes):
            due = every.total(np.where(of_element == number, density, 0.0))
            found[nodes] *= _Piece(position[nodes], lumped[nodes], due).factors(mirrors)
    return found


class _Piece:
    """The masses of a connected piece, as parts of all, in coordinates without a unit.

    Args:
        position: [m], shape (node, 3).
        lumped: Masses of nodes [kg], shape (node,).
        due: The moments that they should have, shapes (1,), (1, 3) and (1, 3, 3).
    """

    def __init__(self, position: Floats, lumped: Floats, due: SolidMoments):
        total = lumped.sum()
        self.share = lumped / total
        self.centre = self.share @ position
        places = position - self.centre
        spread, ways = np.linalg.eigh(places.T @ (self.share[:, None] * places))
        self.size = float(np.sqrt(spread[-1]))
        self.outward, self.inward = ways * np.sqrt(spread), (ways / np.sqrt(spread)).T
        self.places = places @ self.inward.T
        self.monomials = _monomials(self.places)
        volume, first, second = (each[0] / total for each in due.shifted(-self.centre[None]))
        second = self.inward @ second @ self.inward.T
        integrals = np.concatenate([[volume], self.inward @ first, second[_PAIRS]])
        self.short = integrals - self.share @ self.monomials

    def factors(self, planes: Sequence[tuple[Floats, Floats]]) -> Floats:
        """Return exp p at each node, dimensionless, shape (node,); 1 where there is none.

        Args:
            planes: Of symmetry: a point [m] and the unit normal of each, shape (3,).
        """
        mirrored = [self._mirrored(*one) for one in planes]
        images = [one for one in mirrored if one is not None]
        linear = self._orthonormal(_even(images, 4))
        gram = self.monomials.T @ (self.share[:, None] * self.monomials)
        square = _even(images, 10)
        square = self._orthonormal(square - linear @ (linear.T @ gram @ square))
        square = square[:, np.abs(self.short @ square) <= MOST]
        ways = np.concatenate([linear, square], axis=1)
        values, due = self.monomials @ ways, self.short @ ways
        for part in _PARTS:
            found = self._solved(values, part * due)
            if found is not None and found.min() >= LEAST:
                return found
        return np.ones(len(values))

    def _mirrored(self, point: Floats, normal: Floats) -> Floats | None:
        """Return the mirror image of ``CUBE_27``; None if no node is on the plane."""
        along, away = self.outward.T @ normal, float((point - self.centre) @ normal)
        if np.abs(self.places @ along - away).min() > ON_PLANE * self.size:
            return None
        ahead = CUBE_27 @ along - away
        return CUBE_27 - 2.0 * ahead[:, None] * (self.inward @ normal)

    def _orthonormal(self, ways: Floats) -> Floats:
        """Return the coefficients of orthonormal polynomials, shape (monomial, n).

        Args:
            ways: Coefficients of polynomials that span them, shape (monomial, m).
        """
        values = self.monomials @ ways
        square, turn = np.linalg.eigh(values.T @ (self.share[:, None] * values))
        kept = square > _ROUNDING
        return ways @ (turn[:, kept] / np.sqrt(square[kept]))

    def _solved(self, values: Floats, due: Floats) -> Floats | None:
        """Return the factors that change means of polynomials; None if none are found.

        Args:
            values: Of the polynomials, shape (node, n).
            due: By how much the means should change, shape (n,).
        """
        target, ways = self.share @ values + due, np.zeros(len(due))
        for _ in range(_STEPS):
            with np.errstate(over="ignore"):
                factors = np.exp(values @ ways)
            if not np.isfinite(factors).all():
                return None
            mass = self.share * factors
            slope = target - mass @ values
            matrix = values.T @ (mass[:, None] * values)
            step = cast(Floats, np.linalg.lstsq(matrix, slope, rcond=None)[0])
            square = float(slope @ step)
            if square <= _LAST:
                return factors
            ways += step * min(1.0, np.sqrt(_LARGEST / square))
        return None


def _monomials(places: Floats) -> Floats:
    """Return 1, x, y, z, x², y², z², yz, zx and xy, shape (place, 10)."""
    one, (i, j) = np.ones((len(places), 1)), _PAIRS
    return np.concatenate([one, places, places[:, i] * places[:, j]], axis=1)


def _even(images: Sequence[Floats], count: int) -> Floats:
    """Return the coefficients of polynomials that are even about planes, shape (10, n).

    Args:
        images: Mirror images of ``CUBE_27``, each of shape (place, 3).
        count: How many of the first monomials they consist of.
    """
    odd = [_monomials(one) - _monomials(CUBE_27) for one in images]
    every = np.concatenate([*odd, np.zeros((count, 10))])[:, :count]
    _, sizes, ways = np.linalg.svd(every)
    even = ways[sizes <= _ROUNDING * max(1.0, sizes[0])]
    return np.concatenate([even.T, np.zeros((10 - count, len(even)))])
