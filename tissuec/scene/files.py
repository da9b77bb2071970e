"""Files of numbers that a scene names: ``file "liver.stl" in mm``."""

import os.path
from pathlib import Path, PurePosixPath

from tissuec.core.errors import Note
from tissuec.core.fields import FileIn, LocatedFile
from tissuec.core.hints import Hint, insertion, nearby_file
from tissuec.core.source import Span
from tissuec.core.units import UnitError, describe, parse_unit
from tissuec.lang import syntax as s
from tissuec.meshes.formats import way_of_folder
from tissuec.scene.program.library import LINK, LINKED, Library
from tissuec.scene.reading.expressions import Scope


def read_file(kind: FileIn, item: s.Sentence, scope: Scope, *, example: str) -> LocatedFile:
    """Return the file that a sentence names with its unit, or reject the sentence.

    Args:
        kind: What the entry accepts.
    """
    wanted = item.name.quoted or ""
    factor = _factor(kind, item, scope, example)
    return LocatedFile(wanted, _find(wanted, item.name.span, scope), factor, item.span)


def _factor(kind: FileIn, item: s.Sentence, scope: Scope, example: str) -> float:
    """Return the SI units in the unit after ``in``."""
    findings = scope.findings
    for clause in item.clauses[1:] or item.clauses:
        if clause.word != "in" or len(item.clauses) > 1:
            findings.reject("TIS303", f'unexpected "{clause.word}"', clause.span)
    if not item.clauses:
        findings.reject(
            "TIS304",
            "the unit of the file is missing",
            item.span,
            hint=Hint(f"for example: {item.span.text} in mm", insertion(" in mm", item.span)),
        )
    place = item.clauses[0].value.span
    try:
        unit = parse_unit(place.text)
    except UnitError as error:
        findings.reject("TIS104", str(error), place)
    if unit.dimension != kind.dimension:
        wanted, found = describe(kind.dimension), describe(unit.dimension)
        findings.reject(
            "TIS502", f"the unit of the file is {wanted}; {place.text} is {found}", place
        )
    return unit.factor


def _find(wanted: str, span: Span, scope: Scope) -> Path:
    """Return where a file lies: beside the text that names it, or in a library."""
    path = PurePosixPath(wanted)
    if path.is_absolute() or ".." in path.parts or set("\\:\0") & set(wanted):
        scope.findings.reject(
            "TIS603",
            f'"{wanted}" is outside the folder of the scene',
            span,
            hint="put the file beside the scene",
        )
    here = Library.of(span.source)
    folders = (here.beside, *here.folders[:1], *(scope.library or here).folders)
    places = [folder / path for folder in dict.fromkeys(folders)]
    for place in places:
        if os.path.isfile(place):
            if all(library.leads_out(place) for library in (here, scope.library or here)):
                scope.findings.reject("TIS603", LINK.format(wanted), span, hint=LINKED)
            return place
    for place in places:
        if os.path.isdir(place):
            way = way_of_folder(place)
            scope.findings.reject("TIS604", f'"{wanted}" is a folder', span, hint=way)
    scope.findings.reject(
        "TIS604",
        f'there is no file "{wanted}"',
        span,
        hint=nearby_file(places[0], path.suffix, here.beside),
        notes=tuple(Note(f"searched {place}") for place in places),
    )
