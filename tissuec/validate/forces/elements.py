"""Solid elements by the stress of the undeformed body, S = 2 ∂W/∂C with C = FᵀF.

Shape functions are polynomials that are 1 at one node and 0 at the others, found from their
values there; what the stress changes by with C is found by steps in the complex plane, which
have no error of difference (W. Squire, G. Trapp, SIAM Rev. 40:110, 1998).
"""

from collections.abc import Callable
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import expm

from tissuec.validate.forces import ForceFormula, assembled
from tissuec.validate.forces.bending_cells import BendingCells
from tissuec.validate.forces.bending_wedges import BendingWedges
from tissuec.validate.forces.cut_elements import point_measures
from tissuec.validate.forces.relaxing import PlasticElements, RelaxingElements
from tissuec.validate.forces.solid_laws import SolidLaws

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
LEAST = 0.2  # of volumes, below which the isochoric part is continued by a parabola
STEP = 1e-30  # in the complex plane


class Strained(NamedTuple):
    """The strain of elements at their points.

    Attributes:
        f: F, shape (element, point, 3, 3).
        c: C, of the same shape.
        j: Ratios of volumes, shape (element, point).
        pressure: Slope of the energy of the volume of elements [Pa], shape (element,), or
            where volumes are linear in the place, shape (element, point).
        ratio: Of volumes, to which whole laws refer: J, or that of whole cells, of its shape.
        cells: How hexahedra are bent; None for other elements.
    """

    f: Any
    c: Any
    j: Any
    pressure: Any
    ratio: Any
    cells: Any = None

    @property
    def at_points(self) -> Any:
        """Return the pressure with an axis for points [Pa]."""
        return self.pressure if np.ndim(self.pressure) == 2 else self.pressure[:, None]


