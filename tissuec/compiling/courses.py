"""Courses in time as they are written: ``using smooth profile``, ``using table "file.csv"``."""

from pathlib import PurePosixPath
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.errors import CompileError, alternatives
from tissuec.core.units import FREQUENCY, LENGTH, UnitError, parse_unit
from tissuec.courses import Course, CourseKind, monotone_slopes
from tissuec.lang import syntax as s
from tissuec.network import Floats
from tissuec.scene.imports import read_source

if TYPE_CHECKING:
    from tissuec.compiling.orders import SentenceOrder

#: Written name -> kind of course. Motions and forces are spelled in their own words.
PROFILES: dict[str, CourseKind] = {
    "constant": "constant",
    "constant speed": "ramp",
    "ramp": "ramp",
    "smooth profile": "smooth",
    "sine": "sine",
    "table": "table",
}
_NEED_AN_END = ("ramp", "smooth")


def read_courses(
    clause: s.Clause | None, default: str, columns: int, order: "SentenceOrder"
) -> tuple[Course, ...]:
    """Return the courses that a clause names, beginning at 0 s; one per column of a table."""
    written = "the default" if clause is None else clause.value.span.text
    name = default if clause is None else _profile_name(clause, order)
    if name not in PROFILES:
        problem = (
            f'there is no profile "{written}"'
            if name
            else "the profile of the motion is not written"
        )
        order.reject(
            "TIS305" if name else "TIS304",
            problem,
            hint=alternatives(name, PROFILES, what="profiles, behind using"),
            word=clause.word if clause else None,
        )
    kind = PROFILES[name]
    stop = np.inf if order.duration is None else order.duration
    if kind in _NEED_AN_END and order.duration is None:
        order.reject(
            "TIS304",
            f"{name} needs an interval",
            hint="write from … to …: instead of at …:",
            word=clause.word if clause else None,
        )
    if kind == "sine":
        frequency = order.number("of", FREQUENCY)
        return (Course("sine", 0.0, stop, frequency),) * columns
    if kind == "table":
        assert clause is not None
        return _table_courses(clause, columns, stop, order)
    return (Course(kind, 0.0, stop),) * columns


def _profile_name(clause: s.Clause, order: "SentenceOrder") -> str:
    if not isinstance(clause.value, s.Name):
        order.reject("TIS312", "a profile is a name", word=clause.word)
    if clause.value.quoted is not None:
        return clause.value.words.lower()
    return clause.value.key


def _table_courses(
    clause: s.Clause, columns: int, stop: float, order: "SentenceOrder"
) -> tuple[Course, ...]:
    assert isinstance(clause.value, s.Name)
    factor = 1.0
    if columns > 1:
        factor = _length_unit(order)
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
        message = f"the numbers in {clause.value.quoted} change too steeply"
        order.reject("TIS313", message, hint="check the times and the units", word=clause.word)
    return tuple(
        Course("table", 0.0, end, 0.0, times, column, slope)
        for column, slope in zip(values.T.copy(), slopes, strict=True)
    )


def _length_unit(order: "SentenceOrder") -> float:
    """Return the metres in the unit of ``in mm``."""
    text = (
        order.text("in")
        if order.has("in")
        else order.reject(
            "TIS304",
            "the unit of the path is not written",
            hint='for example: along table "path.csv" in mm',
        )
    )
    try:
        unit = parse_unit(text)
    except UnitError as error:
        order.reject("TIS104", str(error), word="in")
    if unit.dimension != LENGTH:
        order.reject("TIS502", f"a path is in lengths; {text} is none", word="in")
    return unit.factor


def _read_csv(clause: s.Clause, name: s.Name, columns: int, order: "SentenceOrder") -> Floats:
    """Return the numbers of a file beside the scene, shape (row, column), at least two rows."""
    path = PurePosixPath(name.quoted or "")
    if path.is_absolute() or ".." in path.parts or set("\\:") & set(str(path)):
        order.reject(
            "TIS603",
            f'"{path}" leads outside of the folder of the scene',
            hint="put the file beside the scene",
            word=clause.word,
        )
    folder = name.span.source.path.parent if name.span.source.path else None
    if folder is None:
        order.reject(
            "TIS604",
            f'"{path}": a scene that is no file has no tables beside it',
            hint="save the scene to a file",
            word=clause.word,
        )
    try:
        text = read_source(folder / path, str(path)).text
    except CompileError as error:
        hint = "the file is looked for beside the scene"
        order.reject("TIS604", error.diagnostics[0].message, hint=hint, word=clause.word)
    rows: list[list[float]] = []
    may_be_names = True  # the first line that is no comment may name the columns
    form = "a row is a time in s and " + ("one number" if columns == 2 else "x, y and z")
    for number, line in enumerate(text.split("\n"), start=1):
        cells = line.replace(";", ",").replace("\t", ",").split(",")
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            row = [float(cell) for cell in cells[:columns]]
        except ValueError:
            if may_be_names:
                may_be_names = False
                continue
            row = []
        if len(row) < columns or not np.all(np.isfinite(row)):
            order.reject(
                "TIS313",
                f"line {number} of {path} is no row of {columns} numbers",
                hint=form,
                word=clause.word,
            )
        may_be_names = False
        rows.append(row)
    if len(rows) < 2:
        message = f"{path} holds fewer than two rows of numbers"
        order.reject("TIS313", message, hint=form, word=clause.word)
    return np.array(rows)
