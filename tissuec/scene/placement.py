"""Entries that shift, turn, scale or mirror a mesh or a whole body, in the order written."""

import re
from collections.abc import Sequence
from typing import NoReturn, TypeAlias

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core import units
from tissuec.core.fields import Point
from tissuec.core.hints import Edit, Hint, proposal
from tissuec.geometry.affine import Affine
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene import schema
from tissuec.scene.entries import by_name, written
from tissuec.scene.expressions import Scope
from tissuec.scene.values import unit_vector

_Entry: TypeAlias = s.Assign | s.Sentence | s.Block


class PlacementForm(Struct, frozen=True):
    """How an entry that places a mesh is written.

    Attributes:
        form: The form, with placeholders for values.
        example: As it could be written.
        about: What it does.
        synonyms: Other words for it.
    """

    form: str
    example: str
    about: str
    synonyms: tuple[str, ...]

    @property
    def clauses(self) -> tuple[str, ...]:
        """Return the joining words of the form."""
        return tuple(word for word in self.form.split() if word in _JOINING)


_JOINING = ("by", "around", "through", "facing")
MOVED, TURNED, SCALED, MIRRORED = "moved", "turned", "scaled", "mirrored about plane"
#: Entries of meshes and bodies, by name.
PLACEMENTS = {
    MOVED: PlacementForm(
        "moved by VECTOR",
        "moved by (10, 0, 0) mm",
        "Shifts the mesh, or in a body the whole body.",
        ("move", "moving", "shift", "shifted", "translate", "translated", "offset"),
    ),
    TURNED: PlacementForm(
        "turned by ANGLE around VECTOR through POINT",
        "turned by 30 deg around (0, 0, 1) through (0, 0, 0) mm",
        "Turns the mesh or the body about an axis by the right-hand rule; without a point, "
        "the axis passes through the origin.",
        ("turn", "rotate", "rotated", "rotation"),
    ),
    SCALED: PlacementForm(
        "scaled by FACTOR around POINT",
        "scaled by 2 around (0, 0, 0) mm",
        "Enlarges the mesh or the body by a factor, or by one for each of x, y and z; the "
        "point, by default the origin, stays where it is.",
        ("scale", "scaling", "enlarged", "stretched", "shrunk", "resized"),
    ),
    MIRRORED: PlacementForm(
        "mirrored about plane through POINT facing VECTOR",
        "mirrored about plane through (0, 0, 0) mm facing (1, 0, 0)",
        "Mirrors the mesh or the body in a plane; without a point, the plane passes through "
        "the origin.",
        ("mirror", "mirrored", "reflect", "reflected", "flip", "flipped"),
    ),
}
#: The same as declarations of entries.
PLACEMENT_ENTRIES = by_name(
    *(written(name, one.about, one.form, repeats=True) for name, one in PLACEMENTS.items())
)
_ORIGIN = np.zeros(3)
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
    name, findings = _meant(item), scope.findings
    form = PLACEMENTS[name]
    if item.name.key != name or not isinstance(item, s.Sentence) or item.phrase is not None:
        hint: str = f"for example: {form.example}"
        if item.name.key != name and isinstance(item, s.Sentence) and item.phrase is None:
            plane = _PLANE.match(item.span.text) if name == MIRRORED else None
            end = item.span.start + plane.end() if plane else item.name.span.end
            hint = proposal(name, replace(item.name.span, end=end))
        findings.reject("TIS312", f'wrong form of "{name}"', item.span, hint=hint)
    clauses: dict[str, s.Clause] = {}
    for clause in item.clauses:
        if clause.word not in form.clauses:
            findings.reject(
                "TIS303", f'unexpected "{clause.word}"', clause.span,
                hint=f"write: {form.form}",
            )  # fmt: skip
        if clause.word in clauses:
            first = clauses[clause.word].span
            findings.refuse_second(f'"{clause.word}"', clause.span, first)
        clauses[clause.word] = clause
    return _PlacementReader(item, form, clauses, scope).read(name)


