"""``cut``: springs that are removed."""

from dataclasses import dataclass
from typing import ClassVar, Self

from tissuec.core import units
from tissuec.core.errors import alternatives
from tissuec.core.source import Span
from tissuec.network import Indices
from tissuec.situation import Situation
from tissuec.verbs import VERBS, Agenda, Group, Happening, Order
from tissuec.verbs.blade import Blade, plane, strip, stroke
from tissuec.verbs.holding import sentence


@VERBS.member("cut")
@dataclass(frozen=True, slots=True)
class Cut:
    """Removes for good the intact springs of a body or set that a blade goes through now.

    ``along plane`` is a whole plane; ``along stroke`` is the parallelogram that an edge sweeps
    from its place between two points by a vector; ``along line`` is the part of the plane
    facing a direction that lies between the ends of a line, endless at right angles to it.
    A node on the blade counts as in front of it. Without ``along`` all springs of a set of
    springs are cut. The tool after ``with`` must be scissors and is entered in the event log.
    A cut that goes through nothing is noted and changes nothing.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "cut SET",
        "cut BODY along plane through POINT facing VECTOR",
        "cut BODY along stroke from POINT to POINT by VECTOR",
        "cut BODY along line from POINT to POINT facing VECTOR",
        "cut BODY along plane through POINT facing VECTOR with TOOL",
    )
    group: Group
    blade: Blade | None
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        group = order.springs()
        order.tool("with", kind="scissors")
        blade = _read_blade(order) if order.has("along") else None
        if blade is None and not order.names_springs():
            order.reject(
                "TIS304",
                '"cut" needs "along", unless it names a set of springs',
                hint="for example: along plane through (10, 0, 0) mm facing (1, 0, 0)",
            )
        return cls(group, blade, order.span)

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        text, springs = sentence(self.span), self._found(situation)
        if not len(springs):
            return (Happening("note", (), f"{text}: there is nothing to cut", self.span),)
        situation.alive = situation.alive.copy()
        situation.alive[springs] = False
        return (Happening("cut", tuple(springs.tolist()), text, self.span),)

    def _found(self, situation: Situation) -> Indices:
        springs = self.group.indices[situation.alive[self.group.indices]]
        if self.blade is None:
            return springs
        first, second = situation.position[situation.network.ends[springs]].swapaxes(0, 1)
        return springs[self.blade.crosses(first, second, situation.network.extent)]


def _read_blade(order: Order) -> Blade:
    shape = order.text("along").lower()
    if shape not in _BLADES:
        hint = alternatives(shape, _BLADES, what="a cut goes along a")
        order.reject("TIS305", f'"{shape}" is nothing to cut along', hint=hint, word="along")
    return _BLADES[shape](order)


def _read_plane(order: Order) -> Blade:
    return plane(order.vector("through", units.LENGTH), order.direction("facing"))


def _read_stroke(order: Order) -> Blade:
    ends = (order.vector(word, units.LENGTH) for word in ("from", "to", "by"))
    blade = stroke(*ends)
    if blade is None:
        order.reject(
            "TIS306",
            "this stroke sweeps no area",
            hint="the two points must differ, and the blade must move across its edge",
            word="by",
        )
    return blade


def _read_strip(order: Order) -> Blade:
    start, stop = (order.vector(word, units.LENGTH) for word in ("from", "to"))
    blade = strip(start, stop, order.direction("facing"))
    if blade is None:
        order.reject(
            "TIS306",
            "this line does not lie in the plane that it is said to face",
            hint="the points must differ, and the direction be at right angles to the line",
            word="facing",
        )
    return blade


_BLADES = {"plane": _read_plane, "stroke": _read_stroke, "line": _read_strip}
