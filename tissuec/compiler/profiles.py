"""Time profiles as written: ``using smooth profile``, ``using table "file.csv"``."""

from collections.abc import Sequence
from pathlib import PurePosixPath

import numpy as np

from tissuec.compiler.clauses import ClauseReader
from tissuec.core.errors import CompileError
from tissuec.core.hints import Edit, Hint, alternatives, insertion
from tissuec.core.interpolation import monotone_slopes
from tissuec.core.units import FREQUENCY, LENGTH, UnitError, parse_unit
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.model.network import Floats
from tissuec.model.profiles import ProfileKind, TimeProfile
from tissuec.scene.imports import read_source
from tissuec.scene.library import LINK, LINKED, Library

TABLE = "table"
#: Written name -> kind of profile. Motions and forces are spelled in their own words.
PROFILES: dict[str, ProfileKind] = {
    "constant": "constant",
    "constant speed": "ramp",
    "ramp": "ramp",
    "smooth profile": "smooth",
    "sine": "sine",
    TABLE: "table",
}
#: What profiles are called elsewhere.
_SPOKEN = {
    "linear": "constant speed", "uniform": "constant speed", "smooth": "smooth profile",
    "smoothstep": "smooth profile", "sinus": "sine",
}  # fmt: skip
_NEED_AN_END = ("ramp", "smooth")


def read_profiles(
    clause: s.Clause | None, default: str, columns: int, order: ClauseReader
) -> tuple[TimeProfile, ...]:
    """Return the profiles of a clause, beginning at 0 s; one per column of a table.

    Args:
        clause: The clause; None if it is not written.
        default: Name of the profile without a clause; empty if it must be written.
        columns: Number of columns that a table must have.
        order: The sentence.
    """
    name = default if clause is None else _profile_name(clause, order)
    word = clause.word if clause else None
    if name not in PROFILES:
        hint = _profiles(name, is_motion=not default)
        if clause is None or not name:
            problem = "the profile of the motion is missing"
            order.reject("TIS304", problem, hint=hint, word=word)
        problem = f'there is no profile "{clause.value.span.text}"'
        order.reject("TIS305", problem, hint=hint, word=word)
    kind = PROFILES[name]
    stop = np.inf if order.duration is None else order.duration
    if kind in _NEED_AN_END and order.duration is None:
        hint = "use from … to …: instead of at …:"
        order.reject("TIS304", f"{name} needs an interval", hint=hint, word=word)
    if kind == "sine":
        if not order.has("of"):
            hint = Hint("for example: using sine of 2 Hz", Edit("using sine of 2 Hz"))
            order.reject("TIS304", "the frequency of the sine is missing", hint=hint, word=word)
        frequency = order.number("of", FREQUENCY)
        return (TimeProfile("sine", 0.0, stop, frequency),) * columns
    if kind == TABLE:
        assert clause is not None
        return _table_profiles(clause, columns, stop, order)
    return (TimeProfile(kind, 0.0, stop),) * columns


def _profiles(name: str, *, is_motion: bool) -> Hint:
    """Return a hint with the profiles; a motion begins with none that jumps."""
    known = [one for one, kind in PROFILES.items() if not (is_motion and kind == "constant")]
    if meant := _SPOKEN.get(name):
        return Hint(f'did you mean "{meant}"?', Edit(meant, old=name))
    return alternatives(name, known, what="profiles after using")


def _profile_name(clause: s.Clause, order: ClauseReader) -> str:
    if not isinstance(clause.value, s.Name):
        order.reject("TIS312", "a profile must be a name", word=clause.word)
    if clause.value.quoted is not None:
        return clause.value.words.lower()
    return clause.value.key


def _table_profiles(
    clause: s.Clause, columns: int, stop: float, order: ClauseReader
) -> tuple[TimeProfile, ...]:
    assert isinstance(clause.value, s.Name)
    factor = _length_unit(clause, order) if columns > 1 else 1.0
    rows = _read_csv(clause, clause.value, 1 + columns, order)
    times, values = rows[:, 0], rows[:, 1:]
    if times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
        order.reject(
            "TIS313",
            f"the times in {clause.value.quoted} do not ascend from 0 s",
            hint="sort the rows by time, each time once",
            word=clause.word,
        )
    if times[0] > 0.0:  # what comes before the first row is as in that row
        times, values = np.concatenate([[0.0], times]), np.concatenate([values[:1], values])
    end = min(stop, float(times[-1]))
    with np.errstate(all="ignore"):
        values = values * factor
        slopes = [monotone_slopes(times, column) for column in values.T.copy()]
    if not np.all(np.isfinite(slopes)):
        message = f"the numbers in {clause.value.quoted} change too rapidly"
        order.reject("TIS313", message, hint="check the times and the units", word=clause.word)
    return tuple(
        TimeProfile("table", 0.0, end, 0.0, times, column, slope)
        for column, slope in zip(values.T.copy(), slopes, strict=True)
    )


