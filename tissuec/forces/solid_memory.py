"""Branches and yielding of solid elements: stress that relaxes, flow, and their derivatives.

A branch k is a neo-Hookean solid and a liquid in series, in parallel with the solid itself. At
each point a symmetric tensor Ci stores how far the liquid has flowed; it begins as 1. With C =
FᵀF, the unimodular C' = g(J) C and A = det(Ci)^(1/3) Ci⁻¹, a branch stores per volume

    E = μk/2 (tr(C' A) - 3),    P = μk (g F A + g'/2 tr(C A) cof F),

and gives way by

    dCi/dt = (C' - tr(C' A)/3 Ci)/τ.

At small strain, this is the dashpot of a Maxwell element: under a constant strain, the stress
falls as exp(-t/τ). The volume of Ci enters neither E nor P, and returns to 1. The dissipation,
with X = C' A,

    -∂E/∂Ci : dCi/dt = μk/2τ det(Ci)^(-1/3) tr((X - tr(X)/3)²),

is never negative, as X has real eigenvalues. (J. C. Simo, Comput. Meth. Appl. Mech. Eng.
60:153, 1987; A. Lion, Acta Mechanica 123:1, 1997; A. V. Shutov, R. Landgraf, J. Ihlemann,
Comput. Meth. Appl. Mech. Eng. 265:213, 2013.)

Ci is kept in the velocities of hidden nodes; see ``forces.element_memory``.

Solid elements that yield: von Mises' limit of stress, and the flow above it.

F = Fe Fp; elements that yield store the energy of Fe, and Fp is the shape without stress. Their
laws do not depend on directions, so that Cp = FpᵀFp is enough: it begins as 1, and with
A = det(Cp)^(1/3) Cp⁻¹ the energy is that of a law in the invariants I1 = tr(C A) and
I2 = (I1² - tr(C A C A))/2 instead of those of C. Branches k (``forces.solid_memory``) are in
series with the flow; fibres and viscosity are in parallel with it. With the Kirchhoff stress τ
of law and branches, and its deviator s,

    σ = √(3/2) |s|,    ε' = max(0, σ - Y)/η,    λ = 3 ε'/2σ,

plastic strain grows by λ s in space, so that a bar lengthens by ε' (P. Perzyna, Adv. Appl.
Mech. 9:243, 1966, of a Bingham solid). Drawn back, this is N = F⁻¹ s F = dev(Pᵀ F), P being the
stress of law and branches, and

    dCp/dt = λ (Cp N + Nᵀ Cp),    dCi/dt = … + λ (Ci N + Nᵀ Ci).

No inverse is taken, so that elements that are inside out have rates, too. Flow changes no
volume: tr N = 0. The dissipation, λ tr(N²) = σ ε', is never negative. (J. C. Simo, Comput.
Meth. Appl. Mech. Eng. 99:61, 1992; J. Lubliner, Plasticity Theory, 1990.)

The response of elements that yield to strain and to the tensors that they remember.

The formulas are those of ``forces.solid_memory`` and ``forces.solid_memory``; here they are
functions of F, Cp and Ci alone, for differences of implicit steps.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tissuec.forces.element_memory import (
    COLUMNS,
    ROWS,
    SIX,
    Branches,
    ElementYield,
    unimodular_inverse,
)
from tissuec.forces.elements_kernel import LEAST
from tissuec.forces.memory import MemoryTangents
from tissuec.forces.solid_strain import EnergySlopes, SolidStrain, outer
from tissuec.model.network import Floats, Indices


class SolidBranches(Branches, frozen=True):
    """Branches of solid elements, each of which keeps Ci at each point."""

    def remembered(self, velocity: Floats, points: int) -> "RelaxingStress":
        """Return the stress of the branches for frozen internal variables.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        inverse = unimodular_inverse(self.tensors(velocity, points))
        weight = self.shear[..., None, None, None] * inverse
        return RelaxingStress(weight.sum(axis=-5), self.sudden)

    def fastest(self, strain: SolidStrain, velocity: Floats) -> tuple[float, Floats]:
        """Return the largest rate at which any branch gives way [1/s], and Σ μk tr(C' A).

        The latter has the shape (element, point) [Pa].

        Args:
            strain: At the points of all elements.
            velocity: Of all nodes [m/s], shape (node, 3).
        """
        inverse = unimodular_inverse(self.tensors(velocity, strain.j.shape[-1]))
        right = strain.f.swapaxes(-1, -2) @ strain.f
        trace = strain.g * np.einsum("...kl,...kl->...", right, inverse)
        rates = np.where(self.keeps[..., None], trace / (3.0 * self.time[..., None]), 0.0)
        return float(rates.max()), (self.shear[..., None] * trace).sum(axis=0)


