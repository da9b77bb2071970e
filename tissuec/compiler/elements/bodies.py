"""Bodies made of finite elements: what their elements and nodes are made of.

A tissue of Young's modulus E and Poisson's ratio ν has the shear modulus E/(2(1 + ν)) and the
bulk modulus E/(3(1 - 2ν)). Where an edge of elements is cut, these are gone.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NoReturn, cast

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing, refuse_sizes
from tissuec.compiler.elements.branches import branches_of
from tissuec.compiler.elements.inertia import turning_masses
from tissuec.compiler.elements.limits import LimitReader
from tissuec.compiler.elements.regions import by_shape
from tissuec.compiler.elements.yielding import yielding_of
from tissuec.compiler.materials.cutting_resistance import resistance_of_parts
from tissuec.compiler.materials.tissue_parts import (
    OF_FIBRES,
    Material,
    TissueParts,
    part_numbers,
)
from tissuec.core.arrays import cross
from tissuec.core.errors import Note
from tissuec.core.hints import leaving_out
from tissuec.core.source import Span
from tissuec.geometry.elements import SHAPES
from tissuec.laws import MODULUS, STRAIN, stress_in
from tissuec.laws.formula import Constant, replaced
from tissuec.laws.solid import SolidLaw
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.laws.uniaxial import OfTension
from tissuec.meshes.elements import node_shares
from tissuec.meshes.generators import ElementMesh
from tissuec.meshes.generators.round_solids import ThickTube, along_and_around
from tissuec.model.inelastic import CONSTANTS, LIMIT, VISCOSITY
from tissuec.model.network import Explained, Floats, Origin, Provenance
from tissuec.scene.bodies.elements import note_of, refuse
from tissuec.scene.bodies.fibres import AXIAL, SECOND_FIBRES, Direction, Helix
from tissuec.scene.bodies.prestress import PRESTRESS, examples
from tissuec.scene.model import AssignedQuantity, PrestressDirection, Tissue
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.laws import SOLID_LAW
from tissuec.scene.tissues.quantities import (
    FIBRE_MODULUS,
    POISSONS_RATIO,
    QUANTITIES,
    RETARDATION_TIME,
    YOUNGS_MODULUS,
)
from tissuec.script.verbs.cut_surface import Blade

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.forces.solids.solid_strain import Prestretch, SolidFibres
    from tissuec.forces.surfaces.membranes import Membranes

STRAIGHT = 1e-9  # stiffening of fibres that have none, by which energies are divided
POISSON = 0.25  # of tissues that give none
#: Of tissues with a curve of stress that give none: 556 times as stiff against a change of
#: volume as in tension at rest, so that curves that become steeper are followed, too.
INCOMPRESSIBLE = 0.4997
#: Quantities of springs that elements do not have.
_OF_SPRINGS = (*CONSTANTS, LIMIT, VISCOSITY)


class ElementReader:
    """Gives the elements of one drawing what tissues say; see also ``MembraneReader``.

    Args:
        drawing: Of a body that is made of elements.
        findings: Takes diagnostics.
        planes: Of symmetry of the scene.
    """

    def __init__(self, drawing: Drawing, findings: Findings, planes: Sequence[Blade] = ()):
        assert drawing.body.elements is not None and drawing.element_part is not None
        self.drawing, self.body, self.findings = drawing, drawing.body, findings
        self.planes = planes
        self.made, self.part = drawing.body.elements, drawing.element_part
        self.parts = TissueParts(drawing, findings)
        self._note = (note_of(self.made),)
        self.limits = LimitReader(
            self.body, self.parts, self.part, drawing.mesh.elements, findings
        )
        for number in part_numbers(self.part):
            self._refuse_springs(self.parts.materials[number])

    def mass(self, *, turns: bool = True) -> Explained:
        """Return the masses of nodes [kg], and where these come from.

        Args:
            turns: Whether they have the moments of the elements.
        """
        return self._mass(self._turning if turns else self._lumped)

    def weights(self) -> Floats:
        """Return the weight of each node as a mass [kg], shape (node,)."""
        return self._mass(self._lumped)[0]

    def elements(self) -> "tuple[SolidElements | Membranes, ...]":
        """Return the elements shape by shape, with nodes and entities counted in the body."""
        laws = tuple(map(self._law, self.parts.materials))
        young, ratio = self._constants(laws)
        shear, bulk = young / (2.0 * (1.0 + ratio)), young / (3.0 * (1.0 - 2.0 * ratio))
        from tissuec.forces.solids.bent_elements import kind_of
        from tissuec.forces.solids.elements import SolidMaterial

        viscosity = self._checked(shear, bulk)
        material = SolidMaterial(
            shear, bulk, viscosity, self.part.astype(np.int64), laws,
            self._fibres(), self._prestretch(), self.limits.limits,
            branches_of(self.parts, self.part, shear, 3),
            yielding_of(self.parts, self.part, 3),
        )  # fmt: skip
        mesh, name, span = self.drawing.mesh, self.body.name, self.made.span
        found: list[SolidElements] = []
        first = 0
        for one in mesh.elements:
            own, shape = np.arange(first, first + len(one.nodes)), SHAPES[one.shape]
            parts = name, shape, one.nodes, mesh.position, material.some(own), first, span
            found.append(kind_of(shape).of(*parts))
            first += len(own)
        return tuple(found)

    @property
    def resistance(self) -> Floats:
        """Return the energy by area that blades need [J/m²], shape (element,)."""
        return resistance_of_parts(self.parts)[self.part]

    def _checked(self, shear: Floats, bulk: Floats) -> Floats:
        """Return viscosities [Pa s], shape (element,); reject what is too large to compute."""
        viscosity = self._viscosity(shear)
        moduli = np.concatenate([shear, bulk, viscosity])
        refuse_sizes(self.body, {"modulus or viscosity": moduli}, self.findings)
        return viscosity

    # --- quantities of parts ------------------------------------------------------------------

    def _constants(self, laws: Sequence[SolidLaw]) -> tuple[Floats, Floats]:
        """Return Young's modulus [Pa] and Poisson's ratio, shape (element,).

        Args:
            laws: Of each part.
        """
        of_curve = [isinstance(law, OfTension) for law in laws]
        default = np.where(np.array(of_curve)[self.part], INCOMPRESSIBLE, POISSON)
        said = self._each(POISSONS_RATIO, np.nan)
        return self._each(YOUNGS_MODULUS), np.where(np.isnan(said), default, said)

    def _refuse_springs(self, material: Material) -> None:
        """Report what a tissue says of springs that elements do not have."""
        if material.tissue is None:
            return
        given = material.tissue.given
        for key in _OF_SPRINGS:
            one = given.get(key)
            if one and one.value not in (one.quantity.default, one.quantity.none):
                refuse(one.quantity.name, one.span, self.made, self.findings)
        for word, law in material.tissue.laws.items():
            if word != SOLID_LAW and stress_in(law.formula) is None:
                refuse(f"a {word}", law.span, self.made, self.findings)

    def _fibres(self) -> "SolidFibres | None":
        """Return the families of fibres of the elements; None without any."""
        self.parts.refuse_idle_fibres()
        young = self._each(YOUNGS_MODULUS)
        modulus = self._each(FIBRE_MODULUS, np.nan)
        for number in part_numbers(self.part):
            material = self.parts.materials[number]
            if material.tissue is None:
                continue
            given = material.tissue.given
            along = given.get(FIBRE_MODULUS)
            for name in OF_FIBRES:
                if along is None and (idle := given.get(name)) is not None:
                    self._needs_modulus(idle)
            if along is not None:
                own = self.part == number
                if (modulus[own] < young[own]).any():
                    self.parts.refuse_soft_fibres(along)
                if self.body.fibres is None:
                    self._needs_direction(along)
        if np.isnan(modulus).all():
            return None
        added = np.nan_to_num(young * (modulus / young - 1.0))
        families = {"fibres": self.body.fibres, SECOND_FIBRES: self.body.second_fibres}
        along = [self._along(k, one) for k, one in families.items() if one is not None]
        from tissuec.forces.solids.solid_strain import SolidFibres

        stiffening, spread = (self._each(name, 0.0) for name in OF_FIBRES)
        # At rest a fibre of the strain ε has e = 2 (1 - 3 κ) ε.
        stiffness = 0.25 * added / (1.0 - 3.0 * spread) ** 2
        every = np.stack(along, axis=1)
        return SolidFibres(every, stiffness, np.maximum(stiffening, STRAIGHT), spread)

    def _along(self, name: str, direction: Direction) -> Floats:
        """Return the direction of a family of fibres, shape (element, 3).

        Args:
            name: The entry.
            direction: As it is written.
        """
        if isinstance(direction, str | Helix):
            mesh = self.body.mesh
            if not isinstance(mesh, ThickTube):
                self.refuse_fibres(name, direction)
            return turned_around(*self._around(mesh), direction)
        return np.broadcast_to(direction, (len(self.part), 3))

    def _around(self, tube: ThickTube) -> tuple[Floats, Floats]:
        """Return the directions along and around a tube, shape (element, 3) each."""
        position = self.drawing.mesh.position
        if not tube.is_even or self.body.whole_placement is not None:
            (cells,) = self.drawing.mesh.elements
            return along_and_around(position[cells.nodes[:, :8]])
        start, end = (np.asarray(point, dtype=float) for point in tube.axis)
        axis = (end - start) / np.linalg.norm(end - start)
        centre = np.concatenate([position[e.nodes].mean(1) for e in self.drawing.mesh.elements])
        ahead = cross(np.broadcast_to(axis, centre.shape), centre - start)
        ahead /= np.linalg.norm(ahead, axis=1)[:, None]
        return np.broadcast_to(axis, centre.shape), ahead

    def refuse_fibres(self, name: str, direction: str | Helix) -> NoReturn:
        """Reject fibres that only a tube has; arguments as for ``_along``."""
        self.findings.reject(
            "TIS309",
            f"{self.body.name} cannot have {direction} fibres: only a tube can",
            self.body.places[name],
            hint="write a direction, such as fibres = (1, 0, 0)",
        )

    def _prestretch(self) -> "Prestretch | None":
        """Return the prestretch of the elements as drawn; None without prestress."""
        given = self.parts.found(PRESTRESS)
        used = [given[number] for number in part_numbers(self.part)]
        stressed = [one for one in used if one is not None and (one.value or one.formula)]
        direction = self.body.prestress
        if direction is not None:
            self.require_prestress()
        if not stressed:
            return None
        if direction is None:
            direction = self._along_fibres(stressed[0])
        from tissuec.forces.solids.solid_strain import Prestretch

        share = self.parts.at_elements(given, 0.0)
        # Without stress, lengths are shorter by this part, like those of springs.
        return Prestretch(direction.axis, direction.is_across, 1.0 / (1.0 - share))

    def require_prestress(self) -> None:
        """Reject a direction of prestress without any prestress."""
        given = self.parts.found(PRESTRESS)
        if all(given[number] is None for number in part_numbers(self.part)):
            self.findings.reject(
                "TIS306",
                f"the direction of prestress of {self.body.name} has no effect: its tissue has "
                "no prestress",
                self.body.places[PRESTRESS],
                hint="write prestress = 5 % in the tissue or in a region, or remove it",
            )

    def _along_fibres(self, given: AssignedQuantity) -> PrestressDirection:
        """Return the direction of the only fibres of the body; reject a body without.

        Args:
            given: The prestress that needs a direction.
        """
        fibres = self.body.fibres
        if isinstance(fibres, np.ndarray) and self.body.second_fibres is None:
            return PrestressDirection(fibres)
        several = "" if fibres is None else ", because it has two families of fibres"
        self.findings.reject(
            "TIS304",
            f"{self.body.name} needs the direction of its prestress{several}",
            self.body.span,
            hint=f"write {examples()}",
            notes=(Note("required by this entry", given.span),),
        )

    def _needs_modulus(self, given: AssignedQuantity) -> None:
        self.findings.reject(
            "TIS304",
            f"a {given.quantity.name} needs a fibre modulus",
            given.span,
            hint="write a fibre modulus, which is Young's modulus along the fibres",
            notes=(Note(f"used by {self.body.name}", self.body.span),),
        )

    def _needs_direction(self, given: AssignedQuantity) -> None:
        self.findings.reject(
            "TIS304",
            f'{self.body.name} needs "fibres": the direction of its fibres',
            self.body.span,
            hint="for example: fibres = (1, 0, 0)",
            notes=(Note("required by this entry", given.span),),
        )

    def _law(self, material: Material) -> SolidLaw:
        """Return the law of a part, also from a curve of stress."""
        if material.tissue is None:
            return NeoHookean()
        solid, curve = (material.tissue.laws.get(word) for word in (SOLID_LAW, "spring law"))
        if solid is not None and curve is not None and stress_in(curve.formula) is not None:
            self.findings.reject(
                "TIS306",
                "a solid law and a curve of stress exclude each other",
                solid.span,
                hint=leaving_out("remove one of them", solid.span, curve.span),
                notes=(Note("the curve of stress", curve.span),),
            )
        return law_of(material.tissue)[0]

    def _each(self, key: str, default: float | None = None) -> Floats:
        """Return a quantity of each element in its SI unit, shape (element,).

        Args:
            key: Of the quantity.
            default: Of parts whose tissue gives none; None if it is needed.
        """
        given = [m.tissue and m.tissue.given.get(key) for m in self.parts.materials]
        for number in part_numbers(self.part):
            if given[number] is None and default is None:
                self.parts.missing(key, self.parts.materials[number], *self._note)
        return self.parts.at_elements(given, np.nan if default is None else default)

    def _viscosity(self, shear: Floats) -> Floats:
        """Return the viscosity of each element [Pa s], shape (element,); zero without any.

        Args:
            shear: Shear modulus [Pa], shape (element,).
        """
        given = self.parts.found("viscosity")
        found = self.parts.at_elements(given, 0.0)
        for number in part_numbers(self.part):
            one = given[number]
            if one is None:
                continue
            if not one.quantity.is_of_matter:
                self._refuse_viscosity(one)
            if one.quantity is QUANTITIES[RETARDATION_TIME]:
                found[self.part == number] *= shear[self.part == number]
        return found

    def _refuse_viscosity(self, given: AssignedQuantity) -> None:
        self.findings.reject(
            "TIS306",
            "the viscosity of each spring is not available for elements",
            given.span,
            hint="write a retardation time or a shear viscosity in the tissue instead",
            notes=(Note(f"used by {self.body.name}", self.body.span), *self._note),
        )

    # --- masses -------------------------------------------------------------------------------

    def _mass(self, spread: Callable[[Floats], Floats]) -> Explained:
        """Return the mass of each node [kg], shape (node,).

        Each element has the mass that its density gives, or the part of a mass that its volume
        is.

        Args:
            spread: Returns masses of nodes for densities of elements.
        """
        node_part, even = self.drawing.part, np.ones(len(self.part))
        self.density = None
        if self.body.mass is not None:
            known = Provenance(
                np.zeros_like(node_part), (Origin(self.body.places["mass"], "written"),)
            )
            volume = spread(even)
            return self.body.mass * volume / volume.sum(), known
        used = np.concatenate([node_part, self.part])
        given = self.parts.given("mass", used)
        origins = tuple(
            Origin(g.span, g.how) if g else Origin(self.body.span, "none") for g in given
        )
        is_dense = np.array([g is not None and g.quantity.is_of_matter for g in given])
        density = np.where(is_dense[self.part], self.parts.at_elements(given, 0.0), 0.0)
        values = spread(density)
        if is_dense[self.part].all() and (density != density[0]).any():
            self.density = density / density[0]
        for number, one in enumerate(given):
            if one is not None and not is_dense[number]:
                own = node_part == number
                values[own] = one.value
                if one.spread == "whole body":
                    volume = spread(even)
                    values[own] *= volume[own] / volume.sum()
        return values, Provenance(node_part, origins)

    def _turning(self, density: Floats) -> Floats:
        """Return the mass of nodes [kg], with the moments of the elements, shape (node,).

        Args:
            density: Of elements [kg/m³], shape (element,).
        """
        return turning_masses(self.drawing.mesh, density, self._lumped(density), self.planes)

    def _lumped(self, density: Floats) -> Floats:
        """Return the mass of nodes [kg], shape (node,).

        Args:
            density: Of elements [kg/m³], shape (element,).
        """
        mesh = self.drawing.mesh
        found = np.zeros(len(mesh.position))
        for one, each in zip(mesh.elements, by_shape(density, mesh), strict=True):
            share = each[:, None] * self._shares(one)
            found += np.bincount(one.nodes.ravel(), share.ravel(), len(found))
        return found

    def _shares(self, elements: ElementMesh) -> Floats:
        """Return the volume that each node has of each element [m³], shape (element, node)."""
        return node_shares(SHAPES[elements.shape], self.drawing.mesh.position[elements.nodes])


def law_of(tissue: Tissue) -> tuple[SolidLaw, Span]:
    """Return the solid law of a tissue, also from a curve of stress, and its span."""
    solid, curve = tissue.laws.get(SOLID_LAW), tissue.laws.get("spring law")
    stress = None if curve is None else stress_in(curve.formula)
    if curve is not None and stress is not None:
        modulus = tissue.given[YOUNGS_MODULUS].value
        known = {"e": STRAIN, "rest": Constant(1.0), MODULUS.name: Constant(modulus)}
        return OfTension(replaced(stress, known), modulus), curve.span
    if solid is not None:
        return cast(SolidLaw, solid.law), solid.span
    return NeoHookean(), tissue.span


def turned_around(axis: Floats, ahead: Floats, direction: str | Helix) -> Floats:
    """Return the direction of fibres in a tube, dimensionless, shape (element, 3).

    Args:
        axis: Unit vectors along the tube, shape (element, 3).
        ahead: Unit vectors around it by the right-hand rule, shape (element, 3).
        direction: How the fibres run.
    """
    if isinstance(direction, Helix):
        return np.cos(direction.angle) * ahead + np.sin(direction.angle) * axis
    return axis if direction == AXIAL else ahead
