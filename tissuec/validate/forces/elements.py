"""Solid elements by the stress of the undeformed body, S = 2 ∂W/∂C with C = FᵀF.

Shape functions are polynomials that are 1 at one node and 0 at the others, found from their
values there; what the stress changes by with C is found by steps in the complex plane, which
have no error of difference (W. Squire, G. Trapp, SIAM Rev. 40:110, 1998).
"""

from collections.abc import Callable
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import expm

from tissuec.validate.forces import ForceFormula, assembled
from tissuec.validate.forces.relaxing import PlasticElements, RelaxingElements
from tissuec.validate.forces.solid_laws import SolidLaws

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
LEAST = 0.2  # of volumes, below which the isochoric part is continued by a parabola
SPREAD = 0.75  # of the squares of deviations of gradients in hexahedra
STEP = 1e-30  # in the complex plane
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class ElementSolid(ForceFormula):
    """The elements of one body as a field of forces.

    Args:
        elements: Read for nodes, moduli and laws.
        drawn: Places of all nodes as drawn [m], shape (node, 3).
        velocity: Of all nodes [m/s], shape (node, 3); those of hidden ones give the plastic
            strain of the elements, which ``matrix`` uses.
    """

    def __init__(
        self, elements: "SolidElements", drawn: Floats, velocity: Floats | None = None
    ):
        self._nodes = elements.nodes
        self._shear = elements.shear[:, None]
        self._bulk = elements.bulk
        self._local, self._eta = elements.local[:, None], elements.viscosity[:, None]
        of = elements.fibres
        self._along = of.along
        self._fibres = of.stiffness[:, None], of.stiffening[:, None], of.dispersion[:, None]
        self._laws = SolidLaws(elements.laws, elements.law, self._shear)
        has_branches = elements.branches is not None and len(elements.hidden)
        self.branches = RelaxingElements(elements) if has_branches else None
        yields = elements.yielding is not None and len(elements.hidden)
        self.plastic = PlasticElements(elements) if yields else None
        #: What they remember, in the order of unknowns.
        self.kept = [one for one in (self.branches, self.plastic) if one is not None]
        self._velocity = np.zeros_like(drawn) if velocity is None else velocity
        points, weights, exponents, corners = RULES[elements.shape.name]()
        own: NDArray[np.floating[Any]] = np.linalg.inv(_monomials(corners, exponents))
        natural = np.einsum("qmk,ma->qak", _slopes(points, exponents), own)
        sides = np.einsum("eax,qak->eqxk", drawn[self._nodes], natural)
        inward = np.asarray(np.linalg.inv(sides), dtype=float)
        self._slope = np.einsum("qak,eqkx->eqax", natural, inward)
        self._weight = np.linalg.det(sides) * weights
        self._volume = self._weight.sum(axis=1)
        if elements.shape.name == "hexahedron":
            mean = np.einsum("eq,eqax->eax", self._weight, self._slope)
            mean /= self._volume[:, None, None]
            self._slope = mean[:, None] + np.sqrt(SPREAD) * (self._slope - mean[:, None])
        if elements.prestretch is not None:
            self._slope = np.einsum("eqax,exy->eqay", self._slope, drawn_out(elements))
        self._limits = elements.limits

    # --- states -------------------------------------------------------------------------------

    def _strained(self, position: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, J and the pressure of the mean, by element and point."""
        f = np.einsum("eax,eqak->eqxk", position[self._nodes], self._slope)
        j = np.linalg.det(f)
        mean = (self._weight * j).sum(axis=1) / self._volume
        return f, j, np.broadcast_to((self._bulk * (mean - 1.0))[:, None], j.shape)

    def _flowed(self, velocity: Floats) -> Floats | None:
        """Return Cp⁻¹ without its volume, shape (element, point, 3, 3); None if none yields."""
        return None if self.plastic is None else self.plastic.unimodular(velocity)

    def _stress(
        self,
        c: Any,
        sign: Floats,
        pressure: Floats,
        relaxing: Floats | None = None,
        flowed: Floats | None = None,
        *,
        fibred: bool = True,
    ) -> Any:
        """Return S [Pa], shape (element, point, 3, 3), of C, which may be complex.

        Args:
            c: C, dimensionless, shape (element, point, 3, 3).
            sign: Of J, shape (element, point).
            pressure: Of the mean [Pa], shape (element, point).
            relaxing: Σ μk B of branches [Pa], shape (element, point, 3, 3); None without any.
            flowed: Cp⁻¹ without its volume, of the same shape; None if none yields.
            fibred: Whether to include fibres.
        """
        a, b, d = c[..., 0, 0], c[..., 1, 1], c[..., 2, 2]
        p, q, r = c[..., 1, 2], c[..., 0, 2], c[..., 0, 1]
        square = a * (b * d - p * p) - r * (r * d - p * q) + q * (r * p - b * q)
        j = sign * np.sqrt(square)
        cofactors = np.empty_like(c)
        cofactors[..., 0, 0], cofactors[..., 1, 1] = b * d - p * p, a * d - q * q
        cofactors[..., 2, 2] = a * b - r * r
        cofactors[..., 0, 1] = cofactors[..., 1, 0] = q * p - r * d
        cofactors[..., 0, 2] = cofactors[..., 2, 0] = r * p - q * b
        cofactors[..., 1, 2] = cofactors[..., 2, 1] = r * q - a * p
        first, second = a + b + d, a * b + b * d + d * a - p * p - q * q - r * r
        near = np.where(j.real < LEAST, LEAST, j)
        g, slope = _isochoric(near, j - near)
        one, i1, i2 = np.eye(3), first, second
        if flowed is not None:
            one, (i1, i2) = flowed, _invariants(c @ flowed)
        by_first, by_second = self._laws.slopes(g * i1, g**2 * i2)
        by_j = slope * (by_first * i1 + 2.0 * g * by_second * i2)
        by_j = by_j + pressure + self._local * (j - 1.0)
        stress = 2.0 * (by_first * g + by_second * g * g * i1)[..., None, None] * one
        stress = stress - 2.0 * (by_second * g * g)[..., None, None] * (one @ c @ one)
        k1, k2, spread = self._fibres
        for along in np.moveaxis(self._along, 1, 0) if fibred else ():
            fourth = np.einsum("eqkl,ek,el->eq", c, along, along)
            e = spread * (g * first - 3.0) + (1.0 - 3.0 * spread) * (fourth - 1.0)
            pull = np.where(e.real > 0.0, k1 * e * np.exp(k2 * e * e), 0.0)
            by_j = by_j + slope * pull * spread * first
            line = np.einsum("eq,ek,el->eqkl", pull * (1.0 - 3.0 * spread), along, along)
            stress = (
                stress + 2.0 * line + 2.0 * (pull * spread * g)[..., None, None] * np.eye(3)
            )
        if relaxing is not None:
            by_j = by_j + 0.5 * slope * np.einsum("eqkl,eqkl->eq", c, relaxing)
            stress = stress + g[..., None, None] * relaxing
        return stress + (by_j / j)[..., None, None] * cofactors

    def resistance(self, count: int) -> Floats:
        """Return Σ w (2 μ + K) |∂N_a/∂X|² of each node [N/m], shape (node,).

        Args:
            count: Number of nodes.
        """
        modulus = 2.0 * self._shear + self._local + self._bulk[:, None]
        if self.branches is not None:
            modulus = modulus + 2.0 * self.branches.sudden[:, None]
        each = np.einsum("eq,eqax,eqax->ea", self._weight * modulus, self._slope, self._slope)
        total = np.zeros(count)
        np.add.at(total, self._nodes, each)
        return total

    # --- what the reference needs -------------------------------------------------------------

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        f, j, pressure = self._strained(position)
        relaxing = None if self.branches is None else self.branches.weight(velocity)
        c = np.einsum("eqxk,eqxl->eqkl", f, f)
        stress = self._stress(c, np.sign(j), pressure, relaxing, self._flowed(velocity))
        push = np.einsum("eq,eqxk,eqkl,eqal->eax", self._weight, f, stress, self._slope)
        if self._eta.any():
            rate, way, thick = self._flow(f, j, velocity)
            push += 2.0 * np.einsum("eq,eqxy,eqay->eax", thick, rate, way)
        np.subtract.at(to, self._nodes, push)

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J], without ``remembered_energy``."""
        return float(self._energies(position).sum())

    def _energies(self, position: Floats) -> Floats:
        """Return the energy of each element [J], the work of the stress along a straight way.

        Each law is integrated from the drawn state on, where it stores nothing. Where elements
        yield, laws are left out, because their energy depends on the plastic strain.
        """
        f, j, _ = self._strained(position)
        near = np.maximum(j, LEAST)
        g, _ = _isochoric(near, j - near)
        c = np.einsum("eqxk,eqxl->eqkl", f, f)
        first = np.trace(c, axis1=2, axis2=3)
        second = 0.5 * (first**2 - np.einsum("eqkl,eqlk->eq", c, c))
        one = g * first - 3.0
        total = 0.5 * self._local * (j - 1.0) ** 2
        if self.plastic is None:
            total += self._laws.energies(g * first, g * g * second)
        k1, k2, spread = self._fibres
        for along in np.moveaxis(self._along, 1, 0):
            stretched = np.einsum("eqxk,ek->eqx", f, along)
            e = spread * one + (1.0 - 3.0 * spread) * ((stretched**2).sum(axis=2) - 1.0)
            total += np.where(e > 0.0, 0.5 * k1 / k2 * (np.exp(k2 * e * e) - 1.0), 0.0)
        mean = (self._weight * j).sum(axis=1) / self._volume
        of_mean = 0.5 * self._bulk * self._volume * (mean - 1.0) ** 2
        return np.asarray((self._weight * total).sum(axis=1) + of_mean)

    @property
    def marks(self) -> Indices:
        """Return the springs that die with elements that break, shape (element,)."""
        none = np.zeros(0, dtype=np.int64)
        return none if self._limits is None else np.asarray(self._limits.marks)

    def burdens(self, position: Floats) -> Floats:
        """Return loads divided by the limits of elements, dimensionless, shape (element,).

        Principal stretches are the singular values of the mean of F.
        """
        limits = self._limits
        if limits is None:
            return np.zeros(0)
        f, j, pressure = self._strained(position)
        part = self._weight / self._volume[:, None]
        widest = np.linalg.svd(np.einsum("eq,eqxk->exk", part, f), compute_uv=False)[:, 0]
        stress = self._stress(np.einsum("eqxk,eqxl->eqkl", f, f), np.sign(j), pressure)
        kirchhoff = np.einsum("eq,eqxk,eqkl,eqyl->exy", part, f, stress, f)
        largest = np.linalg.eigvalsh(kirchhoff)[:, -1] / widest
        held = self._energies(position) / self._volume ** (2.0 / 3.0)
        loads = (
            (widest - 1.0, limits.strain), (largest, limits.stress), (held, limits.toughness)
        )  # fmt: skip
        # Where there is no limit, the load may be no number: elements that yield have no limit
        # of stress or energy, which are those without any flow here.
        each = [np.where(np.isfinite(limit), load / limit, 0.0) for load, limit in loads]
        return np.asarray(np.max(each, axis=0))

    def unimodular(self, position: Floats) -> Floats:
        """Return C without its change of volume, dimensionless.

        The shape is (element, point, 3, 3).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        f, j, _ = self._strained(position)
        near = np.maximum(j, LEAST)
        g, _ = _isochoric(near, j - near)
        return g[..., None, None] * np.einsum("eqxk,eqxl->eqkl", f, f)

    def give_way(self, position: Floats, velocity: Floats, free: Indices) -> None:
        """Relax the branches of elements at some nodes completely.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
            free: These nodes, shape (free,).
        """
        if self.branches is not None:
            touched = np.isin(self._nodes, free).any(axis=1)
            self.branches.given_way(self.unimodular(position), touched, velocity)

    def remembered_energy(self, position: Floats, velocity: Floats) -> float:
        """Return the energy of branches, and of laws where elements yield [J].

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        right, total = self.unimodular(position), np.zeros_like(self._weight)
        if self.branches is not None:
            total += self.branches.energy(right, velocity)
        if self.plastic is not None:
            total += self._laws.energies(
                *_invariants(right @ self.plastic.unimodular(velocity))
            )
        return float((self._weight * total).sum())

    def rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of all unknowns [1/s], shape (n,).

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        carried, found = self._carried(position, velocity), [np.zeros(0)]
        if self.branches is not None:
            found += [self.branches.rates(self.unimodular(position), velocity, carried)]
        if self.plastic is not None and carried is not None:
            found += [self.plastic.rates(carried, velocity)]
        return np.concatenate(found)

    def _carried(self, position: Floats, velocity: Floats) -> Floats | None:
        """Return the flow M [1/s], shape (element, point, 3, 3); None if nothing yields."""
        return (
            None
            if self.plastic is None
            else self.plastic.flow(self._turned(position, velocity))
        )

    def _turned(self, position: Floats, velocity: Floats) -> Floats:
        """Return S C of laws and branches [Pa], shape (element, point, 3, 3)."""
        f, j, pressure = self._strained(position)
        c = np.einsum("eqxk,eqxl->eqkl", f, f)
        relaxing = None if self.branches is None else self.branches.weight(velocity)
        flowed = self._flowed(velocity)
        stress = self._stress(c, np.sign(j), 0.0 * pressure, relaxing, flowed, fibred=False)
        return np.asarray(stress @ c)

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that flow and relaxation lose [W]."""
        lost = 0.0
        if self.branches is not None:
            each = self.branches.lost(self.unimodular(position), velocity)
            lost = float((self._weight * each).sum())
        if self.plastic is not None:
            turned = self._turned(position, velocity)
            each = np.einsum("eqkl,eqlk->eq", turned, self.plastic.flow(turned))
            lost += float((self._weight * each).sum())
        if not self._eta.any():
            return lost
        f, j, _ = self._strained(position)
        rate, _, thick = self._flow(f, j, velocity)
        return lost + 2.0 * float((thick * (rate**2).sum(axis=(2, 3))).sum())

    def _flow(self, f: Floats, j: Floats, velocity: Floats) -> tuple[Floats, Floats, Floats]:
        """Return J times the rate of strain without its trace, ∂J/∂x_a, and w η/J."""
        turned = _cofactors(f)
        way = np.einsum("eqxk,eqak->eqax", turned, self._slope)
        flow = np.einsum("eax,eqay->eqxy", velocity[self._nodes], way)
        rate = 0.5 * (flow + flow.swapaxes(-1, -2))
        rate -= np.trace(rate, axis1=2, axis2=3)[..., None, None] / 3.0 * np.eye(3)
        return rate, way, self._weight * self._eta / np.maximum(j, LEAST)

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        f, j, pressure = self._strained(position)
        c, sign = np.einsum("eqxk,eqxl->eqkl", f, f), np.sign(j)
        flowed = self._flowed(self._velocity)
        stress = self._stress(c, sign, pressure, None, flowed)
        inner = np.einsum(
            "eq,eqak,eqkl,eqbl->eab", self._weight, self._slope, stress, self._slope
        )
        values = np.einsum("eab,xy->eaxby", inner, np.eye(3))
        for k, m in _PAIRS:
            moved = c.astype(complex)
            moved[..., k, m] += 1j * STEP
            if k != m:
                moved[..., m, k] += 1j * STEP
            change = self._stress(moved, sign, pressure, None, flowed).imag / STEP
            # How the component of C changes with places.
            by_place = np.einsum("eqx,eqa->eqax", f[..., k], self._slope[..., m])
            by_place = by_place + np.einsum("eqx,eqa->eqax", f[..., m], self._slope[..., k])
            push = np.einsum("eqxk,eqkl,eqal->eqax", f, change, self._slope)
            values += np.einsum("eq,eqax,eqby->eaxby", self._weight, push, by_place)
        turned = _cofactors(f)
        swell = np.einsum("eq,eqxk,eqak->eax", self._weight, turned, self._slope)
        values += np.einsum("e,eax,eby->eaxby", self._bulk / self._volume, swell, swell)
        return assembled(values, number[self._nodes], size)


def drawn_out(elements: "SolidElements") -> Floats:
    """Return the prestretch of elements as drawn, dimensionless, shape (element, 3, 3).

    This is exp of the logarithmic strain, which has no trace: along an axis n it is
    ln λ (3 n ⊗ n - 1)/2, and in the plane across n, ln λ (1 - 3 n ⊗ n).
    """
    given = elements.prestretch
    assert given is not None
    way = 3.0 * np.outer(given.axis, given.axis) - np.eye(3)
    strain = -way if given.is_across else 0.5 * way
    each: list[Floats] = [expm(np.log(one) * strain) for one in given.stretch]
    return np.array(each)


def _invariants(turned: Any) -> tuple[Any, Any]:
    """Return the first two invariants of tensors of shape (…, 3, 3)."""
    first = np.trace(turned, axis1=-2, axis2=-1)
    return first, 0.5 * (first**2 - np.einsum("...kl,...lk->...", turned, turned))


def _cofactors(f: Floats) -> Floats:
    """Return det F F⁻ᵀ, also where F has no inverse, as in steps that are far too large."""
    a, b, c = (f[..., k, :] for k in range(3))
    with np.errstate(all="ignore"):
        return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)


def _isochoric(near: Any, below: Any) -> tuple[Any, Any]:
    """Return Taylor's polynomial of second order of J^(-2/3), and its derivative."""
    a, b, c = (k * near ** (-2.0 / 3.0 - n) for n, k in enumerate((1.0, -2.0 / 3.0, 5.0 / 9.0)))
    return a + below * (b + c * below), b + 2.0 * c * below


# --- shapes -----------------------------------------------------------------------------------

Rule = tuple[Floats, Floats, Indices, Floats]  # points, weights, exponents, places of nodes


def _hexahedron() -> Rule:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
    nodes = np.concatenate([np.column_stack([corners, np.full(4, z)]) for z in (-1.0, 1.0)])
    # In the order of the nodes, in which branches are kept.
    places, _ = np.polynomial.legendre.leggauss(2)
    points = places[1] * nodes
    return points, np.ones(8), np.array(list(product((0, 1), repeat=3))), nodes


def _tetrahedron() -> Rule:
    apart = 1.0 / np.sqrt(5.0)
    centre, corners = np.full(3, 0.25), np.concatenate([np.zeros((1, 3)), np.eye(3)])
    points = centre + apart * (corners - centre)
    pairs = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
    nodes = np.array([*corners, *((corners[a] + corners[b]) / 2.0 for a, b in pairs)])
    exponents = [e for e in product((0, 1, 2), repeat=3) if sum(e) <= 2]
    return points, np.full(4, 1.0 / 24.0), np.array(exponents), nodes


def _wedge() -> Rule:
    heights, _ = np.polynomial.legendre.leggauss(2)
    third = np.full(2, 1.0 / 3.0)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    flat = third + 0.5 * (corners - third)
    points = np.array([[*place, height] for height in heights for place in flat])
    nodes = np.array([[*corner, height] for height in (-1.0, 1.0) for corner in corners])
    exponents = [(*e, z) for z in (0, 1) for e in ((0, 0), (1, 0), (0, 1))]
    return points, np.full(6, 1.0 / 6.0), np.array(exponents), nodes


RULES: dict[str, Callable[[], Rule]] = {
    "hexahedron": _hexahedron,
    "tetrahedron": _tetrahedron,
    "wedge": _wedge,
}


def _monomials(places: Floats, exponents: Indices) -> Floats:
    """Return the monomials at places, shape (place, monomial)."""
    return np.prod(places[:, None, :] ** exponents, axis=2)


def _slopes(places: Floats, exponents: Indices) -> Floats:
    """Return the derivatives of monomials at places, shape (place, monomial, 3)."""
    found = np.empty((len(places), len(exponents), 3))
    for k in range(3):
        lower = np.maximum(exponents - (np.arange(3) == k), 0)
        found[..., k] = exponents[:, k] * _monomials(places, lower)
    return found