class ElementSolid(ForceFormula):
    """The elements of one body as a field of forces.

    Args:
        elements: Read for nodes, moduli and laws.
        drawn: Places of all nodes as drawn [m], shape (node, 3).
        velocity: Of all nodes [m/s], followed by internal variables, which give the plastic
            strain of the elements, which ``matrix`` uses.
        parts: Of cells, where blades have divided them, in the order of the elements.
    """

    def __init__(
        self, elements: "SolidElements", drawn: Floats, velocity: Floats | None = None,
        parts: Any = None,
    ):  # fmt: skip
        self._nodes = elements.nodes
        self._shear = elements.shear[:, None]
        self._bulk = elements.bulk
        self._local, self._eta = elements.local[:, None], elements.viscosity[:, None]
        of = elements.fibres
        self._along = of.along
        self._fibres = of.stiffness[:, None], of.stiffening[:, None], of.dispersion[:, None]
        has_branches = elements.branches is not None and len(elements.internal_rows)
        self.branches = RelaxingElements(elements) if has_branches else None
        yields = elements.yielding is not None and len(elements.internal_rows)
        self.plastic = PlasticElements(elements) if yields else None
        #: What they remember, in the order of unknowns.
        self.kept = [one for one in (self.branches, self.plastic) if one is not None]
        self._velocity = np.zeros_like(drawn) if velocity is None else velocity
        points, weights, exponents, corners = RULES[elements.shape.name]()
        own: NDArray[np.floating[Any]] = np.linalg.inv(_monomials(corners, exponents))

        def natural(places: Floats) -> Floats:
            return np.einsum("qmk,ma->qak", _slopes(places, exponents), own)

        if parts is None:
            sides = np.einsum("eax,qak->eqxk", drawn[self._nodes], natural(points))
            inward = np.asarray(np.linalg.inv(sides), dtype=float)
            self._slope = np.einsum("qak,eqkx->eqax", natural(points), inward)
            self._weight = np.linalg.det(sides) * weights
        else:
            given = parts, points, weights, corners, drawn[self._nodes], natural
            self._slope, self._weight = point_measures(*given)
        self._volume = self._weight.sum(axis=1)
        self._drawn = None if elements.prestretch is None else drawn_out(elements)
        self._smooth: Any = None
        if elements.shape.name == "quadratic hexahedron":
            self._smooth = _linear_fit(points, self._weight)
        self._cells: BendingCells | BendingWedges | None = None
        if elements.shape.name in ("hexahedron", "wedge") and parts is None:
            given = drawn[self._nodes], self._slope, self._weight, elements.shear, self._bulk
            is_wedge = elements.shape.name == "wedge"
            self._cells = BendingWedges(*given) if is_wedge else BendingCells(*given, points)
            even = self._volume[:, None] / len(points)
            self._weight = np.broadcast_to(even, self._weight.shape)
        elif self._drawn is not None:
            self._slope = np.einsum("eqax,exy->eqay", self._slope, self._drawn)
        self._laws = SolidLaws(
            elements.laws, elements.law, self._shear, elements.bulk_modulus[:, None]
        )
        self._entities = elements.walls
        self._limits = elements.limits

    # --- states -------------------------------------------------------------------------------

    def _strained(self, position: Any) -> Strained:
        """Return the strain of all points.

        Args:
            position: Of all nodes [m], which may be complex, shape (node, 3).
        """
        return self._strained_at(position[self._nodes])

    def _strained_at(self, corners: Any) -> Strained:
        """Return the strain of all points, given nodes [m], shape (element, node, 3)."""
        if self._cells is not None:
            return self._bent(corners)
        f = np.einsum("eax,eqak->eqxk", corners, self._slope)
        c, j = np.einsum("eqxk,eqxl->eqkl", f, f), np.linalg.det(f)
        if self._smooth is not None:
            _, slope = self._laws.of_volume(self._fitted(j), self._bulk[:, None])
            # The transpose of the fit with weights is the fit with weights.
            return Strained(f, c, j, self._fitted(slope), j)
        mean = (self._weight * j).sum(axis=1) / self._volume
        return Strained(f, c, j, self._laws.of_mean(mean, self._bulk)[1], j)

    def _fitted(self, values: Any) -> Any:
        """Return the linear fit to values of points, shape (element, point)."""
        return np.einsum("eqp,ep->eq", self._smooth, values)

    def _bent(self, corners: Any) -> Strained:
        """Return the strain of cells that bend, given nodes [m], shape (cell, node, 3)."""
        assert self._cells is not None
        at: Any = self._cells.bent(corners)
        whole, _, c = self._cells.points(at)
        f, j, ratio = at.mean[:, None] @ whole, np.linalg.det(at.mean), at.volume
        if self._drawn is not None:
            more = self._drawn[:, None]
            f, c = f @ more, more.swapaxes(-1, -2) @ c @ more
            wider = np.linalg.det(self._drawn)
            j, ratio = j * wider, ratio * wider
        slope = self._laws.of_mean(at.volume, self._bulk)[1]
        j, ratio = (np.repeat(each[:, None], c.shape[1], axis=1) for each in (j, ratio))
        return Strained(f, c, j, slope, ratio, at)

    def _flowed(self, velocity: Floats) -> Floats | None:
        """Return Cp⁻¹ without its volume, shape (element, point, 3, 3); None if none yields."""
        return None if self.plastic is None else self.plastic.unimodular(velocity)

    def _whole_stress(self, state: Strained, *more: Any, fibred: bool = True) -> Any:
        """Return S with what J adds to it [Pa]; see ``_stress``."""
        c = state.c
        stress, by_j, by_ratio = self._stress(state, *more, fibred=fibred)
        cofactors = _cofactors(c)  # of a symmetric tensor
        by_j = by_j + by_ratio * state.ratio / state.j + state.at_points * fibred
        square = np.einsum("eqk,eqk->eq", c[..., 0], cofactors[..., 0])
        return stress + (by_j * state.j / square)[..., None, None] * cofactors

    def _stress(
        self,
        state: Strained,
        relaxing: Floats | None = None,
        flowed: Floats | None = None,
        *,
        fibred: bool = True,
    ) -> tuple[Any, Any, Any]:
        """Return 2 ∂W/∂C, shape (element, point, 3, 3), ∂W/∂J, and that by the ratio [Pa].

        Args:
            state: Of the elements, which may be complex.
            relaxing: Σ μk B of branches [Pa], shape (element, point, 3, 3); None without any.
            flowed: Cp⁻¹ without its volume, of the same shape; None if none yields.
            fibred: Whether to include fibres and volume, which are in parallel with any flow.
        """
        c, j = state.c, state.j
        a, b, d = c[..., 0, 0], c[..., 1, 1], c[..., 2, 2]
        p, q, r = c[..., 1, 2], c[..., 0, 2], c[..., 0, 1]
        first, second = a + b + d, a * b + b * d + d * a - p * p - q * q - r * r
        g, slope = _continued(j)
        one, i1, i2 = np.eye(3), first, second
        if flowed is not None:
            one, (i1, i2) = flowed, _invariants(c @ flowed)
        fold, folding = _folded(j)
        large = g * i1 + fold
        pair, (by_large, by_own, by_fold) = _paired(large, g**2 * i2 + 2.0 * fold, fold)
        wide, by_ratio = _continued(state.ratio)
        by_first, by_pair, by_g, by_wide = self._laws.slopes(large, pair, g, wide)
        by_first, by_second = by_first + by_pair * by_large, by_pair * by_own
        by_j = slope * (by_first * i1 + 2.0 * g * by_second * i2 + by_g)
        by_j = by_j + folding * by_pair * by_fold
        by_j = by_j + folding * (by_first + 2.0 * by_second)
        if fibred:
            by_j = by_j + self._laws.of_volume(j, self._local)[1]
        stress = 2.0 * (by_first * g + by_second * g * g * i1)[..., None, None] * one
        stress = stress - 2.0 * (by_second * g * g)[..., None, None] * (one @ c @ one)
        k1, k2, spread = self._fibres
        for along in np.moveaxis(self._along, 1, 0) if fibred else ():
            fourth = np.einsum("eqkl,ek,el->eq", c, along, along)
            e = spread * (g * first + fold - 3.0) + (1.0 - 3.0 * spread) * (fourth - 1.0)
            pull = np.where(e.real > 0.0, k1 * e * np.exp(k2 * e * e), 0.0)
            by_j = by_j + pull * spread * (slope * first + folding)
            line = np.einsum("eq,ek,el->eqkl", pull * (1.0 - 3.0 * spread), along, along)
            stress = (
                stress + 2.0 * line + 2.0 * (pull * spread * g)[..., None, None] * np.eye(3)
            )
        if relaxing is not None:
            assert self.branches is not None
            held = np.einsum("eqkl,eqkl->eq", c, relaxing)
            if self._cells is None:
                by_j = by_j + 0.5 * slope * held
            else:
                g, by_square = _of_square(c)
                stress = stress + (by_square * held)[..., None, None] * _cofactors(c)
            by_j = by_j + 0.5 * folding * self.branches.sudden[:, None]
            stress = stress + g[..., None, None] * relaxing
        return stress, by_j, by_ratio * by_wide

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
        state = self._strained(position)
        relaxing = None if self.branches is None else self.branches.weight(velocity)
        memory = relaxing, self._flowed(velocity)
        push = self._push(state, memory)
        if self._eta.any():
            rate, way, thick = self._flow(state, position, velocity)
            piola = 2.0 * thick[..., None, None] * (rate @ way)
            push += self._of_piola(state, piola, position, velocity)
        np.subtract.at(to, self._nodes, push)

    def _push(self, state: Strained, memory: Any) -> Any:
        """Return minus the elastic forces on nodes [N], shape (element, node, 3).

        Args:
            state: Of the elements.
            memory: The last two arguments of ``_stress`` without its keyword.
        """
        if self._cells is None:
            stress = self._whole_stress(state, *memory)
            return np.einsum(
                "eq,eqxk,eqkl,eqal->eax", self._weight, state.f, stress, self._slope
            )
        stress, by_j, by_ratio = self._stress(state, *memory)
        if self._drawn is not None:
            stress = self._drawn[:, None] @ stress @ self._drawn[:, None].swapaxes(-1, -2)
            more = np.linalg.det(self._drawn)[:, None]
            by_j, by_ratio = by_j * more, by_ratio * more
        pressure = state.pressure + by_ratio.mean(axis=1)  # points have equal weights
        return self._cells.pushes(state.cells, stress, by_j, pressure)

    def _of_piola(
        self, state: Strained, piola: Floats, position: Floats, velocity: Floats
    ) -> Floats:
        """Return minus viscous forces on nodes [N], shape (element, node, 3).

        Args:
            state: Of the elements.
            piola: w P of the points [J], shape (element, point, 3, 3).
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        if self._cells is None:
            return np.einsum("eqxk,eqak->eax", piola, self._slope)
        if self._drawn is not None:
            piola = piola @ self._drawn[:, None].swapaxes(-1, -2)
        _, moving = self._rate(position, velocity)
        resisting = self._cells.resisting(state.cells, moving.cells.dots, self._eta[:, 0])
        return self._cells.turned(state.cells, piola, resisting)

    def _rate(self, position: Floats, velocity: Floats) -> tuple[Any, Strained]:
        """Return dF/dt, and the rates of all else that is strained [1/s]."""
        moved = self._strained(position + 1j * STEP * velocity[: len(position)])
        cells = moved.cells and type(moved.cells)(*(each.imag / STEP for each in moved.cells))
        rate = moved.f.imag / STEP
        return rate, moved._replace(cells=cells)

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J], without ``remembered_energy``."""
        return float(self._energies(position).sum())

    def _energies(self, position: Floats) -> Floats:
        """Return the energy of each element [J], the work of the stress along a straight way.

        Each law is integrated from the drawn state on, where it stores nothing. Where elements
        yield, laws are left out, because their energy depends on the plastic strain.
        """
        state = self._strained(position)
        _, c, j, _, ratio, at = state
        (g, _), (wide, _) = _continued(j), _continued(ratio)
        first = np.trace(c, axis1=2, axis2=3)
        second = 0.5 * (first**2 - np.einsum("eqkl,eqlk->eq", c, c))
        fold, _ = _folded(j)
        one = g * first + fold - 3.0
        total, _ = self._laws.of_volume(j, self._local)
        if self.plastic is None:
            pair, _ = _paired(one + 3.0, g * g * second + 2.0 * fold, fold)
            total += self._laws.energies(one + 3.0, pair, g, wide)
        k1, k2, spread = self._fibres
        for along in np.moveaxis(self._along, 1, 0):
            stretched = np.einsum("eqkl,ek,el->eq", c, along, along)
            e = spread * one + (1.0 - 3.0 * spread) * (stretched - 1.0)
            total += np.where(e > 0.0, 0.5 * k1 / k2 * (np.exp(k2 * e * e) - 1.0), 0.0)
        of_points = (self._weight * total).sum(axis=1)
        if self._cells is not None:
            of_volume, _ = self._laws.of_mean(at.volume, self._bulk)
            return np.asarray(of_points + self._cells.alone(at, of_volume))
        if self._smooth is not None:
            whole, _ = self._laws.of_volume(self._fitted(j), self._bulk[:, None])
            return np.asarray(of_points + (self._weight * whole).sum(axis=1))
        mean = (self._weight * j).sum(axis=1) / self._volume
        of_mean, _ = self._laws.of_mean(mean, self._bulk)
        return np.asarray(of_points + self._volume * of_mean)

    @property
    def breakable(self) -> Indices:
        """Return the elements that may break, as entities, shape (element,)."""
        return np.zeros(0, dtype=np.int64) if self._limits is None else self._entities

    def burdens(self, position: Floats) -> Floats:
        """Return loads divided by the limits of elements, dimensionless, shape (element,).

        Principal stretches are the singular values of the mean of F.
        """
        limits = self._limits
        if limits is None:
            return np.zeros(0)
        state = self._strained(position)
        f = state.f
        part = self._weight / self._volume[:, None]
        widest = np.linalg.svd(np.einsum("eq,eqxk->exk", part, f), compute_uv=False)[:, 0]
        stress, by_j, by_ratio = self._stress(state)
        kirchhoff = np.einsum("eq,eqxk,eqkl,eqyl->exy", part, f, stress, f)
        mean = state.j * (by_j + state.at_points) + state.ratio * by_ratio
        mean = (part * mean).sum(axis=1)
        kirchhoff = kirchhoff + mean[:, None, None] * np.eye(3)
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
        state = self._strained(position)
        if self._cells is None:
            g, _ = _continued(state.j)
        else:
            g, _ = _of_square(state.c)
        return np.asarray(g[..., None, None] * state.c)

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
        total = np.zeros_like(self._weight)
        _, c, j, _, ratio, _ = self._strained(position)
        fold, _ = _folded(j)
        if self.branches is not None:
            total += self.branches.energy(self.unimodular(position), velocity)
            total += 0.5 * fold * self.branches.sudden[:, None]
        if self.plastic is not None:
            first, second = _invariants(c @ self.plastic.unimodular(velocity))
            (g, _), (wide, _) = _continued(j), _continued(ratio)
            large = g * first + fold
            pair, _ = _paired(large, g * g * second + 2.0 * fold, fold)
            total += self._laws.energies(large, pair, g, wide)
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
        state = self._strained(position)
        relaxing = None if self.branches is None else self.branches.weight(velocity)
        flowed = self._flowed(velocity)
        stress = self._whole_stress(state, relaxing, flowed, fibred=False)
        return np.asarray(stress @ state.c)

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
        state = self._strained(position)
        rate, _, thick = self._flow(state, position, velocity)
        lost += 2.0 * float((thick * (rate**2).sum(axis=(2, 3))).sum())
        if self._cells is not None:
            _, moving = self._rate(position, velocity)
            dots = moving.cells.dots
            resisting = self._cells.resisting(state.cells, dots, self._eta[:, 0])
            lost += float((resisting * dots[:, :, 3]).sum())
        return lost

    def _flow(
        self, state: Strained, position: Floats, velocity: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return J times the rate of strain without its trace, cof F, and w η/J."""
        moving, _ = self._rate(position, velocity)
        way = _cofactors(state.f)
        flow = moving @ way.swapaxes(-1, -2)
        rate = 0.5 * (flow + flow.swapaxes(-1, -2))
        rate -= np.trace(rate, axis1=2, axis2=3)[..., None, None] / 3.0 * np.eye(3)
        return rate, way, self._weight * self._eta / np.maximum(state.j, LEAST)

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        flowed, count = self._flowed(self._velocity), self._nodes.shape[1]
        values = np.empty((len(self._nodes), count, 3, count, 3))
        for node, axis in np.ndindex(count, 3):
            corners = position[self._nodes].astype(complex)
            corners[:, node, axis] += 1j * STEP
            push = self._push(self._strained_at(corners), (None, flowed))
            values[..., node, axis] = push.imag / STEP
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


def _folded(j: Any) -> tuple[Any, Any]:
    """Return the increase of the isochoric I1 at J below ``LEAST``, and its derivative by J.

    It is Hermite's polynomial from 0 at ``LEAST`` to 3 at J = 0, where its first and second
    derivatives are zero.
    """
    part: Any = np.where(j.real < LEAST, 1.0 - j / LEAST, 0.0)
    part = np.where(part.real > 1.0, 1.0, part)
    rise = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
    return 3.0 * rise, -90.0 / LEAST * part**2 * (1.0 - part) ** 2


def _paired(first: Any, second: Any, fold: Any) -> tuple[Any, tuple[Any, Any, Any]]:
    """Return I2 where J is less than ``LEAST``, and its derivatives by all arguments.

    At J = 0 it is p = I1 + (I1 - 3)²/8, which stretches have whatever I1 is; a part of fold/3
    is that before.

    Args:
        first, second: I1 and I2 with what is added to them.
        fold: Of ``_folded``.
    """
    part, pair = fold / 3.0, first + (first - 3.0) ** 2 / 8.0
    slopes = part * (1.0 + (first - 3.0) / 4.0), 1.0 - part, (pair - second) / 3.0
    return (1.0 - part) * second + part * pair, slopes


def _of_square(c: Any) -> tuple[Any, Any]:
    """Return (det C)^(-1/3) and its derivative; see ``_inverse_root``."""
    return _inverse_root(np.linalg.det(c))


def _inverse_root(square: Any) -> tuple[Any, Any]:
    """Return x^(-1/3), below ``LEAST``² Taylor's polynomial, and its derivative."""
    near = np.where(square.real < LEAST**2, LEAST**2, square)
    below, third = square - near, near ** (-1.0 / 3.0)
    slope, bend = -third / near / 3.0, 4.0 / 9.0 * third / near**2
    return third + below * (slope + 0.5 * bend * below), slope + bend * below


def _continued(j: Any) -> tuple[Any, Any]:
    """Return J^(-2/3) and its derivative, below ``LEAST`` Taylor's polynomial from there."""
    near = np.where(j.real < LEAST, LEAST, j)
    below = j - near
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


def _quadratic_hexahedron() -> Rule:
    places, weights = np.polynomial.legendre.leggauss(3)
    every = np.array(list(product(range(3), repeat=3)))
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    beside = [(0, -1), (1, 0), (0, 1), (-1, 0)]
    nodes = [
        *((x, y, z) for z in (-1, 1) for x, y in corners),
        *((x, y, z) for z in (-1, 1) for x, y in beside),
        *((x, y, 0) for x, y in corners),
        (-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1), (0, 0, 0),
    ]  # fmt: skip
    return places[every], weights[every].prod(axis=1), every, np.array(nodes, dtype=float)


def _linear_fit(places: Floats, weight: Floats) -> Floats:
    """Return the matrices of weighted fits of linear functions, shape (element, point, point).

    Args:
        places: Of the points in natural coordinates, shape (point, 3).
        weight: Theirs [m³], shape (element, point).
    """
    functions = np.column_stack([np.ones(len(places)), places])
    turned = functions.T * weight[:, None]
    fitted: Floats = functions @ np.linalg.solve(turned @ functions, turned)
    return fitted


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
    "quadratic hexahedron": _quadratic_hexahedron,
    "tetrahedron": _tetrahedron,
    "wedge": _wedge,
}


def shape_functions(shape: str, places: Floats) -> Floats:
    """Return the dimensionless functions of the nodes of a shape, shape (place, node).

    Args:
        places: Natural coordinates, shape (place, 3), of triangles (place, 2).
    """
    if shape == "triangle":
        return np.column_stack([1.0 - places.sum(axis=1), places])
    _, _, exponents, nodes = RULES[shape]()
    found = _monomials(places, exponents) @ np.linalg.inv(_monomials(nodes, exponents))
    return np.asarray(found)


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
