"""The plane of a section as it is written: an axis and a place, or in the words of cuts."""

from collections.abc import Sequence
from typing import Annotated, NoReturn

import numpy as np

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.units import LENGTH
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.scene.reading.clauses import read_sentence
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.values import Value
from tissuec.script.parts import ChoiceClause
from tissuec.script.verbs.cut import PlaneWords
from tissuec.view.section.plane import SectionPlane

FORM = "through POINT facing VECTOR"
FORMS = 'write "z = 6 mm" or "through (0, 0, 6) mm facing (0, 1, 1)"'
_AXES = ("x", "y", "z")
#: What a cut has before the words of a text, by the first of them.
_BEFORE = {"through": "cut body along plane ", "plane": "cut body along ", "along": "cut body "}
#: Findings whose hints are about whole scenes: the grammar, and names of numbers.
_OF_SCENES = ("TIS100", "TIS107", "TIS301")


class SectionWords(PlaneWords, frozen=True):
    """The plane of a section: ``along plane through POINT facing VECTOR``."""

    along: Annotated[str, ChoiceClause("along", {"plane": "A plane."}, what="section")]


class NoNames(Scope):
    """The scope of a text beside a scene, in which no name has a value."""

    def name(self, name: s.Name) -> NoReturn:
        self.unknown(name)

    def has(self, name: s.Name) -> bool:
        return False

    def names(self) -> Sequence[str]:
        return ()


def plane_of(text: str) -> SectionPlane:
    """Return the plane that a text describes.

    Raises:
        ValueError: It describes none; says where and what to write.
    """
    words = text.replace("(", " ").split()
    if not words:
        raise ValueError(f"a plane is missing; {FORMS}")
    before = _BEFORE.get(words[0].lower(), "")
    findings = Findings()
    try:
        items = parse(normalise(f"{before}{text}", "--section"), has_heading=False).items
        with findings.item():
            return _plane(items, NoNames(findings))
        findings.raise_errors()
    except CompileError as error:
        raise _wrong(text, len(before), error.diagnostics[0]) from None
    raise AssertionError  # without an error, there is a plane


def _plane(items: tuple[s.Item, ...], scope: Scope) -> SectionPlane:
    """Return the plane of the only sentence of a text; rejects any other."""
    match items:
        case (s.Assign(keyword="", name=name, value=value),) if name.key in _AXES:
            found = scope.evaluate(value)
            normal = np.eye(3)[_AXES.index(name.key)]
            offset = _length(found, value, f"the place along {name.key}", scope)
        case (s.Sentence(phrase=None) as cut,) if cut.name.key == "cut body":
            blade = read_sentence(cut, "section", SectionWords, scope, FORM).plane
            normal, offset = blade.normal, float(blade.normal @ blade.origin)
        case _:
            scope.findings.reject("TIS312", "this is not a plane", items[0].span, hint=FORMS)
    x, y, z = normal.tolist()
    return SectionPlane((x, y, z), offset)


def _length(value: Value, node: s.Expression, what: str, scope: Scope) -> float:
    """Return a length [m]; 0 needs no unit."""
    if value.is_vector:
        scope.findings.reject("TIS312", f"{what} is one length", node.span, hint=FORMS)
    if value.amount or not value.is_literal:
        scope.expect(value, LENGTH, node.span, what=what)
    return float(value.amount)


def _wrong(text: str, before: int, finding: Diagnostic) -> ValueError:
    """Return the error with its place in the text.

    Args:
        text: As it was written.
        before: Number of characters before it in the text that was parsed.
        finding: The error.
    """
    assert finding.span is not None
    begin = min(max(finding.span.start - before, 0), len(text) - 1)
    stop = max(min(finding.span.end - before, len(text)), begin + 1)
    hint = FORMS if finding.code in _OF_SCENES else finding.hint or FORMS
    carets = " " * begin + "^" * (stop - begin)
    return ValueError(f"{finding.message}; {hint}\n    {text}\n    {carets}")