class RelaxingStress:
    """Branches that do not give way: energy per volume Σ μk/2 (g tr(C A) - 3).

    Args:
        weight: Σ μk A [Pa], shape (…, element, point, 3, 3).
        shear: Σ μk [Pa], shape (element,).
    """

    def __init__(self, weight: Floats, shear: Floats):
        self._weight, self._shear = weight, shear

    def some(self, items: Indices) -> "RelaxingStress":
        """Return those of some elements, by indices of shape (n,)."""
        return RelaxingStress(self._weight[..., items, :, :, :], self._shear[items])

    def _trace(self, strain: SolidStrain) -> tuple[Floats, Floats]:
        """Return F W with the weight W, and tr(C W)."""
        turned = strain.f @ self._weight
        return turned, np.einsum("...xk,...xk->...", strain.f, turned)

    def energy(self, strain: SolidStrain) -> Floats:
        """Return the energy per volume [Pa], shape (…, point)."""
        _, trace = self._trace(strain)
        return 0.5 * strain.g * trace - 1.5 * self._shear[:, None]

    def cauchy(self, strain: SolidStrain) -> Floats:
        """Return the stress [Pa], shape (…, point, 3, 3); see ``SolidStrain``."""
        turned, trace = self._trace(strain)
        piola = strain.g[..., None, None] * turned
        piola = piola + (0.5 * strain.by_j * trace)[..., None, None] * strain.cofactors
        volume = np.maximum(strain.j, LEAST)[..., None, None]
        return piola @ strain.f.swapaxes(-1, -2) / volume

    def second_derivatives(self, strain: SolidStrain) -> Floats:
        """Return ∂²/∂F∂F of the energy [Pa], shape (…, point, 9, 9)."""
        turned, trace = self._trace(strain)
        none = np.zeros_like(trace)
        of_volume = EnergySlopes(
            none, none, none, none, none,
            0.5 * strain.by_j * trace, 0.5 * strain.by_j_twice * trace,
        )  # fmt: skip
        found = strain.second_derivatives(of_volume)
        flat = turned.reshape(*turned.shape[:-2], 9)
        both = outer(strain.by_j, flat, strain.cofactors.reshape(flat.shape))
        found += both + both.swapaxes(-1, -2)
        weight = strain.g[..., None, None] * self._weight
        alike = np.eye(3)[:, None, :, None] * weight[..., None, :, None, :]
        return found + alike.reshape(*weight.shape[:-2], 9, 9)


