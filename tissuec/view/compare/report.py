"""A comparison as parts of a report, and as plain data."""

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from typing import Any, cast

from tissuec.core.data import as_data
from tissuec.core.errors import counted
from tissuec.core.report import FactSection, FactTable, Part
from tissuec.core.units import (
    DIMENSION_NAMES,
    LENGTH,
    TIME,
    Dimension,
    show,
    show_interval,
    show_si,
)
from tissuec.view.compare.comparison import Comparison, Leftover, StatedDifference
from tissuec.view.compare.matching import SideParts
from tissuec.view.compare.motion import MotionDifference
from tissuec.view.compare.over_time import (
    BREAKING,
    Curves,
    EventComparison,
    EventEntry,
    LogDifference,
    MatchedEvent,
)
from tissuec.view.compare.parameters import FORCE, QuantityDifference, SourcePlace, shortened
from tissuec.view.compare.sides import Side, TextDifference

MOST_LINES = 60  # of a difference of texts
MOST_TOLD = 10  # events of one kind
MOST_NAMED = 4  # springs
WIDEST = 96  # of a line of facts


def parts_of(found: Comparison) -> list[Part]:
    """Return the differences, in one section for each kind."""
    parts: list[Part] = [
        f"{which}: {_headline(side)}" for which, side in (("a", found.a), ("b", found.b))
    ]
    if found.is_same:
        return [*parts, f"no differences ({_looked_at(found)})"]
    sections: dict[str, Iterable[Part]] = {
        "text": _texts((*found.texts, *found.files)),
        "settings": _facts(found.settings),
        "nodes and springs": _leftovers(found.leftovers),
        "parameters": (*_forces_alone(found.leftovers), *_changes(found.changes)),
        _events_title(found): _logged_events(found),
        "logs": _curves(found.curves),
        "motion": _motion(found),
        "provenance": _facts(found.provenance),
    }
    same: list[str] = []
    for title, said in sections.items():
        if not title:
            continue
        if differences := [*said]:
            parts.append(FactSection(title, differences))
        elif _was_compared(found, title):
            same.append(title)
    return [*parts, "", f"identical: {', '.join(same)}"] if same else parts


def _headline(side: Side) -> str:
    if side.trajectory is None:
        return f"{side.name} (a scene)"
    return f"{side.name} ({side.scene}; {side.trajectory.outcome})"


def _looked_at(found: Comparison) -> str:
    parts = ["text", str(found.a.network.size)]
    if isinstance(found.motion, MotionDifference):
        parts.append(counted(len(found.motion.times), "frame"))
    elif found.motion is not None:
        parts.append(found.motion)
    return ", ".join(parts)


def _was_compared(found: Comparison, title: str) -> bool:
    if title in ("logs", "motion", "provenance"):
        return found.curves is not None
    return title != "parameters" or bool(len(found.nodes) or len(found.springs))


# --- text and settings ------------------------------------------------------------------------


def _texts(differences: Sequence[TextDifference]) -> Iterator[str]:
    for one in differences:
        if one.kind != "changed":
            yield f'{one.kind}: "{one.name}"'
        elif not one.lines:
            yield f'"{one.name}" has different contents'
        else:
            yield from one.lines[:MOST_LINES]
            if len(one.lines) > MOST_LINES:
                yield f"… {len(one.lines) - MOST_LINES} more lines; use --json for all"


def _facts(facts: Sequence[StatedDifference]) -> Iterator[str]:
    for fact in facts:
        line = f"{fact.name}: {_value(fact.a)} -> {_value(fact.b)}"
        if len(line) <= WIDEST or not _is_list(fact.a):
            yield line
            continue
        sides: list[tuple[str, Any, Any]] = [("a", fact.a, fact.b), ("b", fact.b, fact.a)]
        for which, one, other in sides:
            yield from (f"{fact.name} in {which}: {text}" for text in one if text not in other)


def _is_list(value: object) -> bool:
    return isinstance(value, list)


def _value(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, list | tuple):
        items = cast("Iterable[object]", value)
        return ", ".join(map(str, items)) or "none"
    return f"{value:g}" if isinstance(value, float) else str(value)


# --- nodes, springs and their numbers ---------------------------------------------------------


