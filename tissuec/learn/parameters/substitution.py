"""A scene with other numbers in tissues and forces, compiled again.

A number of a tissue changes every entry of the arrays that is made of it, whatever shares and
interfaces do. Compiling is linear in it, so that a small difference gives its derivative to
rounding, and a net is a sum that nothing is compiled for. It is not linear where the softer of
two tissues decides, in shares that relax, or where a retardation time is learnt beside a
Young's modulus; what a force makes of its numbers may be anything.
"""

from collections.abc import Mapping, Set
from typing import Any

from msgspec import Struct

from tissuec.compiler.compile import Compiled, compile_scene
from tissuec.compiler.learning.laws import with_constants
from tissuec.core.names import key_of
from tissuec.core.structs import replace
from tissuec.learn.parameters.elements import OpenElements, elements_of, with_open
from tissuec.learn.parameters.numbers import NO_FIELDS, NumberOrder, every_field
from tissuec.model.inelastic import TIMES, VISCOSITY
from tissuec.model.network import Floats
from tissuec.scene.model import Body, Joint, Region, Scene, Tissue, WrittenForce
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import (
    DENSITY,
    FIBRE_MODULUS,
    POISSONS_RATIO,
    RETARDATION_TIME,
    SHARES,
    YOUNGS_MODULUS,
)
from tissuec.script.verbs.end import without_end


class UsePlace(Struct, frozen=True):
    """A place where a number is used.

    Attributes:
        tissue: Lower-case name of a tissue.
        part: Of a body and one of its parts, "" for the body itself; None: wherever the tissue
            is used.
    """

    tissue: str
    part: tuple[str, str] | None = None


class ForcePlace(Struct, frozen=True):
    """The block of a force, by its lower-case name, whose entries are numbers."""

    force: str


#: What a number is: its place, and its quantity, constant of a law or entry of a force.
Number = tuple[UsePlace | ForcePlace, str]
#: Numbers in SI units.
Numbers = Mapping[Number, Any]


def changed(scene: Scene, given: Numbers, constants: Numbers) -> Scene:
    """Return a scene with other numbers.

    Args:
        given: Numbers of tissues and forces.
        constants: Constants of laws by name; numbers, or formulas that replace them.

    Raises:
        CompileError: A law does not exist with its constants.
    """

    def tissue(old: Tissue | None, part: tuple[str, str]) -> Tissue | None:
        return None if old is None else _changed_tissue(scene, old, part, given, constants)

    def body(old: Body) -> Body:
        key = key_of(old.name)

        def region(one: Region) -> Region:
            before = one.tissue or _own(old, given, key, one.name)
            inherits = one.tissue is None and before is not None
            return replace(
                one,
                tissue=tissue(before, (key, key_of(one.name))),
                graded=(*old.graded, *one.graded) if inherits else one.graded,
            )

        regions = tuple(map(region, old.regions))
        springs = tuple(
            replace(part, tissue=tissue(part.tissue, ("", ""))) for part in old.spring_parts
        )
        own = tissue(old.tissue, (key, ""))
        return replace(old, tissue=own, regions=regions, spring_parts=springs)

    def joint(old: Joint) -> Joint:
        new = tissue(old.tissue, (key_of(old.name), ""))
        assert new is not None
        return replace(old, tissue=new)

    return replace(
        scene,
        bodies={key: body(old) for key, old in scene.bodies.items()},
        joints={key: joint(old) for key, old in scene.joints.items()},
        forces={key: _changed_force(key, old, given) for key, old in scene.forces.items()},
    )


def _changed_force(key: str, old: WrittenForce, given: Numbers) -> WrittenForce:
    entries = entries_of(type(old.entries))
    own = {
        entries[name].field: float(value)
        for (place, name), value in given.items()
        if place == ForcePlace(key)
    }
    if not own:
        return old
    former: Any = old.entries  # which is a Struct
    return replace(old, entries=replace(former, **own))


def _own(body: Body, given: Numbers, key: str, region: str) -> Tissue | None:
    """Return the tissue of a body for a region without one that is changed by itself."""
    mine = (key, key_of(region))
    parts = (place.part for place, _ in given if isinstance(place, UsePlace))
    return body.tissue if mine in parts else None


def _changed_tissue(
    scene: Scene, old: Tissue, part: tuple[str, str], given: Numbers, constants: Numbers
) -> Tissue:
    key = key_of(old.name)

    def mine(numbers: Numbers) -> dict[str, Any]:
        return {
            name: value
            for (place, name), value in numbers.items()
            if isinstance(place, UsePlace)
            and place.tissue == key
            and place.part in (None, part)
        }

    quantities, inner = mine(given), mine(constants)
    if not quantities and not inner:
        return old
    new = {
        **old.given,
        **{name: replace(old.given[name], value=float(v)) for name, v in quantities.items()},
    }
    found = replace(old, given=new)
    if not inner:
        return found
    laws = {word: with_constants(word, law, inner, scene) for word, law in found.laws.items()}
    return replace(found, written_laws=laws)


