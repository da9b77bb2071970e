"""Bodies as drawn, without materials: mesh, tables and regions."""

from collections.abc import Mapping

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.tables import ExplicitBody, read_tables
from tissuec.compiler.bodies.threads import knot_pairs, thread_of
from tissuec.compiler.selections import (
    Mask,
    PointScope,
    extents,
    group_masks,
    refuse_overlap,
    surface_mask,
    warn_of_idle_alternatives,
)
from tissuec.core.arrays import largest_side
from tissuec.core.errors import Note, counted
from tissuec.core.fields import UnfitEntries
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.names import key_of
from tissuec.core.structs import replace
from tissuec.geometry.affine import Affine
from tissuec.lang import syntax as s
from tissuec.mechanics.observables import lengths
from tissuec.meshes.formats import FormatError
from tissuec.meshes.generators import Elemental, Mesh, Threaded
from tissuec.meshes.generators.imported import Imported, MeshFileError
from tissuec.model.network import Floats, ThreadBody
from tissuec.scene.bodies.fibres import Direction, Helix
from tissuec.scene.model import Body
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.values import LARGEST_NUMBER

LARGEST = 50_000_000  # nodes or springs of one body; more does not fit into memory
LARGEST_IN_VAIN = (
    500_000  # of a scene that is wrong; drawing more would keep its author waiting
)
CHECK_UNITS = "check the units"


class Drawing(Struct, frozen=True, eq=False):
    """A mesh, what tables say about it, and which part of the body each node belongs to.

    Attributes:
        body: What is drawn.
        columns: Ids, and what tables give for nodes and springs.
        regions: Membership of each node in each region, by key of its name; of elements, a node
            belongs to the regions of all elements around it.
        part: Number of each node's region from 1, 0 without one, shape (node,).
        length: Drawn length of each spring [m], shape (spring,).
        own: How many springs the mesh itself has, with that of its knot; those after them
            resist bending.
        thread: Where it is a thread, numbered within the body.
        spring_part: Of each spring, its place from 1 among ``body.spring_parts``, 0 for those
            that are made of their nodes, shape (spring,); None where all are.
        element_part: Number of each element's region as in ``part``, of all shapes one after
            the other, shape (element,); None of a body of springs.
        scope: Looks up the numbers of formulas of the place; None of joints, which have none.
    """

    body: Body
    mesh: Mesh
    columns: ExplicitBody
    regions: dict[str, Mask]
    part: NDArray[np.int32]
    length: Floats
    own: int
    thread: ThreadBody | None = None
    spring_part: NDArray[np.int64] | None = None
    element_part: NDArray[np.int64] | None = None
    scope: Scope | None = None

    def described(self, places: Floats) -> Floats:
        """Return where places of the body are before it is moved as a whole.

        Args:
            places: [m], shape (place, 3).

        Returns:
            In the coordinates of its block [m], shape (place, 3).
        """
        placement = self.body.placement
        return places if placement is None else placement.inverse().points(places)

    @property
    def is_elements(self) -> bool:
        """Return whether its node pairs are edges of finite elements, not springs."""
        return self.element_part is not None

    @property
    def bends(self) -> Mask:
        """Return which springs resist bending, shape (spring,)."""
        return np.arange(len(self.length)) >= self.own

    @property
    def is_bars(self) -> bool:
        """Return whether its springs are bars, with sections of their own."""
        is_thread = isinstance(self.body.mesh, Threaded)
        return is_thread or (self.mesh.volume is None and not len(self.mesh.skin))


@np.errstate(all="ignore")  # numbers that leave the range of numbers are found in the end
def draw(body: Body, scope: Scope) -> Drawing:
    """Return the drawing of a body; errors are reported with their place."""
    drawing = _as_described(body, scope)
    return drawing if body.placement is None else _placed(drawing, body.placement, scope)


