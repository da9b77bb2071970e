"""Entries that shift, turn, scale or mirror a mesh or a whole body, in the order written."""

import re
from collections.abc import Sequence
from typing import Annotated, Any, NoReturn, TypeAlias, cast

import numpy as np
from msgspec import Struct

from tissuec.core.hints import Edit, Hint, proposal
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, NUMBER
from tissuec.geometry.affine import Affine
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.reading.clauses import ClauseReader
from tissuec.scene.reading.entries import by_name, written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence, form_of
from tissuec.script.parts import (
    AngleClause,
    ClausePart,
    DirectionClause,
    Part,
    VectorClause,
    point,
)

_Entry: TypeAlias = s.Assign | s.Sentence | s.Block


class FactorsClause(ClausePart, frozen=True):
    """A factor above 0, or one for each of x, y and z."""


class PlacementWords(VerbSentence, frozen=True):
    """An entry that places a mesh."""

    @property
    def map(self) -> Affine:
        """The map that it makes."""
        raise NotImplementedError


class MovedWords(PlacementWords, frozen=True):
    by: Annotated[
        Floats,
        VectorClause(
            "by", LENGTH, what="displacement", place="VECTOR", example="by (10, 0, 0) mm"
        ),
    ]

    @property
    def map(self) -> Affine:
        return Affine.moving(self.by)


class TurnedWords(PlacementWords, frozen=True):
    by: Annotated[float, AngleClause("by", what="angle", place="ANGLE", example="by 30 deg")]
    around: Annotated[
        Floats,
        DirectionClause("around", what="axis", place="VECTOR", example="around (0, 0, 1)"),
    ]
    through: Annotated[Floats | None, point("through")]

    @property
    def map(self) -> Affine:
        return Affine.turning(self.by, self.around, _or_origin(self.through))


class ScaledWords(PlacementWords, frozen=True):
    by: Annotated[Floats, FactorsClause("by", what="factor", place="FACTOR", example="by 2")]
    around: Annotated[Floats | None, point("around")]

    @property
    def map(self) -> Affine:
        return Affine.scaling(self.by, _or_origin(self.around))


class MirroredWords(PlacementWords, frozen=True):
    through: Annotated[Floats | None, point("through")]
    facing: Annotated[
        Floats,
        DirectionClause(
            "facing", what="normal of the plane", place="VECTOR", example="facing (1, 0, 0)"
        ),
    ]

    @property
    def map(self) -> Affine:
        return Affine.mirroring(_or_origin(self.through), self.facing)


def _or_origin(point: Floats | None) -> Floats:
    """Return the point that stays where it is [m], shape (3,)."""
    return np.zeros(3) if point is None else point


class PlacementForm(Struct, frozen=True):
    """How an entry that places a mesh is written.

    Attributes:
        kind: The class of its sentences.
        example: As it could be written.
        about: What it does.
        synonyms: Other words for it.
    """

    kind: type[PlacementWords]
    example: str
    about: str
    synonyms: tuple[str, ...]


MOVED, TURNED, SCALED, MIRRORED = "moved", "turned", "scaled", "mirrored about plane"
#: Entries of meshes and bodies, by name.
PLACEMENTS = {
    MOVED: PlacementForm(
        MovedWords,
        "moved by (10, 0, 0) mm",
        "Shifts the mesh, or in a body the whole body.",
        ("move", "moving", "shift", "shifted", "translate", "translated", "offset"),
    ),
    TURNED: PlacementForm(
        TurnedWords,
        "turned by 30 deg around (0, 0, 1) through (0, 0, 0) mm",
        "Turns the mesh or the body about an axis by the right-hand rule; without a point, "
        "the axis passes through the origin.",
        ("turn", "rotate", "rotated", "rotation"),
    ),
    SCALED: PlacementForm(
        ScaledWords,
        "scaled by 2 around (0, 0, 0) mm",
        "Enlarges the mesh or the body by a factor, or by one for each of x, y and z; the "
        "point, by default the origin, stays where it is.",
        ("scale", "scaling", "enlarged", "stretched", "shrunk", "resized"),
    ),
    MIRRORED: PlacementForm(
        MirroredWords,
        "mirrored about plane through (0, 0, 0) mm facing (1, 0, 0)",
        "Mirrors the mesh or the body in a plane; without a point, the plane passes through "
        "the origin.",
        ("mirror", "mirrored", "reflect", "reflected", "flip", "flipped"),
    ),
}
#: The same as declarations of entries.
PLACEMENT_ENTRIES = by_name(
    *(written(name, one.about, one.kind, repeats=True) for name, one in PLACEMENTS.items())
)
_PLANE = re.compile(r"\S+\s+(\S+\s+)?plane\b")  # such as "mirrored at plane"


def is_placement(item: s.Item) -> bool:
    """Return whether an item places a mesh, also if it is written in another form."""
    return isinstance(item, _Entry) and bool(_meant(item))


def read_placement(items: Sequence[s.Item], scope: Scope) -> Affine | None:
    """Return the combined placement by entries, in their order; None without any."""
    found: Affine | None = None
    for item in items:
        with scope.findings.item():
            assert isinstance(item, _Entry)
            one = _read(item, scope)
            found = one if found is None else found.then(one)
    return found


def _meant(item: _Entry) -> str:
    """Return the entry that an item is, or that is meant by another word; "" for others."""
    key = item.name.key
    if key in PLACEMENTS:
        return key
    first = key.partition(" ")[0]
    named = (name for name, one in PLACEMENTS.items() if first in (name, *one.synonyms))
    return next(named, "")


def _read(item: _Entry, scope: Scope) -> Affine:
    name = _meant(item)
    form = PLACEMENTS[name]
    if item.name.key != name or not isinstance(item, s.Sentence) or item.phrase is not None:
        hint: str = f"for example: {form.example}"
        if item.name.key != name and isinstance(item, s.Sentence) and item.phrase is None:
            plane = _PLANE.match(item.span.text) if name == MIRRORED else None
            end = item.span.start + plane.end() if plane else item.name.span.end
            hint = proposal(name, replace(item.name.span, end=end))
        scope.findings.reject("TIS312", f'wrong form of "{name}"', item.span, hint=hint)
    texts = PLACEMENT_ENTRIES[name].forms
    reader = _PlacementReader(item, name, (form_of(form.kind),), scope, texts=texts)
    said = cast(PlacementWords, reader.read())
    reader.finish()
    return said.map


class _PlacementReader(ClauseReader):
    """Reads one entry that places a mesh."""

    def read_other(self, part: Part, *, is_optional: bool) -> Any:
        match part:
            case FactorsClause(word=word):
                return self._factors(word)
            case _:
                return super().read_other(part, is_optional=is_optional)

    def _factors(self, word: str) -> Floats:
        """Return the factors along x, y and z, shape (3,)."""
        node = self.clauses[word].value
        value = self.scope.evaluate(node)
        self.scope.expect(value, NUMBER, node.span, what="the factor")
        factors = np.broadcast_to(np.asarray(value.amount, dtype=float), 3)
        if not (factors > 0.0).all():
            self._refuse_factors(node, factors)
        return factors

    def _refuse_factors(self, node: s.Expression, factors: Floats) -> NoReturn:
        hint = Hint("a factor above 0, for example: scaled by 2")
        if (factors < 0.0).any() and factors.all():
            mirror = PLACEMENTS[MIRRORED].example
            hint = Hint(f"to mirror it, write: {mirror}", Edit(mirror, self.span))
        message = f"a mesh cannot be scaled by {node.span.one_line}"
        self.scope.findings.reject("TIS308", message, node.span, hint=hint)
