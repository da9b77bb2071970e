"""Time profiles as written: ``using smooth profile``, ``using table "file.csv"``."""

from collections.abc import Iterator, Sequence

import numpy as np

from tissuec.compiler.script.profile_tables import TABLE, read_table_profiles
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.units import FREQUENCY, TIME, show
from tissuec.lang import syntax as s
from tissuec.model.profiles import ProfileKind, TimeProfile
from tissuec.scene.reading.clauses import ClauseReader
from tissuec.script.verbs import Action

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
        return read_table_profiles(clause, columns, stop, order)
    return (TimeProfile(kind, 0.0, stop),) * columns


#: Tables that last so many times as long as they are used, or this part of it at most, have
#: probably another unit.
LONG, SHORT = 10.0, 1.001e-3


def profiles_of(action: Action) -> Iterator[TimeProfile]:
    """Yield the profiles of an action."""
    for name in ("profile", "profiles"):
        found = getattr(action, name, ())
        yield from (found,) if isinstance(found, TimeProfile) else found or ()


def table_times(columns: Sequence[TimeProfile], room: float) -> tuple[str, str] | None:
    """Return the fault of the times of a table, and a remedy; None if there is no fault.

    Args:
        columns: Of the table, all with the same times.
        room: How long the table is used [s].
    """
    last, first = float(columns[0].times[-1]), float(columns[0].times[1])
    counted = "times count from the beginning of the action"
    if first >= room and all(one.values[0] == one.values[1] for one in columns):
        return f"begins at {show(first, TIME)}", counted
    if last > LONG * room:
        if SHORT * last <= 1.01 * room:
            counted = f"if its times are in ms, name its first column t_ms; {counted}"
        return f"lasts until {show(last, TIME)}", counted
    if last < SHORT * room:
        return f"ends at {show(last, TIME)}", f"check the unit of its first column; {counted}"
    return None


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
