"""``irrigate``: jets of fluid on surfaces."""

from typing import TYPE_CHECKING, Annotated, ClassVar, Protocol

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import FLOW
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network, numbers_in
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    BODY,
    SET,
    STEADY,
    NumberClause,
    Refusal,
    SubjectPart,
    ToolClause,
)
from tissuec.script.verbs import VERBS, EventQueue, Group, LoggedEvent
from tissuec.script.verbs.acting import put_as_drawn
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

if TYPE_CHECKING:  # annotations only: scenes without jets load faster
    from tissuec.forces.acting.jets import Jet

NOZZLE = "tool NOZZLE { kind is nozzle; diameter = 2 mm; tip = … mm; direction = (0, 0, -1) }"


class Opening(Protocol):
    """Properties of a nozzle."""

    @property
    def diameter(self) -> float: ...

    @property
    def density(self) -> float: ...

    @property
    def growth(self) -> float: ...


class EndJet(Struct, frozen=True):
    """The end of a jet, unless another one took its place before."""

    nozzle: str
    stop: float  # [s], which distinguishes it from others
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        jet = state.jets.get(self.nozzle)
        if jet is None or jet.profile.stop != self.stop:
            return ()
        state.remove(jet.block)
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("irrigate")
class Irrigate(VerbSentence, frozen=True):
    """Emits a jet of fluid from a nozzle, for the interval or until ``stop irrigating``.

    The jet pushes the surface that it meets: that of the named body or set of nodes, or of all
    bodies if none is named. Bodies that are not named still block their part of the jet. The
    jet moves and turns with its nozzle. The flow is constant or follows the profile after
    ``using``; there is no flow while the profile is negative. A nozzle has one jet: a new
    action replaces the previous one. ``force of`` the nozzle is the force that holds it
    against the recoil.
    """

    meant: ClassVar[str] = "rinse flush spray wash"
    refused: ClassVar = {
        word: Refusal(
            f'irrigate does not take "{word}": the nozzle determines the direction',
            f"write: through NOZZLE, with {NOZZLE}",
        )
        for word in ("along", "of")
    }

    group: Annotated[Group | None, SubjectPart("nodes", (BODY, SET))]  # None: all surfaces
    flow: Annotated[
        float,
        NumberClause("with", FLOW, "positive", what="flow", example="with 5 ml/s"),
    ]
    nozzle: Annotated[
        str,
        ToolClause(
            "through",
            "nozzle",
            what="nozzle",
            example=f"through …, with {NOZZLE}",
        ),
    ]
    opening: Annotated[Opening, ToolClause("through", "nozzle", entries=True)]
    profile: Annotated[TimeProfile, STEADY]

    def flaw(self, network: Network) -> str:
        """Return why nothing could ever be pushed, empty if something can."""
        if np.isin(network.skin, self._nodes(network)).all(axis=1).any():
            return ""
        if self.group is None:
            return "no body here has a surface for the jet to push"
        return f"{self.group.name} has no complete triangle of a surface for the jet to push"

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, None)
        network, jet = state.network, self.jet(state, profile)
        logged_events = [LoggedEvent("irrigate", (), sentence(self.span), self.span)]
        if (old := state.jets.get(self.nozzle)) is not None:
            text = f"replaced: {sentence(old.span)}"
            logged_events.append(LoggedEvent("note", (), text, self.span))
        state.place_held()
        put_as_drawn(state, jet.block)
        if why := _in_vain(state.jets[self.nozzle], network, state.position):
            text = f"{sentence(self.span)}: {why}"
            logged_events.append(LoggedEvent("note", (), text, self.span))
        if np.isfinite(stop):
            queue.add(stop, EndJet(self.nozzle, stop, self.span))
        return tuple(logged_events)

    def jet(self, state: State, profile: TimeProfile) -> "Jet":
        """Return the jet on the surface that is intact now.

        Args:
            state: Of the run.
            profile: Of the flow, in the time of the run.
        """
        from tissuec.forces.acting.jet_surfaces import JetSurface, finest_width
        from tissuec.forces.acting.jets import Jet  # where something is irrigated

        network, bore = state.network, self.opening.diameter
        part = next(tool for tool in network.tools if tool.name == self.nozzle)
        nodes = self._nodes(network)
        width = finest_width(network, nodes, bore)
        return Jet(
            nozzle=self.nozzle,
            target="" if self.group is None else self.group.name,
            opening=numbers_in(part.nodes),
            bore=bore,
            density=self.opening.density,
            growth=self.opening.growth,
            width=width,
            flow=self.flow,
            profile=profile,
            skin=JetSurface.of(network, nodes, width, state.alive),
            span=self.span,
        )

    def _nodes(self, network: Network) -> Indices:
        return np.arange(network.body_nodes) if self.group is None else self.group.indices


def _in_vain(jet: "Jet", network: Network, position: Floats) -> str:
    """Return why a jet pushes nothing now, empty if it does."""
    from tissuec.forces.acting.jet_surfaces import buried_in

    if body := buried_in(network, position, position[jet.opening[0]]):
        return f"the nozzle is inside {body}, where its jet has no effect"
    met = jet.skin.struck[jet.met(position)].any()
    return "" if met else "the jet does not hit any surface at this time"


def stop_irrigating(state: State, target: str) -> bool:
    """End the jets on a set or body, all of them if it is ""; return whether there were any."""
    ended = [jet.block for jet in state.jets.values() if target in ("", jet.target)]
    state.remove(*ended)
    return bool(ended)
