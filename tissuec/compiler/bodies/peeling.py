"""Glue with a toughness: faces of two bodies that are tied point by point, and can come apart.

Points are those of the parts that faces of both sides have in common, as in ``mortar``; each is
tied to the same place in the element on the other side, so that meshes need not match. One
stiffness holds for all of a joint: of uniform stress, the opening then is uniform as well, and
the stress passes exactly. It is the largest that two elements of it need,

    k = 2 STIFF_INTERFACE / (h₁/E₁ + h₂/E₂),

with h = V/A of the element in front and its face, and h = V^(1/3) of the one behind. Strengths
follow from the toughness and the sizes of elements along the faces, √A in front and V^(1/3)
behind: the smaller strength of both counts (``forces.solids.element_limits``).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.gluing import edge_and_reach, refuse_common
from tissuec.compiler.bodies.hosts import Hosts, placed
from tissuec.compiler.bodies.mortar import (
    TOGETHER,
    CommonParts,
    SideFaces,
    are_outer,
    covered_parts,
    face_areas,
    faces_of,
    weights_at,
)
from tissuec.compiler.sets import Groups
from tissuec.core.errors import counted
from tissuec.core.hints import leaving_out
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.forces.moduli import plane_modulus, young_of
from tissuec.forces.solids.element_limits import softening_strength
from tissuec.forces.solids.ties import STIFF_INTERFACE, GlueTies, openings
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices, Network
from tissuec.scene.model import Glue, Scene
from tissuec.scene.reading.findings import Findings
from tissuec.script.verbs import Group

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements

ROUNDING = 1e-12  # weights that are zero


class ElementFaces(NamedTuple):
    """Faces of solid elements.

    Attributes:
        faces: All of them the same face of one shape.
        field: The elements.
        cells: The element of each face, among these, shape (face,).
    """

    faces: SideFaces
    field: "SolidElements"
    cells: Indices

    def some(self, chosen: NDArray[np.bool_] | slice) -> "ElementFaces":
        """Return some of the faces."""
        return self._replace(faces=self.faces.some(chosen), cells=self.cells[chosen])


class TiedParts(NamedTuple):
    """Points of glued faces, shape (point, …).

    Attributes:
        nodes, weights: Of the element in front, then of the one behind, filled up by weights of
            0, shape (point, 2, node).
        elements: On both sides, entities, shape (point, 2).
        area: As drawn [m²].
        compliance: h/E of both sides [m/Pa], shape (point, 2).
        strength: The smaller one of both sides [Pa].
    """

    nodes: Indices
    weights: Floats
    elements: Indices
    area: Floats
    compliance: Floats
    strength: Floats


def glue_blocks(
    scene: Scene, network: Network, groups: Groups, findings: Findings
) -> list[FieldBlock]:
    """Return the glue of a scene that has a toughness.

    Args:
        network: With the elements of all bodies, and all other glue.
        groups: Sets and bodies.
    """
    blocks, first = list[FieldBlock](), network.entity_count
    known = dict[tuple[int, int], Glue]()
    for glue in scene.peeling:
        with findings.item():
            parts = _parts(glue, network, groups, findings)
            _refuse_twice(glue, parts, known, network, findings)
            field = _ties(glue, parts, first)
            first += len(np.unique(field.sections))
            blocks.append(field.block)
    return blocks


def _ties(glue: Glue, parts: TiedParts, first: int) -> GlueTies:
    """Return the ties of a glue, whose sections are numbered from ``first``."""
    assert glue.toughness is not None
    stiff = float((2.0 * STIFF_INTERFACE / parts.compliance.sum(axis=1)).max())
    count = len(parts.area)
    stiffness, energy = np.full(count, stiff), np.full(count, glue.toughness)
    begin, end = openings(parts.strength, energy, stiffness)
    _, section = np.unique(parts.elements[:, 0], return_inverse=True)
    return GlueTies(
        walls=parts.elements.ravel(), walled=np.repeat(np.arange(count), 2),
        nodes=parts.nodes.reshape(count, -1), name=glue.name,
        weights=parts.weights.reshape(count, -1), stiffness=parts.area * stiffness,
        damping=np.zeros(count), span=glue.span, first=begin, last=end,
        sections=first + section.ravel(), softens=np.ones(count, dtype=bool),
        elements=parts.elements[:, 0], areas=parts.area,
    )  # fmt: skip


def _parts(glue: Glue, network: Network, groups: Groups, findings: Findings) -> TiedParts:
    """Return the points of a glue; reject what cannot come apart."""
    assert glue.toughness is not None
    first, second = groups.both(glue.ends)
    for group, name in zip((first, second), glue.ends, strict=True):
        _refuse_bodies(glue, network, group, name.span, findings)
    behind = _faces(network, second.indices)
    hosts = [Hosts(each.faces.shape, each.faces.elements) for each in behind]
    refuse_common(glue, first, second, hosts, findings)
    _, reach = edge_and_reach(glue, network.position, hosts)
    found, far = list[TiedParts](), list[Indices]()
    ahead = _whole_faces(glue, network, first, findings)
    for every in ahead:
        for start in range(0, len(every.cells), TOGETHER):
            own = every.some(slice(start, start + TOGETHER))
            takes, parts = covered_parts(
                network.position, own.faces, [each.faces for each in behind], reach
            )
            far.append(own.faces.nodes[~takes])
            found += [
                _tied(network.position, own, part, other, glue.toughness)
                for other, part in zip(behind, parts, strict=True)
                if len(part.area)
            ]
    missed = sum(map(len, far))
    # Of whole elements, the faces elsewhere are not meant.
    if missed and (not found or not _has_elements(network, first.indices)):
        _refuse_far(glue, network, (first, second), far, reach, findings)
    widths = [each.nodes.shape[2] for each in found]
    filled = [_filled(each, max(widths)) for each in found]
    return TiedParts(*(np.concatenate(each) for each in zip(*filled, strict=True)))


def _tied(
    position: Floats, own: ElementFaces, part: CommonParts, other: ElementFaces, tough: float
) -> TiedParts:
    """Return the points that some faces have in common with others."""
    n, place = weights_at(position, own.faces, part)
    beside = other.faces.elements[part.host]
    phi, _ = placed(other.faces.shape, place, position[beside])
    sides = _packed(own.faces.nodes[part.guest], n), _packed(beside, -phi)
    width = max(nodes.shape[1] for nodes, _ in sides)
    nodes, weights = (
        np.stack(each, axis=1)
        for each in zip(*(_wider(*side, width) for side in sides), strict=True)
    )
    area = face_areas(position, own.faces)
    cells = own.cells[part.guest], other.cells[part.host]
    volume = own.field.volume[cells[0]], other.field.volume[cells[1]]
    thick = volume[0] / area[part.guest], np.cbrt(volume[1])
    along = np.sqrt(area[part.guest]), np.cbrt(volume[1])
    moduli = [
        (each.field.shear[cell], each.field.bulk_modulus[cell])
        for each, cell in zip((own, other), cells, strict=True)
    ]
    pairs = zip(moduli, thick, along, strict=True)
    compliance, strength = zip(
        *((h / young_of(*each), softening_strength(plane_modulus(*each), tough, size))
          for each, h, size in pairs),
        strict=True,
    )  # fmt: skip
    return TiedParts(
        nodes,
        weights,
        np.stack([own.field.walls[cells[0]], other.field.walls[cells[1]]], axis=1),
        part.area,
        np.stack(compliance, axis=1),
        np.minimum(*strength),
    )


def _packed(nodes: Indices, weights: Floats) -> tuple[Indices, Floats]:
    """Return nodes with weights first, without columns that have none, shape (point, n)."""
    is_none = np.abs(weights) <= ROUNDING
    order = np.argsort(is_none, axis=1, kind="stable")
    width = int((~is_none).sum(axis=1).max())
    weights = np.where(is_none, 0.0, weights)
    return tuple(  # pyright: ignore[reportReturnType]
        np.take_along_axis(each, order, axis=1)[:, :width] for each in (nodes, weights)
    )


def _wider(nodes: Indices, weights: Floats, width: int) -> tuple[Indices, Floats]:
    """Return nodes and weights of one side, filled up by its first node without weight."""
    more = width - nodes.shape[-1]
    filling = np.repeat(nodes[..., :1], more, axis=-1)
    nothing = np.zeros(filling.shape)
    return np.concatenate([nodes, filling], -1), np.concatenate([weights, nothing], -1)


def _filled(parts: TiedParts, width: int) -> TiedParts:
    """Return the same with as many nodes of each side."""
    nodes, weights = _wider(parts.nodes, parts.weights, width)
    return parts._replace(nodes=nodes, weights=weights)


# --- faces ------------------------------------------------------------------------------------


def _faces(network: Network, nodes: Indices) -> list[ElementFaces]:
    """Return the outer faces of the bodies of some nodes at which any of these is.

    Args:
        nodes: Of a set or body, shape (n,).
    """
    inside = np.zeros(network.node_count, dtype=bool)
    inside[nodes] = True
    every = [
        ElementFaces(faces, field, np.arange(field.item_count))
        for field in network.of_kind("elements")
        if inside[field.nodes].any()
        for faces in faces_of(Hosts(field.shape.name, field.nodes.astype(np.int64)))
    ]
    alone = are_outer([each.faces for each in every])
    found = [
        each.some(outer & inside[each.faces.nodes].any(axis=1))
        for each, outer in zip(every, alone, strict=True)
    ]
    return [each for each in found if len(each.cells)]


def _whole_faces(
    glue: Glue, network: Network, group: Group, findings: Findings
) -> list[ElementFaces]:
    """Return the outer faces that have no other nodes than those of a set; there is one."""
    inside = np.zeros(network.node_count, dtype=bool)
    inside[group.indices] = True
    every = _faces(network, group.indices)
    found = [each.some(inside[each.faces.nodes].all(axis=1)) for each in every]
    used = np.zeros(network.node_count, dtype=bool)
    for each in found:
        used[each.faces.nodes] = True
    if not _has_elements(network, group.indices):
        alone = group.indices[~used[group.indices]]
        if len(alone):
            node = int(alone[0])
            findings.reject(
                "TIS309",
                f"{counted(len(alone), 'node')} of {group.name} "
                f"{'is' if len(alone) == 1 else 'are'} not part of a face all of whose nodes "
                f"{group.name} has, such as node {network.node_ids[node]} of "
                f"{network.body_at(node).name}: glue with a toughness is between faces",
                glue.ends[0].span,
                hint="choose all nodes of the faces, and no others",
            )
    return [each for each in found if len(each.cells)]


def _has_elements(network: Network, nodes: Indices) -> bool:
    """Return whether some nodes are all those of any solid element."""
    inside = np.zeros(network.node_count, dtype=bool)
    inside[nodes] = True
    return any(inside[each.nodes].all(axis=1).any() for each in network.of_kind("elements"))


# --- what is refused --------------------------------------------------------------------------


def _refuse_bodies(
    glue: Glue, network: Network, group: Group, place: Span, findings: Findings
) -> None:
    """Reject sets of bodies whose faces cannot come off."""
    for owner in np.unique(network.body_numbers(group.indices)).tolist():
        body = network.bodies[owner]
        if not body.is_made_of_elements or body.is_wall:
            findings.reject(
                "TIS309",
                f"{body.name} is no solid of elements, whose faces glue with a toughness joins",
                place,
                hint="remove the toughness, or use springs with a breaking force",
            )
        if body.reserve.nodes:
            cause = "has an interface that peels" if body.interfaces else "is cut or tears"
            findings.reject(
                "TIS309",
                f"{body.name} {cause}, where glue with a toughness could not follow its faces",
                place,
                hint=leaving_out("remove the toughness of the glue", glue.span),
            )


def _refuse_far(
    glue: Glue, network: Network, groups: tuple[Group, Group], far: Sequence[Indices],
    reach: float, findings: Findings,
) -> None:  # fmt: skip
    """Reject faces that are too far from the other side, by the nodes of each."""
    first, second = groups
    count = sum(map(len, far))
    corners = next(each[0] for each in far if len(each))
    x, y, z = (f"{1e3 * place:.4g}" for place in network.position[corners].mean(axis=0))
    findings.reject(
        "TIS302",
        f"{counted(count, 'face')} of {first.name} {'is' if count == 1 else 'are'} not at "
        f"{second.name}: less than half of the one around ({x}, {y}, {z}) mm is within "
        f"{show(reach, LENGTH)} of it",
        glue.ends[0].span.to(glue.ends[1].span),
        hint="write a larger reach, move the bodies together, or glue a set of near nodes only",
    )


def _refuse_twice(
    glue: Glue, parts: TiedParts, known: dict[tuple[int, int], Glue], network: Network,
    findings: Findings,
) -> None:  # fmt: skip
    """Reject faces that other glue joins already.

    Args:
        known: Glue by the elements of both sides, ascending; this one is added.
    """
    pairs = np.unique(np.sort(parts.elements, axis=1), axis=0)
    for pair in map(tuple, pairs.tolist()):
        other = known.setdefault(pair, glue)
        if other is not glue:
            _reject_second(glue, other.name, findings)
    firm = np.zeros((network.node_count, len(network.bodies)), dtype=bool)
    if (embedding := network.embedding) is not None:
        firm[embedding.nodes[embedding.owners], network.body_numbers(embedding.hosts)] = True
    for side in (0, 1):
        other = network.body_numbers(parts.nodes[:, 1 - side, :1])
        follows = firm[parts.nodes[:, side], other] | (parts.weights[:, side] == 0.0)
        if follows.all(axis=1).any():
            _reject_second(glue, "other glue", findings)


def _reject_second(glue: Glue, other: str, findings: Findings) -> None:
    findings.reject(
        "TIS309",
        f"{other} joins faces of {glue.ends[0].text} and {glue.ends[1].text} already",
        glue.span,
        hint="leave them out in one of both, by a set of the other nodes",
    )