def branch_tangents(
    branches: SolidBranches,
    deformation: Floats,
    velocity: Floats,
    nodes: Indices,
    gradients: Floats,
    weight: Floats,
) -> MemoryTangents:
    """Return the derivatives of branches, one item for each branch at each point.

    Args:
        branches: Of the elements.
        deformation: F at the points, shape (element, point, 3, 3).
        velocity: Of all nodes [m/s], shape (node, 3).
        nodes: Of the elements, shape (element, node).
        gradients: Of the shape functions [1/m], shape (element, point, node, 3).
        weight: Volumes of the points [m³], shape (element, point).
    """
    points = deformation.shape[1]
    tensors, places = branches.tensors(velocity, points), branches.places(points)
    parts: list[MemoryTangents] = []
    for branch, slot in enumerate(branches.slot):
        items = np.flatnonzero(slot >= 0)
        strain = SolidStrain(deformation[items])
        pull, by_strain, giving = _derivatives(strain, tensors[branch, items])
        rate = branches.rate[branch, items, None, None, None, None]
        pace = 1.0 / branches.time[branch, items, None, None, None]
        strength = branches.shear[branch, items, None] * weight[items]
        steep = gradients[items]
        by_position = rate * np.einsum("eqvxk,eqak->eqvax", by_strain, steep)
        push = -np.einsum("eq,eqvxk,eqak->eqaxv", strength, pull, steep) / rate
        parts.append(
            MemoryTangents(
                slots=places[branch, items].reshape(-1, SIX),
                nodes=np.repeat(nodes[items], points, axis=0),
                giving=(pace * giving).reshape(-1, SIX, SIX),
                by_position=(pace[..., None] * by_position).reshape(-1, *by_position.shape[2:]),
                pull=push.reshape(-1, *push.shape[2:]),
            )
        )
    return MemoryTangents(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _derivatives(strain: SolidStrain, tensors: Floats) -> tuple[Floats, Floats, Floats]:
    """Return derivatives of P / μk and of τ dCi/dt, by the six numbers of Ci and by F.

    Args:
        strain: At some points.
        tensors: Ci there, dimensionless, shape (…, 3, 3).

    Returns:
        ∂P/∂Ci, shape (…, 6, 3, 3), ∂(dCi/dt)/∂F, shape (…, 6, 3, 3), and -∂(dCi/dt)/∂Ci, shape
        (…, 6, 6); all dimensionless.
    """
    f, g, by_j = strain.f, strain.g[..., None, None], strain.by_j[..., None, None]
    right = f.swapaxes(-1, -2) @ f
    inverse = unimodular_inverse(tensors)  # A
    determinant = np.linalg.det(tensors)[..., None, None]
    plain = inverse / np.cbrt(determinant)  # Ci⁻¹
    trace = np.einsum("...kl,...kl->...", right, inverse)  # of C A
    # Changes of Ci, one for each number, and of A by it.
    six = np.zeros((SIX, 3, 3))
    six[np.arange(SIX), ROWS, COLUMNS] = six[np.arange(SIX), COLUMNS, ROWS] = 1.0
    grown = np.einsum("...kl,vkl->...v", plain, six) / 3.0
    a = inverse[..., None, :, :]
    changed = grown[..., None, None] * a - a @ six @ plain[..., None, :, :]
    traces = np.einsum("...kl,...vkl->...v", right, changed)
    pull = g[..., None] * (f[..., None, :, :] @ changed)
    pull = pull + (0.5 * by_j)[..., None] * (
        traces[..., None, None] * strain.cofactors[..., None, :, :]
    )
    # d(dCi/dt) = -(tr(C' dA) Ci + tr(C' A) dCi)/3 at the same strain.
    flow = g[..., None] * (
        traces[..., None, None] * tensors[..., None, :, :] + trace[..., None, None, None] * six
    )
    giving = (flow / 3.0)[..., ROWS, COLUMNS].swapaxes(-1, -2)
    # By F: dC' = g (dFᵀ F + Fᵀ dF) + C dg, of which the trace with A is taken off.
    cofactors = by_j * strain.cofactors
    stretched = g * 2.0 * (f @ inverse) + trace[..., None, None] * cofactors  # of tr(C' A)
    moved = g[..., None, None] * _by_deformation(f)
    moved = moved + right[..., :, :, None, None] * cofactors[..., None, None, :, :]
    moved = moved - tensors[..., :, :, None, None] * stretched[..., None, None, :, :] / 3.0
    return pull, moved[..., ROWS, COLUMNS, :, :], giving


def _by_deformation(f: Floats) -> Floats:
    """Return ∂(FᵀF)_kl/∂F_xm = δ_km F_xl + F_xk δ_lm, shape (…, 3, 3, 3, 3) by k, l, x, m."""
    half = np.einsum("km,...xl->...klxm", np.eye(3), f)
    return half + half.swapaxes(-4, -3)


class SolidYield(ElementYield, frozen=True):
    """Yielding of solid elements, each of which keeps Cp at each point."""

    def plastic(self, velocity: Floats, points: int) -> "PlasticDeformation":
        """Return the plastic deformation of the elements.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        return PlasticDeformation(self.tensors(velocity, points)[..., 0, :, :, :, :])


class PlasticDeformation:
    """The plastic deformation of elements.

    Args:
        tensors: Cp, dimensionless, shape (…, element, point, 3, 3).
        root: A^(1/2) if it is known.
    """

    def __init__(self, tensors: Floats, root: Floats | None = None):
        self._tensors = tensors
        if root is None:
            values, ways = np.linalg.eigh(unimodular_inverse(tensors))
            widths = np.sqrt(np.maximum(values, 0.0))[..., None, :]
            root = (ways * widths) @ ways.swapaxes(-1, -2)
        self._root = root

    def some(self, items: Indices) -> "PlasticDeformation":
        """Return the yielding of some elements, by indices of shape (n,)."""
        tensors, root = (
            each[..., items, :, :, :] for each in (self._tensors, self._root)
        )  # fmt: skip
        return PlasticDeformation(tensors, root)

    @property
    def equivalent(self) -> Floats:
        """Return √(2/3) |log Cp/2|, dimensionless, shape (…, element, point).

        For a bar, it is the logarithm of its permanent stretch.
        """
        logs = 0.5 * np.log(np.linalg.eigvalsh(self._tensors))
        logs -= logs.mean(axis=-1, keepdims=True)
        return np.sqrt(2.0 / 3.0 * (logs**2).sum(axis=-1))

    def elastic(self, strain: SolidStrain) -> SolidStrain:
        """Return F A^(1/2), which has the invariants, stress and volume of Fe.

        Args:
            strain: F at the points.
        """
        return SolidStrain(strain.f @ self._root)

    def drawn_back(self, stiff: Floats) -> Floats:
        """Return ∂²/∂F∂F of an energy from its derivatives by F A^(1/2).

        Args:
            stiff: The latter [Pa], shape (…, point, 9, 9).
        """
        full = stiff.reshape(*stiff.shape[:-2], 3, 3, 3, 3)
        root = self._root
        full = np.einsum("...ikjl,...km,...ln->...imjn", full, root, root, optimize=True)
        return full.reshape(stiff.shape)


NEVER = 1e300  # a yield stress instead of an infinite one [Pa]


class YieldResponse(NamedTuple):
    """Elements that yield, and relax if they have branches.

    Attributes:
        yielding: Of the elements.
        branches: Of the elements; None without any.
        slopes: Given both isochoric invariants, shape (element, point), returns the derivatives
            μ ∂ψ/∂i by them [Pa].
    """

    yielding: SolidYield
    branches: SolidBranches | None
    slopes: Callable[[Floats, Floats], tuple[Floats, Floats]]

    def __call__(self, f: Floats, tensors: Floats) -> tuple[Floats, Floats]:
        """Return P of law and branches but for the pressure, and the rates of tensors.

        Args:
            f: F, shape (element, point, 3, 3).
            tensors: Cp, and then Ci of each branch, shape (tensor, element, point, 3, 3).

        Returns:
            [Pa], shape (element, point, 3, 3), and [1/s], shape of ``tensors``.
        """
        strain, inverse = SolidStrain(f), unimodular_inverse(tensors)
        piola, rates = self._of_law(strain, inverse[0]), np.zeros_like(tensors)
        for k in range(len(tensors) - 1):
            assert self.branches is not None
            shear, time = self.branches.shear[k, :, None], self.branches.time[k, :, None]
            right, own = f.swapaxes(-1, -2) @ f, inverse[1 + k]
            trace = np.einsum("...kl,...kl->...", right, own)
            piola = piola + _times(shear * strain.g, f @ own)
            piola = piola + _times(0.5 * shear * strain.by_j * trace, strain.cofactors)
            excess = _times(strain.g, right) - _times(strain.g * trace / 3.0, tensors[1 + k])
            rates[1 + k] = _times(1.0 / time, excess)
        driving = piola.swapaxes(-1, -2) @ f  # N, but for its trace
        third = np.trace(driving, axis1=-2, axis2=-1) / 3.0
        driving = driving - _times(third, np.eye(3))
        square = np.einsum("...ij,...ji->...", driving, driving)
        size = np.sqrt(1.5 * np.maximum(square, 0.0))
        over = np.maximum(size - np.minimum(self.yielding.limit, NEVER)[:, None], 0.0)
        pace = 1.5 * over / np.where(size > 0.0, size, 1.0) / self.yielding.viscosity[:, None]
        carried = tensors @ driving
        return piola, rates + _times(pace, carried + carried.swapaxes(-1, -2))

    def _of_law(self, strain: SolidStrain, inverse: Floats) -> Floats:
        """Return P of the law but for its pressure [Pa]; ``inverse`` is A."""
        g, turned = strain.g, strain.f @ inverse
        left = turned @ strain.f.swapaxes(-1, -2)  # with the invariants of Fe Feᵀ
        i1 = np.trace(left, axis1=-2, axis2=-1)
        i2 = 0.5 * (i1 * i1 - np.einsum("...ij,...ij->...", left, left))
        first, second = self.slopes(g * i1, g * g * i2)
        piola = _times(2.0 * (g * first + g * g * second * i1), turned)
        piola = piola - _times(2.0 * g * g * second, left @ turned)
        by_j = strain.by_j * (first * i1 + 2.0 * g * second * i2)
        return piola + _times(by_j, strain.cofactors)


def _times(factor: Floats, matrices: Floats) -> Floats:
    return factor[..., None, None] * matrices