def _leftovers(leftovers: Sequence[Leftover]) -> Iterator[str]:
    for one in leftovers:
        if one.what == FORCE:
            continue
        if one.count == one.total:
            every = f"all {one.count} {one.what}s" if one.count > 1 else f"the one {one.what}"
            yield f"only in {one.side}: {every} of {one.part}"
            continue
        ids = ", ".join(map(str, one.ids))
        more = ", …" if one.count > len(one.ids) else ""
        plural = "" if one.total == 1 else "s"
        yield (
            f"only in {one.side}: {one.count} of {one.total} {one.what}{plural} of {one.part} "
            f"({ids}{more})"
        )


def _forces_alone(leftovers: Sequence[Leftover]) -> Iterator[str]:
    for one in leftovers:
        if one.what == FORCE:
            yield f"only in {one.side}: the force {one.part}"


def _changes(changes: Sequence[QuantityDifference]) -> Iterator[str]:
    for change in changes:
        of = "all" if change.count == change.total else f"{change.count} of"
        things = f"{of} {counted(change.total, change.what)}, "
        head = f"{change.quantity} of {change.part}: {things}"
        if change.what == FORCE:
            head = f"{change.quantity} of the force {change.part}: "
        yield f"{head}{_sizes(change)}"
        for which, given in (("a", change.from_a), ("b", change.from_b)):
            if change.from_a != change.from_b or which == "a":
                side = which if change.from_a != change.from_b else "both"
                yield from (f"  {side}: {_origin(one)}" for one in given)


def _sizes(change: QuantityDifference) -> str:
    """Return the values before and after: of all alike, or where they differ most."""
    if change.dimension is None:
        return f"{change.a} -> {change.b}"
    alike = all(r and r[0] == r[1] for r in (change.range_a, change.range_b))
    most = f"{_percent(change.relative)} at most" if not alike else _percent(change.relative)
    place = "" if alike else f" ({change.what} {change.worst})"
    here, there = (_number(value, change.dimension) for value in (change.a, change.b))
    of = " of the drawn size" if change.quantity == "drawn position" else ""
    return f"{here} -> {there}{place}, {most}{of}"


def _number(value: float | str | tuple[float, ...], dimension: Dimension) -> str:
    if isinstance(value, tuple):
        parts = ", ".join(f"{one:.6g}" for one in value)
        return f"({parts}) {DIMENSION_NAMES[dimension][1]}".rstrip()
    if isinstance(value, str):
        return value
    return show(value, dimension, digits=4) if isfinite(value) else "none"


def _percent(part: float) -> str:
    return f"{100.0 * part:.3g} %"


def _origin(given: SourcePlace) -> str:
    return f"{given.place}, {given.how}" + (f": {given.text}" if given.text else "")


# --- events -----------------------------------------------------------------------------------


def _events_title(found: Comparison) -> str:
    if found.logged_events is None:
        return ""
    return "script" if found.a.trajectory is None else "events"


def _logged_events(found: Comparison) -> Iterator[str]:
    if found.logged_events is None or found.logged_events.is_same:
        return
    places = SideParts(found.a), SideParts(found.b)
    orders = [m for m in found.logged_events.both if m.a.kind not in BREAKING and not m.is_same]
    yield from _cut_short([_met(meeting) for meeting in orders])
    for which, entries in (
        ("a", found.logged_events.only_a),
        ("b", found.logged_events.only_b),
    ):
        told = [e for e in entries if e.kind not in BREAKING]
        yield from _cut_short(
            [f"only in {which}: {show(e.time, TIME)} {shortened(e.cause)}" for e in told]
        )
    for kind in BREAKING:
        yield from _broken(kind, found.logged_events, places)


def _cut_short(lines: Sequence[str]) -> Iterator[str]:
    yield from lines[:MOST_TOLD]
    if len(lines) > MOST_TOLD:
        yield f"and {len(lines) - MOST_TOLD} more"


def _met(meeting: MatchedEvent) -> str:
    a, b = meeting.a, meeting.b
    when = show(a.time, TIME)
    if a.time != b.time:
        when += f" -> {show(b.time, TIME)}"
        if when.split(" -> ")[0] == when.split(" -> ")[1]:
            when = f"{show(a.time, TIME)} ({meeting.shift:+.1e} s)"
    what = (
        shortened(a.cause)
        if a.cause == b.cause
        else f"{shortened(a.cause)} -> {shortened(b.cause)}"
    )
    if a.springs == b.springs:
        return f"{when}: {what}"
    common = len(set(a.springs) & set(b.springs))
    return (
        f"{when}: {what}; {len(a.springs)} -> {counted(len(b.springs), 'spring')}, "
        f"{common} of them the same"
    )