def _as_described(body: Body, scope: Scope) -> Drawing:
    """Return the drawing of a body before the entries that place all of it."""
    if body.tables is not None:
        columns = read_tables(body, body.tables, scope)
    else:
        columns = ExplicitBody.without_columns(_generate(body, scope.findings))
    if body.mesh_placement is not None:
        columns = _moved(columns, body.mesh_placement, body, scope.findings)
    if isinstance(body.mesh, Threaded):
        columns = columns.with_springs(knot_pairs(columns.mesh, body.mesh))
    thread, own = thread_of(body.mesh, columns.mesh.ends), len(columns.mesh.ends)
    if body.bending is not None:
        columns = columns.with_springs(_bending(body, columns.mesh, scope.findings))
    mesh, element_part = columns.mesh, None
    if body.elements is not None and mesh.elements:
        from tissuec.compiler.elements.borders import at_borders
        from tissuec.compiler.elements.regions import regions_of_elements

        mesh = at_borders(body, mesh, scope)
        columns = replace(columns, mesh=mesh)
        element_part, part, regions = regions_of_elements(body, mesh, scope)
    else:
        regions = _select_regions(body, mesh, scope)
        part = np.zeros(len(mesh.position), dtype=np.int64)
        for number, inside in enumerate(regions.values(), start=1):
            part[inside] = number
    length = _lengths(body, mesh, thread, scope.findings)
    drawing = Drawing(
        body, mesh, columns, regions, part.astype(np.int32), length, own, thread,
        element_part=element_part, scope=scope,
    )  # fmt: skip
    if element_part is not None or not body.spring_parts:
        return drawing
    return replace(drawing, spring_part=_select_springs(drawing, scope))


def _moved(
    columns: ExplicitBody, placement: Affine, body: Body, findings: Findings
) -> ExplicitBody:
    """Return a mesh with its columns as a map draws it."""
    if "rest length" in columns.springs and placement.scale != 1.0:
        findings.reject(
            "TIS306",
            f"{body.name} is scaled, but its table gives the rest lengths of its springs",
            body.span,
            hint="scale the numbers of the table",
        )
    from tissuec.meshes.placement import placed  # where there are such

    return replace(columns, mesh=placed(columns.mesh, placement))


def _placed(drawing: Drawing, placement: Affine, scope: Scope) -> Drawing:
    """Return a body that is described elsewhere, with its directions, in its own place."""
    body, prestress = drawing.body, drawing.body.prestress
    if prestress is not None:
        image = placement.normal if prestress.is_across else placement.direction
        prestress = replace(prestress, axis=image(prestress.axis))
    families = [
        _turned(one, placement, body, scope.findings)
        for one in (body.fibres, body.second_fibres)
    ]
    columns = _moved(drawing.columns, placement, body, scope.findings)
    length = _lengths(body, columns.mesh, drawing.thread, scope.findings)
    body = replace(body, fibres=families[0], second_fibres=families[1], prestress=prestress)
    return replace(drawing, body=body, mesh=columns.mesh, columns=columns, length=length)


def _turned(
    fibres: Direction | None, placement: Affine, body: Body, findings: Findings
) -> Direction | None:
    """Return the direction of fibres that are moved with their body."""
    if isinstance(fibres, Helix):
        if placement.scale is None:
            findings.reject(
                "TIS306",
                f"{body.name} is scaled differently along its axes, which changes the angle of "
                "its fibres",
                body.span,
                hint="write scaled in the mesh block, and the angle in the scaled tube",
            )
        return Helix(-fibres.angle) if placement.is_mirrored else fibres
    return placement.direction(fibres) if isinstance(fibres, np.ndarray) else fibres


def _lengths(body: Body, mesh: Mesh, thread: ThreadBody | None, findings: Findings) -> Floats:
    """Return the drawn lengths of springs [m], shape (spring,); reject absurd ones."""
    length = lengths(mesh.ends, mesh.position)
    refuse_sizes(body, {"place": mesh.position, "length": length}, findings)
    if thread is not None:  # a knot is made of as much thread as any piece
        length[[thread.hold, thread.slip]] = length[thread.pieces].mean()
    return length


