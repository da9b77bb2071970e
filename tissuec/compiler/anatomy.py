"""Tissues, matter and tools of a compiled scene, for blocks files."""

from math import pi

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.compile import Compiled
from tissuec.core.names import key_of
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.geometry.divisions import filling_tetrahedra
from tissuec.matter.elasticity import wall_springs
from tissuec.mechanics.deformation import hats
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.imported import Imported
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.meshes.stiffness_sharing import filled_volumes, node_areas
from tissuec.model.network import BodyPart, Floats, Indices, Network, numbers_in
from tissuec.results.blocks.anatomy import Anatomy, BodyMatter, CellPressure
from tissuec.results.volume_cells import cells_around
from tissuec.script.verbs.preserve import Inflate, Preserve


def anatomy_of(compiled: Compiled) -> Anatomy:
    """Return the tissues, regions and volumes of a scene that blocks files contain."""
    network, notes = compiled.network, list[str]()
    names, tissue = network.tissue_names, np.zeros(network.body_nodes, dtype=np.int64)
    matter: dict[str, BodyMatter] = {}
    for part in network.bodies:
        drawing = compiled.groups.bodies[key_of(part.name)].drawing
        own = [names.index(one) for _, one in part.regions]
        # Copies in reserve for cuts are of the same tissues, one set after another.
        tissue[part.nodes] = np.resize(np.array(own)[drawing.part], len(tissue[part.nodes]))
        found = _matter(compiled, part, drawing)
        if isinstance(found, BodyMatter):
            matter[part.name] = found
        elif found:
            notes.append(f"{part.name} has no strain and stress: {found}")
        elements = network.elements_of(part.name)
        if part.name in matter and any(len(one.internal_rows) for one in elements):
            notes.append(f"the stress of {part.name} is that after complete relaxation")
    tools = {tool.name: tool.kind for tool in compiled.scene.tools.values()}
    return Anatomy(names, tissue, matter, tools, tuple(notes))


def _matter(compiled: Compiled, part: BodyPart, drawing: Drawing) -> BodyMatter | str:
    """Return the matter of a body, or why it has none; "" where that goes without saying."""
    mesh, body, network = drawing.mesh, drawing.body, compiled.network
    lines: Indices = np.arange(int(part.lines.start), int(part.lines.stop) - part.bending)
    ends = network.line_ends[lines] - part.nodes.start
    if part.thread is not None:
        pieces = numbers_in(part.thread.pieces)
        return BodyMatter(_along(network, part, pieces, pi * part.thread.radius**2), 1, pieces)
    elements = network.elements_of(part.name)
    if any(one.yields.any() for one in elements):
        return "stress depends on how far its elements have yielded"
    if mesh.volume is not None:
        volume = mesh.volume if np.isfinite(mesh.volume).all() else _filled(mesh)
        if not (volume > 0.0).all():
            return "the volume of its cells cannot be computed"
        if elements:
            return BodyMatter(volume, 3, lines, elements=elements)
        pressure = _pressure(compiled, part)
        if isinstance(pressure, str):
            return pressure
        width = _width(drawing)
        near = None if width is None else hats(mesh.position, width)
        return BodyMatter(volume, 3, lines, pressure, near)
    if len(mesh.skin) and body.thickness is not None:
        volume = body.thickness * node_areas(mesh.position, mesh.skin)
        if elements:
            return BodyMatter(volume, 2, lines, elements=elements)
        return BodyMatter(volume, 2, lines[wall_springs(mesh.skin, ends)])
    if body.section is not None:
        return BodyMatter(_along(network, part, lines, body.section), 1, lines)
    return ""


def _pressure(compiled: Compiled, part: BodyPart) -> CellPressure | str | None:
    """Return the force that preserves the cells of a solid, or a reason if it changes."""
    plan, network = compiled.plan, compiled.network
    acting = [
        event.action
        for event in plan.every_event
        if isinstance(event.action, Preserve | Inflate) and event.action.group.name == part.name
    ]
    if not acting:
        return None
    first = acting[0]
    always = any(event.action is first and event.time == 0.0 for event in plan.events)
    cells = cells_around(part)
    if (
        len(acting) > 1
        or not always
        or isinstance(first, Inflate)
        or cells is None
        or first.is_fluid(network)
    ):
        return f"the volume that it keeps is set by the script ({acting[-1].span.place})"
    return CellPressure(Enclosure.of(network, part.name, first.modulus, first.span), cells)


def _width(drawing: Drawing) -> float | None:
    """Return over which distance the stress of a solid is averaged [m]; None if it is not.

    That is the cell by which a crystal repeats itself, if it holds several nodes. Irregular
    nets are even over about two cells, or two springs.
    """
    mesh, placement = drawing.body.mesh, drawing.body.whole_placement
    scale = 1.0 if placement is None else float(np.cbrt(placement.volume))
    if isinstance(mesh, Lattice):
        crystal = CRYSTALS[mesh.kind]
        is_crystal = len(crystal.sites) * crystal.period > 1
        return scale * float(mesh.edges.max()) * crystal.period if is_crystal else None
    if isinstance(mesh, Imported) and mesh.cell is not None:
        return 2.0 * scale * mesh.cell
    return 2.0 * float(drawing.length[: drawing.own].mean())


def _filled(mesh: Mesh) -> Floats:
    """Return the volume of each node of a filled surface [m³], shape (node,).

    The quarters of the tetrahedra inside, as in fillings of matter.
    """
    skin = mesh.skin.astype(np.int64)
    return filled_volumes(mesh.position, skin, filling_tetrahedra(mesh.position, skin))


def _along(network: Network, part: BodyPart, springs: Indices, section: float) -> Floats:
    """Return the volume of each node of bars: half of each of them [m³], shape (node,)."""
    ends = network.line_ends[springs]
    length = np.linalg.norm(np.diff(network.position[ends], axis=1)[:, 0], axis=1)
    half = np.repeat(0.5 * section * length, 2)
    volume: Floats = np.bincount(ends.ravel(), half, part.nodes.stop).astype(float)
    return volume[part.nodes]