def _broken(
    kind: str, found: EventComparison, places: tuple[SideParts, SideParts]
) -> Iterator[str]:
    """Yield how many springs broke in both, and in one alone."""
    both = [meeting for meeting in found.both if meeting.a.kind == kind]
    only = [[e for e in entries if e.kind == kind] for entries in (found.only_a, found.only_b)]
    shifted = [meeting for meeting in both if meeting.shift]
    if not (shifted or only[0] or only[1]):
        return
    kinds = {places[0].broken(meeting.a.spring) for meeting in both}
    for place, entries in zip(places, only, strict=True):
        kinds |= {place.broken(entry.spring) for entry in entries}
    what = kinds.pop() if len(kinds) == 1 else "spring or element"
    yield (
        f"{kind}: {counted(len(both) + len(only[0]), what)} in a, "
        f"{len(both) + len(only[1])} in b, {len(both)} of them in both"
    )
    if shifted:
        worst = max(shifted, key=lambda meeting: abs(meeting.shift))
        yield (
            f"  times differ by up to {show(abs(worst.shift), TIME)}: "
            f"{places[0].broken(worst.a.spring)} "
            f"{places[0].spring(worst.a.spring)}, {show(worst.a.time, TIME, digits=6)} -> "
            f"{show(worst.b.time, TIME, digits=6)}"
        )
    for which, place, entries in zip("ab", places, only, strict=True):
        if entries:
            yield f"  only in {which}: {_springs(entries, place)}"


def _springs(entries: Sequence[EventEntry], places: SideParts) -> str:
    told = [f"{places.spring(e.spring)} at {show(e.time, TIME)}" for e in entries[:MOST_NAMED]]
    more = f", and {len(entries) - MOST_NAMED} more" if len(entries) > MOST_NAMED else ""
    what = places.broken(entries[0].spring)
    return f"{what}{'s' if len(entries) > 1 else ''} {', '.join(told)}{more}"


# --- logs and motion --------------------------------------------------------------------------


def _curves(curves: Curves | None) -> Iterator[Part]:
    if curves is None:
        return
    different = [curve for curve in curves.both if not curve.is_same]
    if different:
        yield from _table(different)
    for which, names in (("a", curves.only_a), ("b", curves.only_b)):
        if names:
            yield f"only in {which}: {', '.join(names)}"
    if curves.apart:
        yield f"without a common time or column: {', '.join(curves.apart)}"


def _table(curves: Sequence[LogDifference]) -> Iterator[Part]:
    rows: list[tuple[str, ...]] = []
    for curve in curves:
        where = show(curve.time, TIME) + (f", {curve.column}" if curve.column else "")
        size = show_si(curve.difference, curve.unit)
        rows.append((curve.name, size, _percent(curve.relative), where))
    yield FactTable(("log", "largest difference", "relative", "at"), rows)
    if any(curve.interpolated for curve in curves):
        yield "their times differ: logs were interpolated linearly"
    for curve in curves:
        if curve.missing:
            moments = counted(curve.missing, "time")
            yield f"{curve.name}: only one of them has a number at {moments}"


def _motion(found: Comparison) -> Iterator[str]:
    motion = found.motion
    if motion is None or (isinstance(motion, MotionDifference) and motion.is_same):
        return
    if isinstance(motion, str):
        yield f"not compared: {motion}"
        return
    yield _compared(motion)
    worst = motion.worst
    if motion.largest:
        yield (
            f"largest distance {show(motion.largest, LENGTH)} at "
            f"{show(float(motion.times[worst]), TIME)}, node "
            f"{SideParts(found.a).node(int(motion.node[worst]))}"
        )
        yield (
            f"at most {float(motion.relative.max()):.2g} of the largest displacement until then"
        )
    yield _promise(motion)
    if motion.interpolated:
        yield "times of frames differ: positions were interpolated by cubics, with an"
        yield f"uncertainty of up to {show(float(motion.open.max()), LENGTH)}"


