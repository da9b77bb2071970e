"""``preserve`` and ``inflate``: volumes that are kept, or changed, by pressure."""

from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import DENSITY, PRESSURE, VOLUME, show
from tissuec.mechanics.state import State
from tissuec.model.network import Network, numbers_in
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    BODY,
    CHANGING,
    SET,
    Cases,
    Chosen,
    FlagPart,
    Lasting,
    NumberClause,
    Refusal,
    SubjectPart,
)
from tissuec.script.verbs import (
    VERBS,
    Action,
    ActionFailed,
    EventQueue,
    Flaw,
    Group,
    LoggedEvent,
    Order,
)
from tissuec.script.verbs.acting import put_as_drawn
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

if TYPE_CHECKING:
    from tissuec.forces.enclosed.kept_volumes import KeptVolumes

FILLED = "a fluid can fill a closed wall, a tube with caps, or a space inside of a solid"
#: Bulk moduli in words [Pa].
FIRMNESS = {"gentle pressure": 1e3, "firm pressure": 1e4, "hard pressure": 1e5}


class PreserveWords(VerbSentence, frozen=True):
    """A sentence with ``preserve``.

    Attributes:
        modulus: [Pa].
        density: [kg/m³].
    """

    what: Chosen
    group: Annotated[Group, SubjectPart("nodes", (BODY, SET), "of", alone=True, what="body")]
    modulus: Annotated[
        float,
        NumberClause(
            "with",
            PRESSURE,
            "positive",
            FIRMNESS,
            what="pressure",
            example="with 10 kPa",
        ),
    ]
    has_caps: Annotated[bool, FlagPart("with caps")]
    density: Annotated[
        float | None,
        NumberClause(
            "weighing", DENSITY, "positive", what="density", example="weighing 1 g/ml",
        ),
    ]  # fmt: skip

    def action(self, order: Order) -> Action:
        is_inside = self.what == "volume inside"
        density = self.density or 0.0
        return Preserve(self.group, self.modulus, self.span, is_inside, self.has_caps, density)


def _volume_meant(order: Order) -> Hint:
    """Return a hint with the volume that can be meant by other words after the verb."""
    if not order.words or order.words.lower() == "volume":
        return Hint("for example: preserve volume of BODY with 10 kPa")
    # "preserve bag with …", "preserve volume bag with …", "preserve pressure of bag with …"
    has_body, place, name = order.has("of"), "volume", order.words.removeprefix("volume ")
    if name.startswith("inside "):
        place, name = "volume inside", name.removeprefix("inside ")
    text = "volume" if has_body else f"{place} of {name}"
    start = order.span.start + order.span.text.index(order.words, len("preserve"))
    written = Span(order.span.source, start, start + len(order.words))
    whole = f"{text} of …" if has_body else text
    return Hint(f"write preserve {whole}", Edit(text, written))