class _PlacementReader:
    """Reads the values of one entry."""

    def __init__(
        self, item: s.Sentence, form: PlacementForm, clauses: dict[str, s.Clause], scope: Scope
    ):
        self._item, self._form = item, form
        self._clauses, self._scope = clauses, scope

    def read(self, name: str) -> Affine:
        if name == MOVED:
            return Affine.moving(self._point("by"))
        if name == TURNED:
            angle = self._angle()
            return Affine.turning(angle, self._direction("around"), self._fixed("through"))
        if name == SCALED:
            return Affine.scaling(self._factors(), self._fixed("around"))
        return Affine.mirroring(self._fixed("through"), self._direction("facing"))

    def _clause(self, word: str) -> s.Expression:
        if word not in self._clauses:
            self._scope.findings.reject(
                "TIS304", f'"{self._item.name.text}" needs "{word}"', self._item.span,
                hint=f"for example: {self._form.example}",
            )  # fmt: skip
        return self._clauses[word].value

    def _vector(self, word: str) -> s.Expression:
        """Return the value of a clause, which is a vector."""
        node = self._clause(word)
        if not self._scope.evaluate(node).is_vector:
            self._scope.findings.reject(
                "TIS312",
                f"{word} needs a vector (x, y, z)",
                node.span,
                hint=f"for example: {self._form.example}",
            )
        return node

    def _point(self, word: str) -> Floats:
        """Return the point or shift of a clause [m], shape (3,)."""
        kind, node = Point(units.LENGTH), self._vector(word)
        found = schema.read_value(kind, node, self._scope, what=f"the value after {word}")
        return np.asarray(found, dtype=float)

    def _fixed(self, word: str) -> Floats:
        """Return the point that stays where it is [m], shape (3,): by default the origin."""
        return self._point(word) if word in self._clauses else _ORIGIN

    def _direction(self, word: str) -> Floats:
        """Return the unit vector of a clause, shape (3,)."""
        kind, node = Point(units.NUMBER), self._vector(word)
        found = schema.read_value(kind, node, self._scope, what=f"the direction after {word}")
        direction = unit_vector(np.asarray(found, dtype=float))
        if direction is None:
            self._scope.findings.reject(
                "TIS308", "a direction cannot be (0, 0, 0)", node.span,
                hint=f"for example: {word} (0, 0, 1)",
            )  # fmt: skip
        return direction

    def _angle(self) -> float:
        """Return the angle of a turn [rad]."""
        node = self._clause("by")
        value = self._scope.number(node)
        self._scope.expect(value, units.NUMBER, node.span, what="the angle")
        angle = float(value.amount)
        if value.is_literal and abs(angle) > 2.0 * np.pi:
            self._scope.findings.reject(
                "TIS308", f"an angle of {angle:g} rad is more than a whole turn", node.span,
                hint=proposal(f"{node.span.text} deg"),
            )  # fmt: skip
        return angle

    def _factors(self) -> Floats:
        """Return the factors along x, y and z, shape (3,)."""
        node = self._clause("by")
        value = self._scope.evaluate(node)
        self._scope.expect(value, units.NUMBER, node.span, what="the factor")
        factors = np.broadcast_to(np.asarray(value.amount, dtype=float), 3)
        if not (factors > 0.0).all():
            self._refuse_factors(node, factors)
        return factors

    def _refuse_factors(self, node: s.Expression, factors: Floats) -> NoReturn:
        hint = Hint("a factor above 0, for example: scaled by 2")
        if (factors < 0.0).any() and factors.all():
            mirror = PLACEMENTS[MIRRORED].example
            hint = Hint(f"to mirror it, write: {mirror}", Edit(mirror, self._item.span))
        message = f"a mesh cannot be scaled by {node.span.one_line}"
        self._scope.findings.reject("TIS308", message, node.span, hint=hint)
