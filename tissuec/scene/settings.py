"""The blocks that occur once: environment and simulate."""

import math
from collections.abc import Mapping
from typing import Annotated, TypeGuard

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.errors import Note
from tissuec.core.fields import OneOf, Point, Real
from tissuec.core.hints import Edit, Hint, insertion, leaving_out
from tissuec.core.source import Span
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.procedures import PROCEDURES, Choices
from tissuec.lang import syntax as s
from tissuec.lang.version import last_line
from tissuec.model.network import Floats
from tissuec.scene.model import ContactLaw, Environment
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.program.imports import whole
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import Entry, entries_of, with_choices, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import block, declare
from tissuec.script.plan import (
    AUTOMATIC,
    DEFAULT_TOLERANCE,
    EQUILIBRIUM,
    LOAD_STEPS,
    RELAXATION,
    STATIC,
    Simulation,
)

FINEST_TOLERANCE = 1e-13  # below, rounding alone is larger
CONTACTS = {
    "off": "Nothing touches.",
    "tools only": "Threads, and tools with a shape, touch bodies.",
    "bodies too": "Bodies touch one another as well.",
    "everywhere": "Bodies touch themselves as well.",
}
CONTACT_PLACES = ("faces", "nodes")

#: How the sentence with a plane of symmetry begins, and an example of it.
SYMMETRIC = "symmetric about plane"
PLANE_FORM = f"{SYMMETRIC} through (0, 0, 0) mm facing (1, 0, 0)"


class EnvironmentEntries(Struct, frozen=True, eq=False):
    """What acts everywhere.

    Attributes:
        gravity: acceleration of free fall; write (0, 0, 0) m/s^2 for none
        contact: what takes part in contact: nothing, threads and tools with a shape, also
            bodies with one another, or also bodies with themselves
        contact_places: where bodies are touched; by default on their faces if they are made of
            elements and no contact stiffness is written, else at their nodes
        friction: coefficient of friction in all contact; by default, tissues give it
        contact_stiffness: contact force of a node per depth of penetration; by default the
            stiffness of its springs
        contact_surface_stiffness: contact pressure per depth of penetration; on faces, it
            follows from the tissue by default
        contact_thickness: distance from the surface of a body at which contact begins; by
            default a quarter of the size of a face, or of a spring's length
        contact_layer: depth over which the contact stiffness increases to its full value; by
            default a tenth of a spring's length
        contact_damping: relative decrease of the contact force per speed of separation
        damping: ambient damping: a force on each node of minus this times its velocity
        mass_damping: ambient damping by mass: a force on each node of minus this times its mass
            and velocity
        surface_damping: ambient damping by area: a force on each node of minus this times its
            share of the surface and its velocity
    """

    gravity: Annotated[Floats, Point(units.ACCELERATION)]
    contact: Annotated[str, OneOf(CONTACTS)] = "off"
    contact_places: Annotated[str | None, OneOf(CONTACT_PLACES)] = None
    friction: Annotated[float | None, Real(units.NUMBER, at_least=0.0)] = None
    contact_stiffness: Annotated[float | None, Real(units.STIFFNESS, above=0.0)] = None
    contact_surface_stiffness: Annotated[
        float | None, Real(units.AREAL_STIFFNESS, above=0.0)
    ] = None
    contact_thickness: Annotated[float | None, Real(units.LENGTH, above=0.0)] = None
    contact_layer: Annotated[float | None, Real(units.LENGTH, above=0.0)] = None
    contact_damping: Annotated[float | None, Real(units.SLOWNESS, at_least=0.0)] = None
    damping: Annotated[float, Real(units.VISCOSITY, at_least=0.0)] = 0.0
    mass_damping: Annotated[float, Real(units.FREQUENCY, at_least=0.0)] = 0.0
    surface_damping: Annotated[float, Real(units.AREAL_VISCOSITY, at_least=0.0)] = 0.0


class SimulateEntries(Struct, frozen=True):
    """How the motion is computed.

    Attributes:
        duration: simulated time
        integrator: automatic, or the name of a method
        tolerance: bound of the error of every position, relative to the largest displacement
            so far
        step: fixed time step, instead of a tolerance; needs a named integrator
    """

    duration: Annotated[float, Real(units.TIME, above=0.0)]
    integrator: Annotated[str, OneOf((AUTOMATIC,))] = AUTOMATIC
    tolerance: Annotated[float, Real(units.NUMBER, at_least=FINEST_TOLERANCE, at_most=0.1)] = (
        DEFAULT_TOLERANCE
    )
    step: Annotated[float | None, Real(units.TIME, above=0.0)] = None