def refuse_sizes(body: Body, named: Mapping[str, Floats], findings: Findings) -> None:
    """Reject a body with numbers too large for the arithmetic.

    Args:
        named: Numbers by the name of the quantity, in SI units, of any shape.
    """
    for name, values in named.items():
        if not np.all(np.abs(values) < LARGEST_NUMBER):
            message = f"{body.name} has a {name} that is too large to compute with"
            findings.reject("TIS504", message, body.span, hint=CHECK_UNITS)


def _generate(body: Body, findings: Findings) -> Mesh:
    assert body.mesh is not None
    try:
        if body.elements is not None and isinstance(body.mesh, Elemental) and not body.is_wall:
            nodes, springs = body.mesh.element_size()
            if body.elements.is_quadratic:
                nodes, springs = 8 * nodes, 8 * springs
        else:
            nodes, springs = body.mesh.size()
        if max(nodes, springs) > LARGEST:
            findings.reject(
                "TIS310",
                f"body {body.name} would have about {nodes:.3g} nodes "
                f"and {springs:.3g} springs",
                body.span,
                hint=f"at most {LARGEST:,} of each are possible".replace(",", " ")
                + "; are lengths in mm, not in m?"
                * (max(nodes, springs) < 1e9 * LARGEST_IN_VAIN),
            )
        if findings.errors and max(nodes, springs) > LARGEST_IN_VAIN:
            findings.stop()
        mesh = _built(body)
    except MeshFileError as error:
        place, hint = body.span, error.hint
        if isinstance(body.mesh, Imported):
            place = body.mesh.file.span
            hint = hint or _with_unit(body.mesh.file.name, error.unit)
        findings.reject("TIS605", str(error), place, hint=hint)
    except (ValueError, ArithmeticError) as error:
        if not body.is_whole:
            findings.stop()  # what could not be read may be what is missing
        hint = error.hint if isinstance(error, FormatError | UnfitEntries) else ""
        findings.reject("TIS309", f"body {body.name}: {error}", body.span, hint=hint)
    if mesh.origin is not None and mesh.remarks:
        findings.add(
            "W602",
            f'"{mesh.origin.file.name}" was repaired or has defects',
            mesh.origin.file.span,
            notes=tuple(map(Note, mesh.remarks)),
        )
    return mesh


def _with_unit(file: str, unit: str) -> str:
    """Return the hint that gives a file its own unit; "" if the unit is not at fault."""
    entry = f'file "{file}" in {unit}'
    return Hint(f"write: {entry}", Edit(entry)) if unit else ""


def _built(body: Body) -> Mesh:
    """Return the mesh that a generator draws."""
    assert body.mesh is not None
    if body.is_wall:
        from tissuec.meshes.elements import wall_of_triangles

        return wall_of_triangles(body.mesh.build())
    if body.elements is not None and isinstance(body.mesh, Elemental):
        mesh = body.mesh.build_elements()
        if not body.elements.is_quadratic:
            return mesh
        from tissuec.meshes.quadratic import with_middles

        return with_middles(mesh)
    return body.mesh.build()


def points_of(drawing: Drawing, scope: Scope, *, of_springs: bool) -> PointScope:
    """Return the nodes of a body as points, or the midpoints of its springs.

    Args:
        of_springs: Whether midpoints of springs are returned.
    """
    mesh = drawing.mesh
    surface = surface_mask(mesh)
    if not of_springs:
        return PointScope(
            scope,
            mesh.position,
            ids=None if drawing.body.is_refined else drawing.columns.node_ids,
            regions=drawing.regions,
            surface=surface,
            groups=group_masks(mesh),
        )
    ends = mesh.position[mesh.ends]

    def inside(nodes: Mask) -> Mask:
        return np.asarray(nodes[mesh.ends].all(axis=1))

    return PointScope(
        scope,
        ends.mean(axis=1),
        size=largest_side(mesh.position),
        ids=None if drawing.body.is_refined else drawing.columns.spring_ids,
        length=np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
        regions={name: inside(nodes) for name, nodes in drawing.regions.items()},
        surface=None if surface is None else inside(surface),
        bends=drawing.bends,
        groups={name: inside(nodes) for name, nodes in group_masks(mesh).items()},
    )


