"""What breaks the elements of bodies that may rupture."""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.materials.tissue_parts import (
    NOT_ALLOWED,
    Material,
    TissueParts,
    part_numbers,
)
from tissuec.core.errors import Note
from tissuec.core.names import key_of
from tissuec.geometry.edges import TriangleIndex
from tissuec.meshes.elements import TRIANGLE
from tissuec.meshes.generators import ElementMesh
from tissuec.model.blocks import OF_ELEMENTS, FieldBlock
from tissuec.model.network import Indices, Origin, Provenance
from tissuec.scene.bodies.elements import note_of, refuse
from tissuec.scene.model import AssignedQuantity, Body
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import BREAKING_STRAIN, LIMITS

if TYPE_CHECKING:
    from tissuec.forces.point_fields import PointField
    from tissuec.forces.solids.element_limits import ElementLimits

CRUSHING = "crushing force"
#: Of the toughness of a tissue, what elements at the tip of a crack hold per area when it
#: advances; the rest is set free around them. Measured: see "Cracks" in docs/numerics.md.
AT_TIPS = {"hexahedron": 0.3, "wedge": 0.25, "tetrahedron": 0.2, TRIANGLE: 0.23}


def skin_elements(
    skin: NDArray[np.int32], blocks: Sequence[FieldBlock], cut: Collection[str] = ()
) -> Indices | None:
    """Return the element that each triangle of a skin belongs to, as an entity, or -1.

    The shape is (triangle,). None where no element may break or be divided.

    Args:
        skin: Corners, shape (triangle, 3).
        blocks: Of elements.
        cut: Bodies whose elements may be divided.
    """
    fields = [cast("PointField", b.field) for b in blocks if b.kind in OF_ELEMENTS]
    able = [each for each in fields if each.limits is not None or each.name in cut]
    if not able:
        return None
    found = np.full(len(skin), -1)
    index = TriangleIndex(skin)
    for field in able:
        faces = field.faces
        place = index.find(faces.reshape(-1, 3))
        own = np.repeat(field.walls, faces.shape[1])
        found[place[place >= 0]] = own[place >= 0]
    return found


class LimitReader:
    """Reads the limits of the elements of one body.

    Args:
        body: The body.
        parts: The entries of its tissues.
        part: Number of the part of each element, shape (element,).
        shapes: The elements, shape by shape.
        findings: Takes diagnostics.
    """

    def __init__(
        self,
        body: Body,
        parts: TissueParts,
        part: Indices,
        shapes: Sequence[ElementMesh],
        findings: Findings,
    ):
        assert body.elements is not None
        self.body, self.parts, self.part, self.findings = body, parts, part, findings
        self.shapes = shapes
        self.made = body.elements
        self.given: list[Sequence[AssignedQuantity]] = [()] * len(parts.materials)
        if body.may_rupture:
            found = parts.limits()
            for number in part_numbers(part):
                material = parts.materials[number]
                self.given[number] = found[number]
                self._check(found[number], material)

    def _check(self, limits: Sequence[AssignedQuantity], material: Material) -> None:
        """Report a part without limits of its elements, or with those of springs."""
        assert material.tissue is not None
        crush = material.tissue.given.get(CRUSHING)
        if crush is not None and crush.value != crush.quantity.none:
            refuse(f"a {CRUSHING}", crush.span, self.made, self.findings)
        if not limits:
            needed = self.parts.needed_limit(BREAKING_STRAIN)
            self.parts.missing(needed, material, note_of(self.made))
        given = limits[0]
        if given.quantity.is_of_matter or given.value == given.quantity.none:
            return
        self.findings.reject(
            "TIS306",
            "the breaking force of each spring is not available for elements",
            given.span,
            hint="write a breaking strain, a strength or a toughness in the tissue instead",
            notes=(
                Note(f"used by {self.body.name}", self.body.span),
                note_of(self.made),
            ),
        )

    @property
    def limits(self) -> "ElementLimits | None":
        """Return the limits of the elements; None where nothing may rupture."""
        if not self.body.may_rupture:
            return None
        from tissuec.forces.solids.element_limits import ElementLimits

        strain, stress, toughness = (
            self.parts.at_elements([_limit(one, key) for one in self.given], np.inf)
            for key in LIMITS
        )
        if self.body.tears_by_faces:
            parting = np.where(np.isfinite(toughness), toughness, 0.0)
            return ElementLimits(strain, stress, np.full(len(parting), np.inf), parting)
        share = [np.full(len(one.nodes), AT_TIPS[one.shape]) for one in self.shapes]
        toughness = toughness * np.concatenate(share)
        return ElementLimits(strain, stress, toughness, np.zeros(len(strain)))

    def known(self, part: NDArray[np.integer]) -> Provenance:
        """Return the origins of limits: one for each part, and that of a second limit.

        Args:
            part: Of each element, shape (n,).
        """
        if not self.body.may_rupture:
            origins = (Origin(self.body.span, NOT_ALLOWED),)
            return Provenance(np.broadcast_to(np.int32(0), part.shape), origins)
        found: list[Origin] = []
        for limits in self.given:
            own = [Origin(one.span, one.how) for one in limits]
            own = own or [Origin(self.body.span, "none")]
            found += own[0], own[-1]
        return Provenance(2 * part.astype(np.int32), tuple(found))


def _limit(given: Sequence[AssignedQuantity], key: str) -> AssignedQuantity | None:
    """Return a limit of a part; None where others limit it."""
    return next((one for one in given if key_of(one.quantity.name) == key), None)
