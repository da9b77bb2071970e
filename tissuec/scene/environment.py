"""What acts everywhere: gravity, contact, damping and planes of symmetry."""

from collections.abc import Mapping
from typing import Annotated, TypeGuard

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.errors import Note
from tissuec.core.fields import OneOf, Point, Real
from tissuec.core.hints import Edit, Hint, leaving_out
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.program.imports import whole
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import Entry, entries_of, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.usual_ranges import unusual
from tissuec.script.verbs.cut import PlaneWords

CONTACTS = {
    "off": "Nothing touches.",
    "tools only": "Threads, and tools with a shape, touch bodies.",
    "bodies too": "Bodies touch one another as well.",
    "everywhere": "Bodies touch themselves as well.",
}
CONTACT_PLACES = ("faces", "nodes")

#: How the sentence with a plane of symmetry begins, and how it is written.
SYMMETRIC = "symmetric about plane"
_PLANE = SentenceKind((PlaneWords,), wrong="wrong form of a plane of symmetry")
_EXAMPLE = "environment { gravity = (0, 0, -9.81) m/s^2 }"


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

    @property
    def between_bodies(self) -> bool:
        """Whether surfaces of bodies touch other bodies, if there is contact."""
        return self.contact != "tools only"

    @property
    def within_bodies(self) -> bool:
        """Whether they touch their own body, too."""
        return self.contact == "everywhere"


class Environment(Struct, frozen=True, eq=False):
    """What acts everywhere.

    Attributes:
        entries: As they are written.
        span: Head of the block.
        planes: Of symmetry.
    """

    entries: EnvironmentEntries
    span: Span
    planes: tuple[PlaneWords, ...] = ()

    @property
    def contact(self) -> EnvironmentEntries | None:
        """The entries as the law of contact; None if nothing touches."""
        return self.entries if self.entries.contact != "off" else None

    @property
    def touched(self) -> str:
        """Return where contact acts: on "faces", on those of "elements", on "nodes"; or ""."""
        law = self.contact
        if law is None:
            return ""
        return law.contact_places or ("nodes" if law.contact_stiffness else "elements")

    @classmethod
    def empty(cls, main: s.Module) -> "Environment":
        """The environment in place of a wrong one: nothing acts."""
        return cls(EnvironmentEntries(np.zeros(3)), whole(main))


def environment_entries() -> dict[str, Entry]:
    """The entries of environment."""
    plane = written(
        SYMMETRIC, "a plane of symmetry: the scene is one side of it",
        *_PLANE.forms, repeats=True,
    )  # fmt: skip
    return {plane.name: plane, **entries_of(EnvironmentEntries)}


declare(
    "environment", "Global conditions: gravity, contact, damping.", 40, "single",
    example=_EXAMPLE, block=block(environment_entries),
    entries_vary=True,
)  # fmt: skip


def read_environment(declarations: Declarations, main: s.Module, scope: Scope) -> Environment:
    """Return the environment; a scene without one is rejected.

    Gravity has no default, so that every scene says which one it has.
    """
    block = declarations.required("environment", _EXAMPLE, main, scope.findings)
    planes = [item for item in block.items if _is_plane(item)]
    others = [item for item in block.items if not _is_plane(item)]
    entries, places = schema.build(
        EnvironmentEntries, others, scope, what="environment", where=block.head
    )
    _check_contact(entries, places, scope)
    if "friction" in places and entries.friction is not None:
        strange = unusual("friction", entries.friction, "friction is", places["friction"])
        scope.findings.extend([] if strange is None else [strange])
    said = list[PlaneWords]()
    for item in planes:
        with scope.findings.item():
            said.append(_plane(item, scope))
    return Environment(entries, block.head, tuple(said))


def _is_plane(item: s.Item) -> TypeGuard[s.Sentence | s.Assign | s.Block]:
    """Return whether an item is a plane of symmetry, also if it is written in another form."""
    is_named = isinstance(item, s.Sentence | s.Assign | s.Block)
    return is_named and item.name.key.startswith("sym")


def _plane(item: s.Sentence | s.Assign | s.Block, scope: Scope) -> PlaneWords:
    reader = SentenceReader(SYMMETRIC, _PLANE, item, scope)
    if item.name.key != SYMMETRIC or not isinstance(item, s.Sentence):
        reader.reject_form()
    return reader.get()


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


def _check_contact(
    entries: EnvironmentEntries, places: Mapping[str, Span], scope: Scope
) -> None:
    """Reject entries of contact that are of no use, or that exclude one another."""
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
        return
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