def _compared(motion: MotionDifference) -> str:
    times = counted(len(motion.times), "time")
    interval = show_interval(float(motion.times[0]), float(motion.times[-1]))
    said = f"{counted(motion.nodes, 'node')} at {times}, {interval}"
    parts: list[str] = []
    if not motion.nodes == motion.nodes_a == motion.nodes_b:
        parts.append(f"a has {motion.nodes_a} nodes, b {motion.nodes_b}")
    if motion.span_a != motion.span_b:
        ends = (show(span[1], TIME) for span in (motion.span_a, motion.span_b))
        parts.append("a ends at {}, b at {}".format(*ends))
    return f"{said} ({'; '.join(parts)})" if parts else said


def _promise(motion: MotionDifference) -> str:
    """Return whether both can be right."""
    allowed = motion.allowed
    if allowed is None:
        which = "a" if motion.tolerance_a is None else "b"
        return f"{which} has no tolerance, because its step is fixed"
    promised = f"{motion.tolerance_a:g} and {motion.tolerance_b:g}"
    if motion.verdict == "agree":
        return f"they agree within both tolerances ({promised})"
    if motion.parting is None:
        return f"it is undecided whether they agree within both tolerances ({promised})"
    since = show(motion.parting, TIME)
    return f"after {since} they differ by more than both tolerances allow ({promised})"


def as_dict(found: Comparison) -> dict[str, Any]:
    """Return all numbers, in SI units."""
    return {
        "a": _side(found.a),
        "b": _side(found.b),
        "same": found.is_same,
        "texts": [as_data(one) for one in (*found.texts, *found.files)],
        "settings": [as_data(one) for one in found.settings],
        "common_nodes": len(found.nodes),
        "common_springs": len(found.springs),
        "leftovers": [as_data(one) for one in found.leftovers],
        "parameters": [_change(one) for one in found.changes],
        "events": _happened(found.logged_events),
        "provenance": [as_data(one) for one in found.provenance],
        "logs": None if found.curves is None else _curves_data(found.curves),
        "motion": _motion_data(found),
    }


def _side(side: Side) -> dict[str, Any]:
    run = side.trajectory
    kind = "scene" if run is None else "result"
    return {"file": side.name, "kind": kind, "scene": side.scene} | (
        {} if run is None else {"outcome": run.outcome, "finished": run.finished}
    )


def _change(change: QuantityDifference) -> dict[str, Any]:
    unit = None if change.dimension is None else DIMENSION_NAMES[change.dimension][1]
    return as_data(change) | {"dimension": unit}


def _happened(found: EventComparison | None) -> dict[str, Any] | None:
    if found is None:
        return None
    names = ("time", "kind", "cause")

    def plain(entry: EventEntry) -> dict[str, Any]:
        return {name: getattr(entry, name) for name in names}

    return {
        "same": found.is_same,
        "changed": [
            {"a": plain(m.a), "b": plain(m.b), "same_springs": m.a.springs == m.b.springs}
            for m in found.both
            if not m.is_same
        ],
        "only_a": [plain(entry) for entry in found.only_a],
        "only_b": [plain(entry) for entry in found.only_b],
    }


def _curves_data(curves: Curves) -> dict[str, Any]:
    both = [as_data(c) | {"relative": c.relative, "same": c.is_same} for c in curves.both]
    names = ("only_a", "only_b", "apart")
    return {"both": both, **{name: getattr(curves, name) for name in names}}


def _motion_data(found: Comparison) -> dict[str, Any] | None:
    motion = found.motion
    if motion is None or isinstance(motion, str):
        return None if motion is None else {"compared": False, "reason": motion}
    worst, names = motion.worst, ("tolerance_a", "tolerance_b", "nodes", "nodes_a", "nodes_b")
    return {
        "compared": True,
        "verdict": motion.verdict,
        "largest": motion.largest,
        "relative": float(motion.relative.max()),
        "time": float(motion.times[worst]),
        "node": SideParts(found.a).node(int(motion.node[worst])),
        "parting": motion.parting,
        "times": len(motion.times),
        "span_a": motion.span_a,
        "span_b": motion.span_b,
        "interpolated": motion.interpolated,
        "open": float(motion.open.max()),
        "whole": motion.is_whole,
        **{name: getattr(motion, name) for name in names},
    }
