"""From a drawn body to arrays, where it is made of elements."""

from collections.abc import Sequence

from tissuec.compiler.bodies.arrays import BodyArrays, check_sizes, initial_velocity
from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.contact.surface_friction import friction_of
from tissuec.compiler.elements.bodies import ElementReader
from tissuec.compiler.elements.interfaces import interfaces_of
from tissuec.compiler.elements.membranes import MembraneReader
from tissuec.compiler.materials.cutting_resistance import SpringResistance
from tissuec.model.springs import Springs
from tissuec.scene.reading.findings import Findings
from tissuec.script.verbs.cut_surface import Blade


def build_elements(
    drawing: Drawing, findings: Findings, planes: Sequence[Blade], *, is_cut: bool = False
) -> BodyArrays:
    """Return the arrays of a body that is made of elements; see ``bodies.arrays``.

    Args:
        planes: Of symmetry of the scene.
        is_cut: Whether it can be cut or come apart. Then masses are those of the elements
            around nodes, as those that have the moments of the whole are not those of its
            parts.
    """
    of_kind = MembraneReader if drawing.body.is_wall else ElementReader
    body, reader = drawing.body, of_kind(drawing, findings, planes)
    (mass, origins), elements = reader.mass(turns=not is_cut), reader.elements()
    velocity = initial_velocity(drawing, mass)
    interfaces, parting = interfaces_of(drawing, findings)
    check_sizes(body, {"mass": mass, "velocity": velocity}, findings)
    return BodyArrays(
        body,
        drawing.mesh,
        mass,
        Springs.none(),
        {},
        {"mass": origins},
        velocity,
        drawing.columns.node_ids,
        bending=0,
        thread=None,
        friction=friction_of(drawing),
        resistance=SpringResistance.none(0),
        elements=elements,
        element_resistance=reader.resistance,
        bends=reader.bending() if isinstance(reader, MembraneReader) else None,
        breaking=reader.limits.known(reader.part),
        weighing=None if body.is_wall else reader.weights() / mass,
        element_region=drawing.element_part,
        density=reader.density,
        interfaces=interfaces,
        parting=parting,
    )
