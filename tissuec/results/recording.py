"""The contents of a recording: what the output block asks for, the rows it needs, and names."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core import arguments
from tissuec.core.errors import counted
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.report import FailedExpectation
from tissuec.core.units import TIME, show
from tissuec.model.network import Floats, Indices, Network, numbers_in
from tissuec.results.fields import FieldChannel, always_recorded
from tissuec.results.volume_cells import VolumeCells

AXES = ("x", "y", "z")  # columns of vectors
TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz")  # of stress; the first three are along axes
ENERGIES = ("kinetic", "elastic", "gravity", "work", "dissipated", "switched")
MOST_JUMPING = 1024
"""Numbers in a row of a log, above which jumps are not kept: many events would fill a disk."""


class LogChannel(Struct, frozen=True):
    """A quantity that is logged over time, one row of numbers per moment.

    Attributes:
        name: What the scene calls it, such as "force of forceps A".
        columns: What the numbers of a row are: axes, or ids of springs or nodes.
        unit: Unit of every number, such as "N".
        description: One sentence for readers of the file.
    """

    name: str
    columns: tuple[str | int, ...]
    unit: str
    description: str

    @property
    def has_jumps(self) -> bool:
        """Return whether both sides of events are written."""
        return len(self.columns) <= MOST_JUMPING


class SurfaceChannel(Struct, frozen=True):
    """A smooth surface that is written over time.

    Attributes:
        body: Name of the body; so is the surface called.
        kind: How it is drawn, such as "loop subdivision".
        entries: What the scene says about it, or leaves to the kind: subdivisions, …
    """

    body: str
    kind: str
    entries: Mapping[str, Any]


class Recording(Struct, frozen=True, eq=False):
    """The contents of a result file.

    Attributes:
        nodes: Nodes whose frames are written, ascending network numbers; none: no trajectory.
        lines: Springs and edges of elements that are written, ascending; both ends of each are
            among ``nodes``.
        single: Whether frames hold four-byte numbers instead of eight-byte ones.
        logs: Logged quantities.
        energies: Whether the table of energies is written.
        surfaces: Smooth surfaces of bodies.
        compress: Whether frames and surfaces are compressed.
        fields: What frames contain besides positions and velocities.
        cells: The cells of preserved volumes; None where no field is about them.
    """

    nodes: Indices
    lines: Indices
    single: bool
    logs: tuple[LogChannel, ...]
    energies: bool
    surfaces: tuple[SurfaceChannel, ...] = ()
    compress: bool = False
    fields: tuple[FieldChannel, ...] = field(default_factory=always_recorded)
    cells: VolumeCells | None = None


class NamedGroup(Struct, frozen=True, eq=False):
    """Nodes or springs that have a name: a set of the scene, or a region of a body.

    Attributes:
        name: What the scene calls it.
        what: "nodes" or "springs".
        indices: Network numbers, ascending, shape (member,).
        body: Of a region, the body that it is a part of; "" for a set.
    """

    name: str
    what: str
    indices: Indices
    body: str = ""


class Event(Struct, frozen=True):
    """An event at a moment: a cut, a rupture, a grasp, a release, a trigger.

    Attributes:
        time: When [s].
        kind: One word, such as "rupture".
        springs: Network numbers of the springs concerned.
        cause: Why, in words.
        place: ``file:line`` of the sentence that ordered it.
    """

    time: float
    kind: str
    springs: tuple[int, ...]
    cause: str
    place: str


class WithoutEffect(Struct, frozen=True):
    """An order of the scene that changed nothing, or did not reach what it asks for.

    Attributes:
        kind: One word that is the same in all runs, such as "contact" or "push".
        what: A clause, such as "ball touched nothing".
        remedy: How to change that; empty where that is obvious.
        place: ``file:line`` of the order.
    """

    kind: str
    what: str
    remedy: str
    place: str

    def __str__(self) -> str:
        way_out = f": {self.remedy}" if self.remedy else ""
        return f"{self.what}{way_out} ({self.place})"


class EventSide(NamedTuple):
    """The whole net just before or just after an event.

    Attributes:
        time: Of the event [s].
        position: [m], shape (node, 3).
        velocity: [m/s], shape (node, 3).
        fields: Numbers of the fields by name, as their members sample them.
        alive: Which entities exist, shape (entity,).
    """

    time: float
    position: Floats
    velocity: Floats
    fields: Mapping[str, Floats]
    alive: NDArray[np.bool_]


class ExpectationResult(Struct, frozen=True):
    """Result of an expectation.

    Attributes:
        expect: The clause as it is written.
        place: ``file:line``.
        state: "holds", "fails" or "not reached".
        time: Of a failure the first time at which it failed, otherwise when it was judged last
            [s]; None if it never was.
        measured: What was measured then, such as "gap(oviduct) = 0.2 mm".
        undecided: By how much it holds or fails, where that is less than the error; otherwise
            empty.
    """

    expect: str
    place: str
    state: str
    time: float | None
    measured: str
    undecided: str = ""

    @property
    def failure(self) -> FailedExpectation:
        """Return it with the measured value, and when that was; or that none was."""
        if self.state == "not reached":
            why = "the run ended before this could be checked"
            return FailedExpectation(f"{self.place}: {self.expect}", why)
        when = "" if self.time is None else f"at {show(self.time, TIME)}: "
        return FailedExpectation(f"{self.place}: {self.expect}", f"{when}{self.measured}")


def concerned(springs: Sequence[int], network: Network) -> tuple[int, str]:
    """Return how many elements, edges of elements or springs an event concerned, and which.

    Args:
        springs: Of the event. Where there are elements among them, all others are edges of
            these.
    """
    elements = sum(spring >= network.line_count for spring in springs)
    if elements:
        return elements, "element"
    of_elements = bool(springs) and min(springs) >= network.spring_count
    return len(springs), "element edge" if of_elements else "spring"


def springs_of_events(
    events: Iterable[tuple[str, Sequence[int]]], network: Network
) -> list[str]:
    """Return how many springs or elements events concerned: ``rupture: 3 springs``.

    Args:
        events: Kinds with the springs.
    """
    counts: Counter[tuple[str, str]] = Counter()
    for kind, springs in events:
        count, what = concerned(springs, network)
        counts[kind, what] += count
    return [
        f"{kind}: {counted(count, what)}" for (kind, what), count in counts.items() if count
    ]


def body_of(network: Network, node: int) -> str:
    """Return the name of the body that holds network node ``node``; "" if none does."""
    return network.body_at(node).name if node < network.body_nodes else ""


NODES, SPRINGS = "nodes", "springs"


def members(network: Network, groups: Sequence[NamedGroup], name: str, what: str) -> Indices:
    """Return the network numbers of the nodes or springs with a name, ascending, shape (n,).

    Args:
        groups: Its sets and regions.
        name: Of a set, body or joint, or of a region with its body, such as "scar of liver".
        what: "nodes" or "springs"; springs of a set of nodes are those with both ends in it.

    Raises:
        TypeError: The name is no text.
        ValueError: There is no such name.
    """
    key, of_springs = key_of(arguments.text(name, "a name")), what == SPRINGS
    parts = network.parts if of_springs else network.bodies
    for part in parts:
        if key_of(part.name) == key:
            place = part.lines if of_springs else getattr(part, NODES)
            found = numbers_in(place)
            return found
    known = {full_name(group): group for group in groups if group.what in (NODES, what)}
    for full, group in known.items():
        if key_of(full) == key:
            return group.indices if group.what == what else _within(network, group.indices)
    hint = alternatives(name, [*known, *(part.name for part in parts)], what="there are")
    raise ValueError(f'there are no {what} called "{name}"; {hint}')


def full_name(group: NamedGroup) -> str:
    """Return the name of a set, or that of a region with that of its body."""
    return f"{group.name} of {group.body}" if group.body else group.name


def _within(network: Network, nodes: Indices) -> Indices:
    ends = network.line_ends
    return np.flatnonzero(np.isin(ends, nodes).all(axis=1))
