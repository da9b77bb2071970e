"""The events of the run."""

from collections.abc import Sequence

from tissuec.core.errors import counted
from tissuec.results.export import ELEMENT, event_facts
from tissuec.results.recording import Event
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, Section, element, folded, html, row, table

MOST = 2000  # rows; more make a page that no browser likes
SHOWN = 8  # springs that are named without being asked for
NAMED = 400  # springs of one event that are named at all


def section(content: ReportContent) -> Section:
    """Return the table of events."""
    events = content.events
    if not events:
        return Section("events", "Events", element("p", "There were no events."))
    rows = [_row(content, event) for event in events[:MOST]]
    heads = ("at", "event", "cause", "springs", "line")
    body = table("Events in order of time", heads, rows)
    return Section("events", "Events", html((body, _rest(content, len(events)))))


def _rest(content: ReportContent, count: int) -> Html | None:
    if count <= MOST:
        return None
    command = f'tissuec export "{content.trajectory.path.name}" events'
    return element(
        "p", f"{counted(count - MOST, 'more event')} follow: ", element("code", command)
    )


def _row(content: ReportContent, event: Event) -> Html:
    kind, springs, cause, place = event_facts(content.trajectory, event)
    time = content.trajectory.clock.text(event.time, digits=6)
    return row(
        time, element("b", kind), cause, _springs(springs.split()),
        content.texts.link(place),
    )  # fmt: skip


def _springs(names: Sequence[str]) -> Content:
    if len(names) <= SHOWN:
        return " ".join(names)
    rest = f" … and {len(names) - NAMED} more" if len(names) > NAMED else ""
    what = "element" if names[0].rpartition(":")[2].startswith(ELEMENT) else "spring"
    return folded(counted(len(names), what), element("p", " ".join(names[:NAMED]), rest))
