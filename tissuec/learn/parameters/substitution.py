"""A scene with other numbers in tissues and forces: learnt numbers replace written ones."""

from collections.abc import Mapping
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from tissuec.compiler.compile import Compiled, compile_scene
from tissuec.compiler.learning.laws import force_with_params
from tissuec.core.names import key_of
from tissuec.laws.formula import as_formula
from tissuec.scene.model import Body, Joint, Region, Scene, Tissue, WrittenForce, WrittenLaw
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.findings import Findings
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
        scene: The scene.
        given: Numbers of tissues and forces.
        constants: Constants of laws by name; numbers, or formulas that replace them.
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
    laws = {word: _changed_law(law, inner, scene) for word, law in found.laws.items()}
    return replace(found, written_laws=laws)


def _changed_law(written: WrittenLaw, constants: Mapping[str, Any], scene: Scene) -> WrittenLaw:
    """Return a law with other constants, as far as they are its own."""
    if written.law is None:
        params = {name: as_formula(value) for name, value in constants.items()}
        return replace(written, force=force_with_params(written, scene, params))
    own = {name: value for name, value in constants.items() if hasattr(written.law, name)}
    if not own:
        return written
    former: Any = written.law  # which is a Struct
    law: Any = replace(former, **own)
    return replace(written, law=law, force=law.force())


def recompiled(compiled: Compiled, given: Numbers, constants: Numbers) -> Compiled:
    """Return a compiled scene with other numbers; see ``changed``.

    Nothing ends its run early: data says until when there is something to compare.

    Raises:
        CompileError: The numbers make no scene.
    """
    found = compile_scene(changed(compiled.scene, given, constants), Findings())
    return replace(found, plan=without_end(found.plan))
