"""From a drawn body of springs to arrays: materials and initial velocities."""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import CHECK_UNITS, Drawing, refuse_sizes
from tissuec.compiler.bodies.threads import with_slipping
from tissuec.compiler.contact.surface_friction import friction_of
from tissuec.compiler.materials.cutting_resistance import SpringResistance
from tissuec.compiler.materials.reader import MaterialReader
from tissuec.laws import Law
from tissuec.laws.formula import variables
from tissuec.meshes.generators import Mesh
from tissuec.model.inelastic import NAMES as INELASTIC
from tissuec.model.interfaces import NO_PARTING, Interface, Parting
from tissuec.model.network import Floats, Indices, Provenance, ThreadBody
from tissuec.model.phantoms import NO_RESERVE, Reserve
from tissuec.model.resistance import SurfaceFriction
from tissuec.model.springs import Springs
from tissuec.scene.model import Body
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.values import LARGEST_NUMBER

if TYPE_CHECKING:  # which few nets need
    from tissuec.compiler.elements.membranes import WallBending
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.forces.surfaces.membranes import Membranes

#: Arrays whose entries are finite, and what they are called.
_FINITE = {
    "velocity": "velocity",
    "length": "length",
    "mass": "mass",
    "stiffness": "spring constant",
    "damping": "viscosity",
    "rest": "rest length",
}


class BodyArrays(Struct, frozen=True, eq=False):
    """A body before it takes its place in the network; fields as in ``Network``."""

    body: Body
    mesh: Mesh
    mass: Floats
    springs: Springs  # numbered within the body
    memory: dict[str, Floats]  # of springs that relax or yield, by ``model.inelastic.NAMES``
    provenance: dict[str, Provenance]
    velocity: Floats
    node_ids: Indices
    bending: int  # how many springs, the last ones, resist bending only
    thread: ThreadBody | None  # numbered within the body
    friction: SurfaceFriction
    resistance: SpringResistance
    elements: "tuple[SolidElements | Membranes, ...]" = ()  # numbered within the body
    element_resistance: Floats | None = None  # that blades meet [J/m²], shape (element,)
    bends: "WallBending | None" = None  # of a wall of elements
    breaking: Provenance | None = None  # origins of the limits of elements
    weighing: Floats | None = None
    element_region: Indices | None = None
    density: Floats | None = None  # of elements over that of any; None where it is even
    interfaces: tuple[Interface, ...] = ()
    parting: Parting = NO_PARTING  # of the interfaces
    reserve: Reserve = NO_RESERVE  # of the last nodes and elements


@np.errstate(all="ignore")  # numbers that leave the range of numbers are found in the end
def build_body(drawing: Drawing, findings: Findings) -> BodyArrays:
    """Return the arrays of a body of springs; errors are reported with their place."""
    body, reader = drawing.body, MaterialReader(drawing, findings)
    quantities, (law, laws) = reader.read(), reader.laws()
    arrays = {name: values for name, (values, _) in quantities.items()}
    if drawing.thread is not None:
        arrays, law, laws = with_slipping(arrays, law, laws, drawing.thread)
    velocity = initial_velocity(drawing, arrays["mass"])
    check_sizes(body, arrays | {"velocity": velocity}, findings)
    check_laws(body, arrays["rest"], law, laws, findings)
    return BodyArrays(
        body,
        drawing.mesh,
        arrays["mass"],
        Springs.of(drawing.mesh.ends, arrays, law, laws, drawing.columns.spring_ids),
        {name: arrays[name] for name in INELASTIC if name in arrays},
        {name: provenance for name, (_, provenance) in quantities.items()},
        velocity,
        drawing.columns.node_ids,
        len(drawing.length) - drawing.own,
        drawing.thread,
        friction_of(drawing),
        reader.resistance(),
    )


def initial_velocity(drawing: Drawing, mass: Floats) -> Floats:
    """Return initial velocities [m/s], shape (node, 3): the body's own, or a table's.

    Args:
        mass: Of the nodes [kg], shape (node,).
    """
    body, position = drawing.body, drawing.mesh.position
    velocity = np.tile(body.velocity, (len(position), 1))
    if body.spin.any():
        centre = (mass[:, None] * position).sum(axis=0) / mass.sum()
        velocity += np.asarray(np.cross(body.spin, position - centre), dtype=float)
    for axis, name in enumerate(("vx", "vy", "vz")):
        if name in drawing.columns.nodes:
            velocity[:, axis] = drawing.columns.nodes[name]
    return velocity


def check_sizes(body: Body, arrays: dict[str, Floats], findings: Findings) -> None:
    """Reject a body with numbers too large or too small for the arithmetic.

    Args:
        arrays: Numbers of nodes and springs by name in SI units, shape (node,) or (spring,).
    """
    named = {word: arrays[name] for name, word in _FINITE.items() if name in arrays}
    for name in (name for name in INELASTIC if name in arrays):
        named[name] = arrays[name][np.isfinite(arrays[name])]
    refuse_sizes(body, named, findings)
    if "mass" in arrays and np.any(arrays["mass"] < 1.0 / LARGEST_NUMBER):
        message = f"the mass of {body.name} is too small to compute with"
        findings.reject("TIS504", message, body.span, hint=CHECK_UNITS)


def check_laws(
    body: Body, rest: Floats, law: NDArray[np.int32], laws: tuple[Law, ...], to: Findings
) -> None:
    """Reject a spring without a rest length whose law divides by it.

    Args:
        rest: Rest lengths [m], shape (spring,).
        law: Index of the law of each spring, shape (spring,).
        to: Takes diagnostics.
    """
    found: set[int] = set(law[rest <= 0.0].tolist())
    for one in (laws[number] for number in sorted(found)):
        used = variables(one.elastic) | variables(one.viscous)
        if "rest" in used:
            to.reject(
                "TIS309",
                f"a spring of {body.name} has no rest length, but its law "
                f"({one.name}) needs one",
                body.span,
                hint="draw it longer, or use a law that depends on the elongation only",
            )