@VERBS.member("preserve")
class Preserve(Struct, frozen=True):
    """Preserves the volume inside a body by pressure.

    This is the volume inside the closed surface of a body. In a lattice, each cubic cell
    preserves its volume by a pressure of its own.

    The pressure is a bulk modulus multiplied by the missing fraction of the drawn volume. The
    modulus is written as a pressure, or in words: gentle (1 kPa), firm (10 kPa) or hard
    pressure (100 kPa). A surface with a torn edge leaks. It then has no pressure; its energy is
    counted as *switched*. In a lattice, only cells that lose a spring leak. The event log says
    when a body leaks, and what tore it.

    With ``inside of``, each space within the body is a cavity with a pressure of its own. Such
    a space may lie in a solid of elements, such as the lumen of a thick tube. It leaks when a
    cut or a tear leads through the solid; one that does not is filled. Caps close the
    open ends of a tube. A set is a cavity if its triangles enclose one, so that chambers of one
    body can be filled one by one.

    The enclosed fluid has neither mass nor weight, unless a density follows ``weighing``.
    Then it weighs this density times the volume that is preserved, and rests on the wall with
    a pressure that grows downwards. It has no inertia.

    Another ``preserve`` of the same body replaces the first: the target is the drawn volume
    again, also after ``inflate``.
    """

    cases: ClassVar = Cases(
        "",
        {"volume": PreserveWords, "volume inside": PreserveWords},
        "only the volume of a body can be preserved",
        "TIS312",
        hint=_volume_meant,
    )

    group: Group
    modulus: float  # [Pa]
    span: Span
    is_inside: bool = False
    has_caps: bool = False
    density: float = 0.0  # [kg/m³]

    def is_fluid(self, network: Network) -> bool:
        """Return whether this fills cavities, rather than cells or a closed surface."""
        if self.is_inside or self.has_caps or self.density:
            return True
        own = next((body for body in network.bodies if body.name == self.group.name), None)
        if own is None:
            return True
        nodes = numbers_in(own.nodes)
        return own.is_wall and any(np.isin(nodes, one.nodes).any() for one in network.mirrored)

    def made(self, network: Network) -> "KeptVolumes":
        """Return the enclosed volumes.

        Raises:
            NoSide: Cavities are requested, but there are none.
            ValueError: There is no other volume to preserve.
        """
        if not self.is_fluid(network):
            from tissuec.forces.enclosed.volume import Enclosure

            return Enclosure.of(network, self.group.name, self.modulus, self.span)
        from tissuec.forces.enclosed.fluids import FluidCavities
        from tissuec.forces.enclosed.pressed_sides import (
            NoInside,
            NoSide,
            Pressed,
            closed_by_caps,
            pressed_faces,
        )

        name = self.group.name
        part = next((body for body in network.bodies if body.name == name), None)
        if part is not None and part.is_solid and not self.is_inside:
            raise NoSide(
                f"{name} is solid, and only a space within it can hold a fluid",
                f"write: preserve volume inside of {name}",
            )
        try:
            faces = pressed_faces(network, Pressed(name, self.group.indices, self.is_inside))
        except NoInside as error:
            raise NoSide(str(error).partition(",")[0], FILLED) from error
        if self.has_caps:
            closed_by_caps(network, name, faces)
        return FluidCavities.of(
            network, name, faces, self.modulus, self.density, self.span, has_caps=self.has_caps
        )

    def flaw(self, network: Network) -> str:
        """Return the reason why a volume cannot be kept; empty if it can be."""
        try:
            self.made(network)
        except ValueError as error:
            hint = getattr(error, "hint", "") or self._instead(network)
            return Flaw(str(error), hint)
        return ""

    def _instead(self, network: Network) -> str:
        """Return which other bodies can keep their volume, or what could."""
        own = next((body for body in network.bodies if body.name == self.group.name), None)
        if own is None:
            return FILLED
        if own.is_made_of_elements and not own.is_wall:
            return "remove it; a larger Poisson's ratio keeps the volume more nearly"
        from tissuec.mechanics import enclosing_surfaces  # of a wall that is open

        if enclosing_surfaces.capped(network, own.name) is not None:
            return "close its open ends: with caps"
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
        if self.is_fluid(state.network):
            made = replace(made, gravity=state.gravity)
        old = state.enclosure(self.group.name)
        if old is not None and old.block.name != made.block.name:
            state.remove(old.block)
        put_as_drawn(state, made.block)
        text = sentence(self.span)
        happened = LoggedEvent("preserve", (), text, self.span)
        if old is None:
            return (happened,)
        replaced = LoggedEvent("note", (), _replacing(old, made, state.time), self.span)
        return happened, replaced


@VERBS.member("inflate")
class Inflate(VerbSentence, frozen=True):
    """Sets the volume that a body preserves, gradually within the interval or at once.

    This is the target volume. The actual volume and the pressure follow from the stiffness of
    the wall. The body must preserve its volume. For a lattice, it is the volume of all intact
    cells together. Another ``inflate`` of the same body replaces one that is under way: the
    target changes from its value at that time.
    """

    meant: ClassVar[str] = "fill insufflate pump blow"

    refused: ClassVar = {
        "by": Refusal(
            'inflate does not take "by": it sets the volume itself',
            "write the whole volume, such as: to 5 ml",
        )
    }

    group: Annotated[Group, SubjectPart("nodes", (BODY,), alone=True)]
    volume: Annotated[
        float,
        NumberClause("to", VOLUME, "positive", what="volume", example="to 5 ml"),
    ]
    profile: Annotated[TimeProfile, CHANGING]
    duration: Lasting

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
        """Return a failure: nothing here keeps a volume; it names the lost springs."""
        from tissuec.forces.enclosed.volume import Enclosure

        name = self.group.name
        message = f"{name} cannot be inflated: nothing preserves its volume yet"
        try:
            whole = Enclosure.of(state.network, name, 1.0, self.span)
        except ValueError:
            message = f"{name} cannot be inflated: no intact cavity of it is filled now"
            return ActionFailed(message, None, self.span)
        torn = whole.lost_walls(state.alive)
        torn = torn[torn < state.network.line_count]
        if len(whole.lost_items(state.alive)) < whole.item_count:
            return ActionFailed(message, None, self.span)
        what = "its surface is" if whole.item_count == 1 else "all its cells are"
        message = f"{name} cannot be inflated: {what} torn"
        return ActionFailed(message, None, self.span, torn.tolist())


def _replacing(old: "KeptVolumes", new: "KeptVolumes", time: float) -> str:
    """Describe how a further ``preserve`` changes the target at a time [s]."""
    text = f"replaced: {sentence(old.span)}"
    swell = float(old.amount(time))
    if not old.swellings:
        return text
    target, drawn = (
        show(float(v), VOLUME) for v in ((old.drawn * (1.0 + swell)).sum(), new.drawn.sum())
    )
    return f"{text}; the target is the drawn volume of {drawn} again, no longer {target}"


def _flaw(network: Network, body: str, span: Span) -> str:
    """Return why a body cannot keep its volume, empty if it can."""
    from tissuec.forces.enclosed.volume import Enclosure

    try:
        Enclosure.of(network, body, 1.0, span)
    except ValueError as error:
        return str(error)
    return ""