def table_texts(items: Sequence[s.Item], library: Library) -> dict[str, str]:
    """Return the texts of the tables that a script names, by the names that it has for them.

    Args:
        items: Of a script that was read without a mistake.
        library: Of the scene.
    """
    found: dict[str, str] = {}
    for name in names_in(tuple(items)):
        if name.quoted is not None and name.words.lower() == TABLE:
            path, scene = str(PurePosixPath(name.quoted)), name.span.source.path
            text = library.kept_text(path)
            if text is None and scene is not None:
                text = read_source(scene.parent / path, path).text
            found |= {path: text} if text is not None else {}
    return found


def _length_unit(clause: s.Clause, order: ClauseReader) -> float:
    """Return the metres in the unit of ``in mm``."""
    if not order.has("in"):
        path = clause.span
        hint = Hint(f"for example: {path.text} in mm", insertion(" in mm", path))
        order.reject("TIS304", "the unit of the path is missing", hint=hint, word=clause.word)
    text = order.text("in")
    example = Hint("for example: in mm", Edit("in mm"))
    try:
        unit = parse_unit(text)
    except UnitError as error:
        order.reject("TIS104", str(error), hint=example, word="in")
    if unit.dimension != LENGTH:
        message = f"a path needs a unit of length; {text} is not one"
        order.reject("TIS502", message, hint=example, word="in")
    return unit.factor


def _read_csv(clause: s.Clause, name: s.Name, columns: int, order: ClauseReader) -> Floats:
    """Return the numbers of a file beside the scene, shape (row, column), at least two rows."""
    path = PurePosixPath(name.quoted or "")
    form = "each row has a time in s and " + ("one number" if columns == 2 else "x, y and z")
    rows: list[list[float]] = []
    lines = [
        (number, line)
        for number, line in enumerate(
            _text_beside(name, path, order, clause.word).split("\n"), 1
        )
        if line.strip() and not line.lstrip().startswith("#")
    ]
    for place, (number, line) in enumerate(lines):
        row = _numbers(line, columns)
        if row is None and place == 0:
            continue  # the names of the columns
        if row is None or len(row) < columns or not np.all(np.isfinite(row)):
            message = f"line {number} of {path} is not a row of {columns} numbers"
            order.reject("TIS313", message, hint=form, word=clause.word)
        rows.append(row)
    if len(rows) < 2:
        message = f"{path} contains fewer than two rows of numbers"
        order.reject("TIS313", message, hint=form, word=clause.word)
    return np.array(rows)


def _text_beside(name: s.Name, path: PurePosixPath, order: ClauseReader, word: str) -> str:
    """Return the text of a file beside the scene that names it behind ``word``."""
    if path.is_absolute() or ".." in path.parts or set("\\:") & set(str(path)):
        order.reject(
            "TIS603",
            f'"{path}" is outside the folder of the scene',
            hint="put the file beside the scene",
            word=word,
        )
    library, scene = order.scope.library, name.span.source.path
    kept = None if library is None else library.kept_text(str(path))
    if kept is not None:
        return kept
    if scene is None:
        order.reject(
            "TIS604",
            f'"{path}": a scene that is not saved in a file cannot read tables',
            hint="save the scene to a file",
            word=word,
        )
    place = scene.parent / path
    if (library or Library.of(name.span.source)).leads_out(place):
        order.reject("TIS603", LINK.format(path), hint=LINKED, word=word)
    try:
        return read_source(place, str(path)).text
    except CompileError as error:
        hint = "the path is relative to the scene"
        order.reject("TIS604", error.diagnostics[0].message, hint=hint, word=word)


def _numbers(line: str, columns: int) -> list[float] | None:
    """Return the first cells of a line as numbers; None if one of them is none."""
    cells = line.replace(";", ",").replace("\t", ",").split(",")
    try:
        return [float(cell) for cell in cells[:columns]]
    except ValueError:
        return None
