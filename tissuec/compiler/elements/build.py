"""From a drawn body to arrays, where it is made of elements."""

from collections.abc import Sequence

import numpy as np

from tissuec.compiler.bodies.arrays import BodyArrays, check_sizes, initial_velocity
from tissuec.compiler.bodies.drawn import Drawing, refuse_sizes
from tissuec.compiler.contact.surface_friction import friction_of
from tissuec.compiler.elements.bodies import ElementReader
from tissuec.compiler.elements.membranes import MembraneReader
from tissuec.compiler.materials.cutting_resistance import SpringResistance
from tissuec.laws import LINEAR
from tissuec.model.springs import Springs
from tissuec.scene.reading.findings import Findings
from tissuec.script.verbs.cut_surface import Blade


def build_elements(drawing: Drawing, findings: Findings, planes: Sequence[Blade]) -> BodyArrays:
    """Return the arrays of a body that is made of elements; see ``bodies.arrays``.

    Args:
        planes: Of symmetry of the scene.
    """
    of_kind = MembraneReader if drawing.body.is_wall else ElementReader
    body, reader = drawing.body, of_kind(drawing, findings, planes)
    quantities, elements = reader.read(), reader.elements()
    arrays = {name: values for name, (values, _) in quantities.items()}
    velocity = initial_velocity(drawing, arrays["mass"])
    check_sizes(body, arrays | {"velocity": velocity}, findings)
    materials = [one.material for one in elements]
    moduli = [value for one in materials for value in (one.shear, one.bulk, one.viscosity)]
    refuse_sizes(body, {"modulus or viscosity": np.concatenate(moduli)}, findings)
    law = np.broadcast_to(np.int32(0), drawing.length.shape)
    return BodyArrays(
        body,
        drawing.mesh,
        arrays["mass"],
        Springs.of(drawing.mesh.ends, arrays, law, (LINEAR,), drawing.columns.spring_ids),
        {},
        {name: provenance for name, (_, provenance) in quantities.items()},
        velocity,
        drawing.columns.node_ids,
        bending=0,
        thread=None,
        friction=friction_of(drawing),
        resistance=SpringResistance.none(len(drawing.length)),
        elements=elements,
        bends=reader.bending() if isinstance(reader, MembraneReader) else None,
        breaking=reader.limits.known(reader.part),
        weighing=None if body.is_wall else reader.weights() / arrays["mass"],
        element_region=drawing.element_part,
    )
