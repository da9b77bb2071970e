"""Walls of triangles by the stress of the undeformed wall, S = 2 ∂W/∂C in three directions.

C has the components of the plane, and C33 across it, at which S33 is zero: by Newton's method
in its logarithm, or where that fails by halving an interval. What S changes by with C comes
from steps in the complex plane, in which C33 follows by one step of Newton's method (W. Squire,
G. Trapp, SIAM Rev. 40:110, 1998).
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.validate.forces import ForceFormula, assembled
from tissuec.validate.forces.cut_plates import fractions_of
from tissuec.validate.forces.relaxing_walls import PlasticWall, RelaxingWall, WallMemory
from tissuec.validate.forces.solid_laws import SolidLaws

if TYPE_CHECKING:
    from tissuec.forces.surfaces.membranes import Membranes

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
LEAST = 0.2  # of areas, below which the root of the square is continued by a parabola
STEP = 1e-30  # in the complex plane
LARGEST = 20.0  # logarithm of C33
HALVINGS = 60  # of the interval for it, which leave rounding
NEWTON = 30  # steps
ROUNDING = 1e-9  # step after which a method of second order is at rounding
_PAIRS = ((0, 0), (1, 1), (0, 1))
_NOTHING = WallMemory()


class MembraneWall(ForceFormula):
    """The triangles of one wall as a field of forces.

    Args:
        wall: Read for nodes, drawn gradients, moduli and laws.
        velocity: Of all nodes [m/s], followed by internal variables, which give the plastic
            strain of the triangles, which ``matrix`` uses. None where nothing yields.
        parts: Of triangles, where blades have divided them, in the order of the wall.
    """

    def __init__(self, wall: "Membranes", velocity: Floats | None = None, parts: Any = None):
        self._nodes, self._slope, self._weight = wall.nodes, wall.gradients, wall.weight
        if parts is not None:
            whole = wall.thickness * wall.area * (wall.weight / wall.volume)
            self._weight = whole * fractions_of(parts)
        self._shear, self._bulk, self._eta = wall.shear, wall.bulk, wall.viscosity
        of = wall.fibres
        self._along = of.along
        self._fibres = of.stiffness, of.stiffening, of.dispersion
        self._laws = SolidLaws(wall.laws, wall.law, self._shear, self._bulk)
        has_branches = wall.branches is not None and len(wall.internal_rows)
        self.branches = RelaxingWall(wall) if has_branches else None
        yields = wall.yielding is not None and len(wall.internal_rows)
        self.plastic = PlasticWall(wall) if yields else None
        #: Their internal variables, in the order of unknowns.
        self.kept = [one for one in (self.branches, self.plastic) if one is not None]
        self._start = _NOTHING
        if self.plastic is not None and velocity is not None:
            self._start = WallMemory(flowed=self.plastic.inverse(velocity))
        self._seen: tuple[Floats, tuple[Floats, Floats, Floats]] | None = None
        self._known: tuple[Floats, WallMemory] | None = None
        self._entities = wall.walls
        self._limits, self._side = wall.limits, wall.thickness * np.sqrt(wall.area)

    # --- states -------------------------------------------------------------------------------

    def _strained(
        self, position: Floats, kept: WallMemory = _NOTHING
    ) -> tuple[Floats, Floats, Floats]:
        """Return F, C in the plane, and C33 of each triangle; kept for a second call.

        Args:
            position: Of all nodes [m], shape (node, 3).
            kept: Internal variables of the triangles.
        """
        f = np.einsum("eax,eak->exk", position[self._nodes], self._slope)
        key = np.concatenate([f.ravel(), kept.key])
        if self._seen is None or not np.array_equal(self._seen[0], key):
            c = np.einsum("exk,exl->ekl", f, f)
            self._seen = key, (f, c, self._across(c, kept))
        return self._seen[1]

    def _memory(self, velocity: Floats) -> WallMemory:
        """Return the internal variables; kept, as forces, rates and losses need them."""
        if not self.kept:
            return _NOTHING
        if self._known is None or not np.array_equal(self._known[0], velocity):
            memory = WallMemory(
                None if self.branches is None else self.branches.weight(velocity),
                None if self.plastic is None else self.plastic.inverse(velocity),
            )
            self._known = velocity.copy(), memory
        return self._known[1]

    def _across(self, c: Floats, kept: WallMemory) -> Floats:
        """Return C33, at which S33 is zero: by Newton's method, else by halving an interval."""
        across = np.ones(len(c)) if self._seen is None else self._seen[1][2]
        for _ in range(NEWTON):
            with np.errstate(all="ignore"):
                found = self._stress(c.astype(complex), across * (1.0 + 1j * STEP), kept)[1]
                wanted: Floats = -found.real * STEP / found.imag
            if not np.isfinite(wanted).all():
                break
            uphill = np.where(found.imag > 0.0, wanted, -np.sign(found.real))
            step = np.clip(uphill, -1.0, 1.0)
            across = across * np.exp(step)
            if np.abs(step).max() < ROUNDING:
                return across
        low, high = np.full(len(c), -LARGEST), np.full(len(c), LARGEST)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            with np.errstate(all="ignore"):  # laws leave the range of numbers at its ends
                is_thin = self._stress(c, np.exp(middle), kept)[1] < 0.0
            low, high = np.where(is_thin, middle, low), np.where(is_thin, high, middle)
        return np.exp(0.5 * (low + high))

    def _invariants(self, c: Any, across: Any) -> tuple[Any, ...]:
        """Return g, g'/g, J, q'/q, I1 and I2; q is √D, and derivatives are by D."""
        square = c[:, 0, 0] * c[:, 1, 1] - c[:, 0, 1] * c[:, 1, 0]
        near = np.where(square.real < LEAST**2, LEAST**2, square)
        below = (square - near) / near
        q = np.sqrt(near) * (1.0 + below / 2.0 - below * below / 8.0)
        rate = np.sqrt(near) * (0.5 - below / 4.0) / (near * q)
        trace = c[:, 0, 0] + c[:, 1, 1]
        first, second = trace + across, square + across * trace
        j = q * np.sqrt(across)
        return j ** (-2.0 / 3.0), -2.0 / 3.0 * rate, j, rate, first, second

    def _of_laws(self, c: Any, across: Any, kept: WallMemory) -> tuple[Any, ...]:
        """Return A of the plastic strain in the plane and across, and I1 and I2 of C A."""
        flow = kept.flowed
        inside, outside = (np.eye(2), 1.0) if flow is None else (flow.inside, flow.outside)
        turned = c @ inside
        trace, wide = turned[:, 0, 0] + turned[:, 1, 1], across * outside
        square = turned[:, 0, 0] * turned[:, 1, 1] - turned[:, 0, 1] * turned[:, 1, 0]
        return inside, outside, trace + wide, square + wide * trace

    def _stress(
        self, c: Any, across: Any, kept: WallMemory = _NOTHING, *, fibred: bool = True
    ) -> tuple[Any, Any]:
        """Return S in the plane, shape (triangle, 2, 2), and S33 [Pa]; C may be complex.

        Args:
            c: C in the plane, dimensionless, shape (triangle, 2, 2).
            across: C33, dimensionless, shape (triangle,).
            kept: Internal variables of the triangles.
            fibred: Whether to include fibres.
        """
        g, of_g, j, of_q, whole, _ = self._invariants(c, across)
        one, wide, first, second = self._of_laws(c, across, kept)
        by_first, by_second, *own = self._laws.slopes(g * first, g**2 * second, g, g)
        turned = np.empty_like(c)
        turned[:, 0, 0], turned[:, 1, 1] = c[:, 1, 1], c[:, 0, 0]
        turned[:, 0, 1], turned[:, 1, 0] = -c[:, 1, 0], -c[:, 0, 1]
        # With the A of what is plastic, ∂I1/∂C = A, ∂I2/∂C = I1 A - A C A, and what g and J
        # change by.
        by_one = by_first * g + by_second * g * g * first
        by_g = by_first * g * first + 2.0 * by_second * g * g * second + sum(own) * g
        by_j = self._laws.of_volume(j, self._bulk)[1] * j
        inside = 2.0 * by_one[:, None, None] * one
        inside = inside - 2.0 * (by_second * g * g)[:, None, None] * (one @ c @ one)
        outside = 2.0 * (by_one - by_second * g * g * wide * across) * wide
        k1, k2, spread = self._fibres
        for along in np.moveaxis(self._along, 1, 0) if fibred else ():
            fourth = np.einsum("ekl,ek,el->e", c, along, along)
            e = spread * (g * whole - 3.0) + (1.0 - 3.0 * spread) * (fourth - 1.0)
            pull = np.where(e.real > 0.0, k1 * e * np.exp(k2 * e * e), 0.0)
            line = np.einsum("e,ek,el->ekl", pull * (1.0 - 3.0 * spread), along, along)
            even = pull * spread * g
            inside = inside + 2.0 * line + 2.0 * even[:, None, None] * np.eye(2)
            outside, by_g = outside + 2.0 * even, by_g + even * whole
        if kept.branches is not None:
            of = kept.branches
            pulled = np.einsum("ekl,ekl->e", c, of.inside) + across * of.outside
            by_g = by_g + 0.5 * g * pulled
            inside = inside + g[:, None, None] * of.inside
            outside = outside + g * of.outside
        inside = inside + 2.0 * (by_g * of_g + by_j * of_q)[:, None, None] * turned
        return inside, outside + (by_j - 2.0 / 3.0 * by_g) / across

    # --- what the reference needs -------------------------------------------------------------

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        kept = self._memory(velocity)
        f, c, across = self._strained(position, kept)
        stress, _ = self._stress(c, across, kept)
        if self._eta.any():
            stress = stress + self._flow(f, c, across, velocity)[0]
        push = np.einsum("e,exk,ekl,eal->eax", self._weight, f, stress, self._slope)
        np.subtract.at(to, self._nodes, push)

    def energy(self, time: float, position: Floats) -> float:
        return float(self._energies(position).sum())

    def _energies(self, position: Floats, kept: WallMemory = _NOTHING) -> Floats:
        """Return the energy of each triangle [J]; laws are integrated from the drawn state.

        Args:
            position: Of all nodes [m], shape (node, 3).
            kept: Internal variables of the triangles.
        """
        _, c, across = self._strained(position, kept)
        g, _, j, _, whole, _ = self._invariants(c, across)
        *_, first, second = self._of_laws(c, across, kept)
        total, _ = self._laws.of_volume(j, self._bulk)
        total += self._laws.energies(g * first, g * g * second, g, g)
        k1, k2, spread = self._fibres
        for along in np.moveaxis(self._along, 1, 0):
            fourth = np.einsum("ekl,ek,el->e", c, along, along)
            e = spread * (g * whole - 3.0) + (1.0 - 3.0 * spread) * (fourth - 1.0)
            total += np.where(e > 0.0, 0.5 * k1 / k2 * (np.exp(k2 * e * e) - 1.0), 0.0)
        if self.branches is not None and (of := kept.branches) is not None:
            pulled = np.einsum("ekl,ekl->e", c, of.inside) + across * of.outside
            total += 0.5 * (g * pulled - 3.0 * self.branches.sudden)
        return np.asarray(self._weight * total)

    def remembered_energy(self, position: Floats, velocity: Floats) -> float:
        """Return the excess of the energy over that of triangles without memory [J].

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        whole = self._energies(position, self._memory(velocity))
        return float((whole - self._energies(position)).sum())

    def rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of all unknowns [1/s], shape (count,).

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        kept, found = self._memory(velocity), [np.zeros(0)]
        flow = self._carried(position, kept)
        carried = None if flow is None else flow[0]
        if self.branches is not None:
            there = self._unimodular(position, kept)
            found.append(self.branches.rates(*there, velocity, carried))
        if self.plastic is not None and carried is not None:
            found.append(self.plastic.rates(carried, velocity))
        return np.concatenate(found)

    def _carried(self, position: Floats, kept: WallMemory) -> tuple[Floats, Floats] | None:
        """Return the flow M [1/s] and its dissipation [W/m³]; None if nothing yields."""
        if self.plastic is None:
            return None
        _, c, across = self._strained(position, kept)
        inside, outside = self._stress(c, across, kept, fibred=False)
        return self.plastic.flow(inside @ c, outside * across)

    def give_way(self, position: Floats, velocity: Floats, free: Indices) -> None:
        """Relax the branches of triangles at some nodes completely.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
            free: These nodes, shape (free,).
        """
        if self.branches is None:
            return
        touched = np.isin(self._nodes, free).any(axis=1)
        inside, _ = self._unimodular(position, self._memory(velocity)._replace(branches=None))
        self.branches.given_way(inside, touched, velocity)

    def _unimodular(self, position: Floats, kept: WallMemory) -> tuple[Floats, Floats]:
        """Return g C in the plane, shape (triangle, 2, 2), and across it."""
        _, c, across = self._strained(position, kept)
        g, *_ = self._invariants(c, across)
        return g[:, None, None] * c, g * across

    @property
    def breakable(self) -> Indices:
        """Return the triangles that may break, as entities, shape (triangle,)."""
        return np.zeros(0, dtype=np.int64) if self._limits is None else self._entities

    def burdens(self, position: Floats) -> Floats:
        """Return loads divided by the limits of triangles, dimensionless, shape (triangle,).

        Principal stretches are the singular values of F, whose left vectors are the axes in
        which the stress is found.
        """
        limits = self._limits
        if limits is None:
            return np.zeros(0)
        f, c, across = self._strained(position)
        axes, stretch, _ = np.linalg.svd(f, full_matrices=False)
        stress, _ = self._stress(c, across)
        turned = np.einsum("exi,exk->eik", axes, f)
        kirchhoff = np.einsum("eik,ekl,ejl->eij", turned, stress, turned)
        widest = stretch[:, 0]
        loads = (
            (widest - 1.0) / limits.strain,
            np.linalg.eigvalsh(kirchhoff)[:, -1] / widest / limits.stress,
            self._energies(position) / (limits.toughness * self._side),
        )
        return np.asarray(np.max(loads, axis=0))

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that flow and relaxation lose [W]."""
        lost, kept = 0.0, self._memory(velocity)
        if self.branches is not None:
            each = self.branches.lost(*self._unimodular(position, kept), velocity)
            lost = float(self._weight @ each)
        if (flow := self._carried(position, kept)) is not None:
            lost += float(self._weight @ flow[1])
        if not self._eta.any():
            return lost
        stress, rate = self._flow(*self._strained(position, kept), velocity)
        return lost + float(np.einsum("e,ekl,ekl->", self._weight, stress, rate))

    def _flow(
        self, f: Floats, c: Floats, across: Floats, velocity: Floats
    ) -> tuple[Floats, Floats]:
        """Return the viscous S [Pa] and the rate of Green's strain [1/s].

        It is C⁻¹ (2 η J dev D) C⁻¹ with the rate of strain D, whose part across the plane is
        that of a wall of Poisson's ratio ν, and acts by what is left of D within it.
        """
        rate = np.einsum("exk,eax,eal->ekl", f, velocity[self._nodes], self._slope)
        rate = 0.5 * (rate + rate.swapaxes(1, 2))
        square = np.maximum(np.linalg.det(c), LEAST**2)[:, None, None]
        turned = np.trace(c, axis1=1, axis2=2)[:, None, None] * np.eye(2) - c
        poisson = (3.0 * self._bulk - 2.0 * self._shear) / (
            6.0 * self._bulk + 2.0 * self._shear
        )
        inverse = turned / square
        grown = np.einsum("ekl,ekl->e", inverse, rate)
        thinner = -poisson / (1.0 - poisson)
        third = (1.0 + thinner) * grown / 3.0
        # Virtual power: dev D in the plane, and what goes across with it.
        inside = inverse @ rate @ inverse - third[:, None, None] * inverse
        outside = (thinner * grown - third) * thinner
        *_, j, _, _, _ = self._invariants(c, across)
        thick = (2.0 * self._eta * j)[:, None, None]
        return thick * (inside + outside[:, None, None] * inverse), rate

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        start = self._start
        f, c, across = self._strained(position, start)
        stress, _ = self._stress(c, across, start)
        inner = np.einsum("e,eak,ekl,ebl->eab", self._weight, self._slope, stress, self._slope)
        values = np.einsum("eab,xy->eaxby", inner, np.eye(3))
        thicker = self._stress(c.astype(complex), across + 1j * STEP, start)[1].imag / STEP
        for k, m in _PAIRS:
            moved = c.astype(complex)
            moved[:, k, m] += 1j * STEP
            if k != m:
                moved[:, m, k] += 1j * STEP
            out_of_plane = self._stress(moved, across.astype(complex), start)[1].imag / STEP
            follows = across - 1j * STEP * out_of_plane / thicker
            change = self._stress(moved, follows, start)[0].imag / STEP
            by_place = np.einsum("ex,ea->eax", f[..., k], self._slope[..., m])
            by_place = by_place + np.einsum("ex,ea->eax", f[..., m], self._slope[..., k])
            if k == m:
                by_place *= 0.5
            push = np.einsum("exk,ekl,eal->eax", f, change, self._slope)
            values += np.einsum(
                "e,eax,eby->eaxby", self._weight, push, by_place * (1 + (k == m))
            )
        return assembled(values, number[self._nodes], size)
