"""Events as marks on a timeline."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from msgspec import Struct

from tissuec.core.errors import counted
from tissuec.results.recording import Event, concerned

if TYPE_CHECKING:
    from tissuec.model.network import Network

#: Shape of the mark -> kinds of events; kinds that are not listed get a ring.
SIGNS = {
    "cross": ("cut",),
    "bolt": ("rupture", "crush"),
    "square": ("fix", "hold", "grasp", "seize", "pinch", "close", "preserve"),
    "hollow": ("free", "release", "open", "leak"),
    "arrow": (
        "move",
        "turn",
        "push",
        "press",
        "stroke",
        "tighten",
        "inflate",
        "irrigate",
        "settle",
    ),
    "diamond": ("tie", "slip"),
    "bar": ("end", "end the run", "stop"),
    "dot": ("trigger", "note", "change"),
}
BREAKING = {"rupture": "ruptured", "crush": "crushed"}
_MOST = 200


class Mark(Struct, frozen=True):
    """A mark on the timeline.

    Attributes:
        time: [s].
        kind: One word, such as "cut".
        sign: Name of its shape.
        text: What happened, as a sentence.
    """

    time: float
    kind: str
    sign: str
    text: str


def marks(events: Iterable[Event], duration: float, network: "Network") -> list[Mark]:
    """Return marks in order; springs or elements that break nearly together are one of them.

    Args:
        events: In the order of time.
        duration: Of the run [s].
        network: The network.
    """
    found: list[tuple[Event, int, str]] = []
    for event in events:
        many, what = concerned(event.springs, network)
        last = found[-1][0] if found else None
        if (
            last is not None
            and (last.kind, found[-1][2]) == (event.kind, what)
            and event.kind in BREAKING
            and event.time - last.time < duration / _MOST
        ):
            found[-1] = last, found[-1][1] + many, what
        else:
            found.append((event, many, what))
    return [_mark(*one) for one in found]


def _mark(event: Event, many: int, what: str) -> Mark:
    sign = next((sign for sign, kinds in SIGNS.items() if event.kind in kinds), "ring")
    text = event.cause
    if event.kind in BREAKING:
        text = f"{counted(many, what)} {BREAKING[event.kind]}"
    elif event.kind == "cut":
        text = f"{text}: {counted(many, what)}"
    return Mark(event.time, event.kind, sign, text)
