"""``preserve`` and ``inflate``: volumes that are kept, or changed, by pressure."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core import units
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.core.units import VOLUME, show
from tissuec.forces.volume import Enclosure
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import (
    VERBS,
    ActionFailed,
    EventQueue,
    Flaw,
    Group,
    LoggedEvent,
    Order,
)
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

EXAMPLE = "with 10 kPa"
#: Bulk moduli in words [Pa].
FIRMNESS = {"gentle pressure": 1e3, "firm pressure": 1e4, "hard pressure": 1e5}


@VERBS.member("preserve")
class Preserve(Struct, frozen=True):
    """Preserves the volume inside the closed surface of a body by pressure.

    In a lattice, each cubic cell preserves its volume by a pressure of its own. In bodies of
    tetrahedra or with a filling, the cell around each node does, if Poisson's ratio is above
    1/4.

    The pressure is a bulk modulus multiplied by the missing fraction of the drawn volume. The
    modulus is written as a pressure, or in words: gentle (1 kPa), firm (10 kPa) or hard
    pressure (100 kPa). The enclosed fluid has no mass and no weight. A surface with a torn edge
    leaks. It then has no pressure; its energy is counted as *switched*. In a lattice, only
    cells that lose a spring leak. The event log says when a body leaks, and what tore it.

    Another ``preserve`` of the same body replaces the first: the target is the drawn volume
    again, also after ``inflate``.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "preserve volume of BODY with PRESSURE",
        "preserve volume of BODY with gentle pressure",
    )
    group: Group
    modulus: float  # [Pa]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        _expect_volume(order)
        return cls(order.nodes_of("of"), _modulus(order), order.span)

    def made(self, network: Network) -> Enclosure:
        """Return the enclosed volumes of the body; raises ValueError without any."""
        return Enclosure.of(network, self.group.name, self.modulus, self.span)

    def flaw(self, network: Network) -> str:
        """Return why a body cannot keep its volume, empty if it can."""
        why = _flaw(network, self.group.name, self.span)
        return why and Flaw(why, self._instead(network))

    def _instead(self, network: Network) -> str:
        """Return which other bodies can keep their volume, or what could."""
        own = next(body for body in network.bodies if body.name == self.group.name)
        if own.is_made_of_elements and not own.is_wall:
            return "remove it; a larger Poisson's ratio keeps the volume more nearly"
        bodies = (body.name for body in network.bodies if body.name != self.group.name)
        others = [name for name in bodies if not _flaw(network, name, self.span)]
        if others:
            return f"bodies whose volume can be preserved: {', '.join(others)}"
        return (
            "a volume can be preserved inside a closed surface, such as a sphere, or in a "
            "solid, such as a lattice"
        )

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        made = self.made(state.network)
        old = state.enclosure(self.group.name)
        state.put(made.block)
        text = sentence(self.span)
        happened = LoggedEvent("preserve", (), text, self.span)
        if old is None:
            return (happened,)
        replaced = LoggedEvent("note", (), _replacing(old, made, state.time), self.span)
        return happened, replaced


@VERBS.member("inflate")
class Inflate(Struct, frozen=True):
    """Sets the volume that a body preserves, gradually within the interval or at once.

    This is the target volume. The actual volume and the pressure follow from the stiffness of
    the wall. The body must preserve its volume. For a lattice, it is the volume of all intact
    cells together. Another ``inflate`` of the same body replaces one that is under way: the
    target changes from its value at that time.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "inflate BODY to VOLUME",
        "inflate BODY to VOLUME using PROFILE",
    )
    group: Group
    volume: float  # [m³]
    profile: TimeProfile
    duration: float | None  # [s]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        volume = order.positive("to", units.VOLUME, what="volume", example="to 5 ml")
        default = "constant" if order.duration is None else "ramp"
        profile = order.profiles(default=default)[0]
        return cls(order.nodes(), volume, profile, order.duration, order.span)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Change the volume that is preserved.

        Raises:
            ActionFailed: The volume is not preserved, or it leaks.
        """
        enclosure = state.enclosure(self.group.name)
        drawn = 0.0 if enclosure is None else float(enclosure.intact(state.alive).drawn.sum())
        if enclosure is None or not drawn:
            raise self._failed(state)
        (profile,), _ = schedule(queue, (self.profile,), state.time, self.duration)
        swollen = enclosure.swollen(self.volume / drawn - 1.0, profile, state.time)
        state.put(swollen.block)
        return (LoggedEvent("inflate", (), sentence(self.span), self.span),)

    def _failed(self, state: State) -> ActionFailed:
        """Return that nothing here keeps a volume, and which springs it has lost."""
        name = self.group.name
        message = f"{name} cannot be inflated: nothing preserves its volume yet"
        whole = Enclosure.of(state.network, name, 1.0, self.span)
        torn = whole.lost_walls(state.alive)
        if len(whole.lost_items(state.alive)) < whole.item_count:
            return ActionFailed(message, None, self.span)
        what = "its surface is" if whole.item_count == 1 else "all its cells are"
        message = f"{name} cannot be inflated: {what} torn"
        return ActionFailed(message, None, self.span, torn.tolist())


def _replacing(old: Enclosure, new: Enclosure, time: float) -> str:
    """Describe how a further ``preserve`` changes the target at a time [s]."""
    text = f"replaced: {sentence(old.span)}"
    swell = old.swell(time)[0]
    if not old.swellings:
        return text
    target, drawn = (
        show(float(v), VOLUME) for v in ((old.drawn * (1.0 + swell)).sum(), new.drawn.sum())
    )
    return f"{text}; the target is the drawn volume of {drawn} again, no longer {target}"


def _flaw(network: Network, body: str, span: Span) -> str:
    """Return why a body cannot keep its volume, empty if it can."""
    try:
        Enclosure.of(network, body, 1.0, span)
    except ValueError as error:
        return str(error)
    return ""


def _expect_volume(order: Order) -> None:
    has_body = order.has("of")
    if order.words.lower() == "volume" and has_body:
        return
    hint = Hint(f"for example: preserve volume of BODY {EXAMPLE}")
    if order.words and order.words.lower() != "volume":
        # "preserve bag with …", or "preserve pressure of bag with …"
        text = "volume" if has_body else f"volume of {order.words}"
        start = order.span.start + order.span.text.index(order.words, len("preserve"))
        place = Span(order.span.source, start, start + len(order.words))
        whole = f"{text} of …" if has_body else text
        hint = Hint(f"write preserve {whole}", Edit(text, place))
    order.reject("TIS312", "only the volume of a body can be preserved", hint=hint)


def _modulus(order: Order) -> float:
    if not order.has("with"):
        hint = f"for example: {EXAMPLE}, or with {next(iter(FIRMNESS))}"
        order.reject("TIS304", "the pressure is missing", hint=hint)
    if (word := order.word("with", FIRMNESS)) is not None:
        return FIRMNESS[word]
    return order.positive(
        "with", units.PRESSURE, what="pressure", example=EXAMPLE, words=[*FIRMNESS]
    )