def environment_entries() -> dict[str, Entry]:
    """The entries of environment."""
    plane = written(
        SYMMETRIC, "a plane of symmetry: the scene is one side of it",
        f"{SYMMETRIC} through POINT facing VECTOR", repeats=True,
    )  # fmt: skip
    return {plane.name: plane, **entries_of(EnvironmentEntries)}


def simulate_schema() -> dict[str, Entry]:
    """The entries of simulate with the integrators there are."""
    return with_choices(SimulateEntries, "integrator", integrators(), PROCEDURES)


def integrators() -> dict[str, str | type]:
    """The integrators that can be named, with their classes or descriptions."""
    return {
        AUTOMATIC: "Chosen automatically; the run shows which and why.",
        **INTEGRATORS,
        EQUILIBRIUM: "Statics: equilibria by Newton's method, without inertia.",
        RELAXATION: "The published procedure without inertia: nodes are relaxed.",
    }


declare(
    "environment", "Global conditions: gravity, contact, damping.", 40, "single",
    example="environment { gravity = (0, 0, -9.81) m/s^2 }", block=block(environment_entries),
    entries_vary=True,
)  # fmt: skip
declare(
    "simulate", "Duration and numerical method of the run.", 42, "single",
    example="simulate { duration = 1 s }", block=block(simulate_schema), entries_vary=True,
)  # fmt: skip


def read_environment(declarations: Declarations, main: s.Module, scope: Scope) -> Environment:
    """Return the environment; a scene without one is rejected.

    Gravity has no default, so that every scene says which one it has.
    """
    block = _single(
        "environment",
        "environment { gravity = (0, 0, -9.81) m/s^2 }",
        declarations,
        main,
        scope.findings,
    )
    planes = tuple(filter(_is_plane, block.items))
    others = [item for item in block.items if not _is_plane(item)]
    for item in others:
        if isinstance(item, s.Sentence | s.Assign | s.Block) and item.name.key.startswith(
            "sym"
        ):
            hint = f"write: {PLANE_FORM}"
            scope.findings.reject(
                "TIS312", "wrong form of a plane of symmetry", item.span, hint=hint
            )
    entries, places = schema.build(
        EnvironmentEntries, others, scope, what="environment", where=block.head
    )
    gravity = np.asarray(entries.gravity, dtype=float)
    return Environment(
        gravity,
        entries.damping,
        entries.mass_damping,
        entries.surface_damping,
        _contact_law(entries, places, scope),
        block.head,
        planes,
    )


def _is_plane(item: s.Item) -> TypeGuard[s.Sentence]:
    return isinstance(item, s.Sentence) and item.name.key == SYMMETRIC


def _refuse_contact_twice(
    entries: EnvironmentEntries, places: Mapping[str, Span], scope: Scope
) -> None:
    """Reject contact entries that exclude each other."""
    if "contact stiffness" in places and "contact surface stiffness" in places:
        scope.findings.reject(
            "TIS306",
            "contact stiffness and contact surface stiffness exclude each other",
            places["contact surface stiffness"],
            hint=leaving_out(
                "remove one of them",
                places["contact surface stiffness"],
                places["contact stiffness"],
            ),
            notes=(Note("the other entry", places["contact stiffness"]),),
        )
    if entries.contact_places == "faces" and "contact stiffness" in places:
        scope.findings.reject(
            "TIS306",
            "a contact stiffness is that of each node, but contact places is faces",
            places["contact stiffness"],
            hint="write a contact surface stiffness, or: contact places is nodes",
            notes=(Note("the other entry", places["contact places"]),),
        )


def _contact_law(
    entries: EnvironmentEntries, places: Mapping[str, Span], scope: Scope
) -> ContactLaw | None:
    """Return the law of contact; None if contact is off, which rejects entries of contact."""
    if entries.contact != "off":
        _refuse_contact_twice(entries, places, scope)
        if entries.contact == "tools only" and "contact thickness" in places:
            scope.findings.add(
                "W407",
                "contact thickness has no effect: bodies do not touch one another",
                places["contact thickness"],
                hint=leaving_out(
                    "write contact is bodies too, or remove it", places["contact thickness"]
                ),
            )
        return ContactLaw(
            between_bodies=entries.contact != "tools only",
            within_bodies=entries.contact == "everywhere",
            stiffness=entries.contact_stiffness,
            surface_stiffness=entries.contact_surface_stiffness,
            thickness=entries.contact_thickness,
            layer=entries.contact_layer,
            damping=entries.contact_damping or 0.0,
            friction=entries.friction,
            places=entries.contact_places or "",
        )
    named = ("places", "stiffness", "surface stiffness", "thickness", "layer", "damping")
    written = (f"contact {name}" for name in named)
    for name in ("friction", *written):
        if name in places:
            scope.findings.reject(
                "TIS306",
                f"{name} has no effect while contact is off",
                places[name],
                hint=Hint(
                    "write: contact is tools only",
                    Edit(
                        f"contact is tools only; {places[name].text}",
                        places[name],
                    ),
                ),
            )
    return None