def recompiled(compiled: Compiled, given: Numbers, constants: Numbers) -> Compiled:
    """Return a compiled scene with other numbers; see ``changed``.

    Nothing ends its run early: data says until when there is something to compare.

    Raises:
        CompileError: The numbers make no scene.
    """
    found = compile_scene(changed(compiled.scene, given, constants), Findings())
    return replace(found, plan=without_end(found.plan))


#: Numbers of matter in which those of elements are linear, each by itself.
_LINEAR = {YOUNGS_MODULUS, FIBRE_MODULUS, DENSITY}
STEP = 2.0**-20  # of a number, by which what is linear in it is derived


class Compilations:
    """Nets of a scene with other numbers in its tissues and forces.

    Args:
        compiled: The scene as one experiment has it.
        variables: Constants of laws that may change, as variables of formulas.
        first: Numbers at the beginning, of tissues, forces and laws of elements.
        constants: Which of them are of laws.
        elements: That have laws with variables.
    """

    def __init__(
        self, compiled: Compiled, order: NumberOrder, variables: Numbers, first: Numbers,
        constants: Set[Number], elements: OpenElements,
    ):  # fmt: skip
        self._compiled, self._order = compiled, order
        self._variables, self._first = variables, first
        self._constants, self._elements = constants, elements
        # Which of two tissues is the softer decides for all of their springs.
        bodies = compiled.scene.bodies.values()
        rules = {body.interface for body in bodies}
        rules |= {part.rule for body in bodies for part in body.spring_parts}
        self._is_linear = rules <= {"", "mean"}
        # A retardation time is multiplied by a Young's modulus.
        words = {word for _, word in first}
        self._is_linear &= not {YOUNGS_MODULUS, RETARDATION_TIME} <= words
        self._is_linear &= words.isdisjoint(SHARES)
        # Bulk moduli are not linear in Poisson's ratio, nor in what damps these.
        self._is_linear &= words.isdisjoint({POISSONS_RATIO, *TIMES, VISCOSITY})
        self._is_linear &= all(isinstance(place, UsePlace) for place, _ in first)
        if elements_of(compiled.network):
            self._is_linear &= words <= _LINEAR and compiled.network.contact is None
            # Where densities differ, the sum of their moments says which masses have these.
            self._is_linear &= not (DENSITY in words and any(body.regions for body in bodies))
        self._columns: dict[Number, Floats] = {}
        self._at: tuple[float, ...] | None = None  # where the columns hold, if anywhere
        self._base: Floats | None = None

    def vector(self, given: Numbers) -> Floats:
        """Return the numbers of the net in SI units, with 0 for those of laws, shape (number,).

        Raises:
            CompileError: The numbers make no scene.
        """
        if not self._is_linear:
            return self._made(given)
        total = self._begun().copy()
        for key, value in given.items():
            if value != self._first[key]:
                total += (value - self._first[key]) * self.column(key, given)
        return total

    def column(self, key: Number, given: Numbers) -> Floats:
        """Return the derivative by one of these numbers, in SI units, shape (number,).

        Args:
            given: Present numbers.

        Raises:
            CompileError: The numbers make no scene.
        """
        if not self._is_linear and self._at != tuple(given.values()):
            self._at, self._columns, self._base = tuple(given.values()), {}, self._made(given)
        if key not in self._columns:
            here = self._first if self._is_linear else given
            step = STEP * (abs(here[key]) or 1.0)
            moved = self._made({**here, key: here[key] + step})
            before, apart = self._begun(), step
            if not self._is_linear:
                before, apart = self._made({**here, key: here[key] - step}), 2.0 * step
            self._columns[key] = (moved - before) / apart
        return self._columns[key]

    def _begun(self) -> Floats:
        """Return the numbers from which differences are taken."""
        if self._base is None:
            self._base = self._made(self._first)
        return self._base

    def _made(self, given: Numbers) -> Floats:
        """Return the numbers of a net that is compiled."""
        own = {key: value for key, value in given.items() if key in self._constants}
        rest = {key: value for key, value in given.items() if key not in own}
        found = recompiled(self._compiled, rest, {**self._variables, **own})
        network = with_open(found.network, self._elements)
        fields = every_field(found.plan, network) if self._order.fields else NO_FIELDS
        return self._order.vector(network, fields)