def _bending(body: Body, mesh: Mesh, findings: Findings) -> NDArray[np.int32]:
    """Return the pairs of nodes that bending springs join, shape (pair, 2)."""
    from tissuec.meshes.generators.joining import bending_springs

    assert body.bending is not None
    try:
        return bending_springs(mesh, body.mesh)
    except ValueError as error:
        message = f"{body.name} cannot have bending springs: {error}"
        findings.reject("TIS309", message, body.bending.span)


def _select_regions(body: Body, mesh: Mesh, scope: Scope) -> dict[str, Mask]:
    points = PointScope(
        scope, mesh.position, surface=surface_mask(mesh), groups=group_masks(mesh)
    )
    chosen: dict[str, Mask] = {}
    for region in body.regions:
        inside = points.select(region.where)
        if not inside.any():
            scope.findings.reject(
                "TIS302",
                f'the region "{region.name}" contains no node',
                region.span,
                hint=extents(mesh.position),
            )
        warn_of_idle_alternatives(
            region.where, [points], missing=f"no node of {body.name} has",
            of=f"the region {region.name}",
        )  # fmt: skip
        chosen[key_of(region.name)] = inside
        refuse_overlap(body.regions, [*chosen.values()], "node", scope.findings)
    return chosen


def _select_springs(drawing: Drawing, scope: Scope) -> NDArray[np.int64]:
    """Return the place of each spring among those with a tissue of their own, from 1."""
    found = np.zeros(len(drawing.length), dtype=np.int64)
    points = points_of(drawing, scope, of_springs=True)
    for number, part in enumerate(drawing.body.spring_parts, start=1):
        if part.sides is not None:
            chosen = _between(drawing, part.sides, scope.findings)
        else:
            assert part.where is not None
            chosen = points.select(part.where)
        if not chosen.any():
            scope.findings.reject(
                "TIS302", f"{drawing.body.name} has no {part.name}", part.span,
                hint=extents(drawing.mesh.position),
            )  # fmt: skip
        for before in np.unique(found[chosen]).tolist():
            other = drawing.body.spring_parts[int(before) - 1]
            if before and other.sides is None:
                common = counted(int((found[chosen] == before).sum()), "spring")
                scope.findings.reject(
                    "TIS311", f"two conditions select {common} of {drawing.body.name}",
                    part.span, hint="change one of the conditions",
                    notes=(Note("the other one", other.span),),
                )  # fmt: skip
        found[chosen] = number
    return found


def numbered(
    drawing: Drawing, sides: tuple[s.Name, s.Name], findings: Findings
) -> tuple[int, int]:
    """Return the numbers of two regions, 0 for what is in none; reject others."""
    names = [key_of(drawing.body.name), *drawing.regions]
    for name in sides:
        if name.key not in names:
            findings.reject(
                "TIS301", f'there is no region called "{name.text}"', name.span,
                hint=alternatives(name.key, names, what="regions"),
            )  # fmt: skip
    first, second = (names.index(name.key) for name in sides)
    return first, second


def _between(drawing: Drawing, sides: tuple[s.Name, s.Name], findings: Findings) -> Mask:
    """Return which springs lead from one region, or the rest of the body, to another."""
    first, second = numbered(drawing, sides, findings)
    ends = np.sort(drawing.part[drawing.mesh.ends], axis=1)
    found = np.asarray((ends == sorted((first, second))).all(axis=1)) & (first != second)
    if drawing.thread is not None:
        found[drawing.thread.knots] = False
    return found