def read_simulation(declarations: Declarations, main: s.Module, scope: Scope) -> Simulation:
    """Return the simulate block, as far as it has no errors; a scene without one is rejected.

    An erroneous duration is replaced by infinity, so that no event seems to come after it.
    """
    block = _single(
        "simulate", "simulate { duration = 1 s }", declarations, main, scope.findings
    )
    entries = entries_of(SimulateEntries)
    failures = scope.findings.failures
    values, places = schema.read(simulate_schema(), block.items, scope, what="simulate")
    is_whole = scope.findings.failures == failures  # else what is missing may be what is wrong
    if is_whole and "duration" not in places:
        scope.findings.add(
            "TIS304",
            'simulate needs "duration"',
            block.head,
            hint=schema.missing(entries["duration"].example, block.head),
        )
    values.setdefault("duration", math.inf)
    read = SimulateEntries(**values)
    with scope.findings.item():
        _refuse_contradictions(read, places, scope, is_whole=is_whole)
    step = read.step
    if step is None and read.integrator == EQUILIBRIUM:
        step = read.duration / LOAD_STEPS
    tolerance = read.tolerance if step is None else None
    choices = None
    with scope.findings.item():
        choices = _choices(read.integrator, block, scope)
    return Simulation(read.duration, read.integrator, tolerance, step, block.head, choices)


def _choices(name: str, block: s.Block, scope: Scope) -> Choices | None:
    """Return the entries chosen for a published procedure; None for other methods."""
    written = [i for i in block.items if isinstance(i, s.Block) and i.name.key == "integrator"]
    if name in PROCEDURES:
        items = written[0].items if written else ()
        where = written[0].head if written else block.head
        return schema.build(PROCEDURES[name], items, scope, what=name, where=where)[0]
    if written:
        scope.findings.reject(
            "TIS303",
            f"{name} does not have entries",
            written[0].span,
            hint=f"only {' and '.join(PROCEDURES)} can have entries",
        )
    return None


def _refuse_contradictions(
    read: SimulateEntries, places: Mapping[str, Span], scope: Scope, *, is_whole: bool
) -> None:
    """Reject entries that do not go together; of those that are missing, if none is wrong."""
    if read.step is not None and "tolerance" in places:
        scope.findings.reject(
            "TIS306",
            "a fixed step cannot guarantee a tolerance",
            places["tolerance"],
            hint=leaving_out("remove step or tolerance", places["tolerance"], places["step"]),
        )
    if not is_whole:
        return
    if read.step is not None and read.integrator == AUTOMATIC:
        scope.findings.reject(
            "TIS306",
            "a fixed step needs a named integrator",
            places["step"],
            hint=Hint(
                "for example: integrator is velocity verlet",
                insertion("; integrator is velocity verlet", places["step"]),
            ),
        )
    if read.integrator == EQUILIBRIUM:
        if "tolerance" in places:
            scope.findings.reject(
                "TIS306",
                "equilibrium needs no tolerance: all forces balance within rounding",
                places["tolerance"],
                hint=leaving_out("remove the tolerance", places["tolerance"]),
            )
    elif read.step is None and read.integrator != AUTOMATIC:
        _refuse_tolerance(read.integrator, places["integrator"], scope)


def _refuse_tolerance(name: str, place: Span, scope: Scope) -> None:
    """Reject a method that cannot keep a tolerance."""
    if name in STATIC or not INTEGRATORS[name].promises:
        scope.findings.reject(
            "TIS306",
            f"{name} does not estimate the error, so it cannot guarantee a tolerance",
            place,
            hint="write the time between its states instead, such as step = 10 ms",
        )


def _single(
    kind: str, example: str, declarations: Declarations, main: s.Module, findings: Findings
) -> s.Block:
    if kind not in declarations.single:
        if findings.may_be_misspelt(kind):
            findings.stop()
        findings.reject(
            "TIS304",
            f"the scene has no {kind} block",
            whole(main),
            hint=Hint(f"for example: {example}", last_line(example, main.source)),
        )
    return declarations.single[kind]
