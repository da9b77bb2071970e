"""``stop``: the end of a force, of a jet or of a motion."""

from functools import partial
from typing import Annotated, ClassVar

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import SET, Cases, Chosen, Moved, Nodes, SubjectPart
from tissuec.script.verbs import VERBS, Action, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.acting import stop_acting
from tissuec.script.verbs.holding import Stopped, sentence
from tissuec.script.verbs.irrigate import stop_irrigating
from tissuec.script.verbs.motion import stop_shifting, stop_turning
from tissuec.script.verbs.push import stop_pushing

_STOPS = {
    "pushing": stop_pushing,
    "pulling": stop_pushing,
    "pressing": partial(stop_acting, kind="pressure"),
    "moving": stop_shifting,
    "turning": stop_turning,
    "irrigating": stop_irrigating,
    "activating": partial(stop_acting, kind="activation"),
}


class StopForces(VerbSentence, frozen=True):
    """The end of forces, pressures or activations of nodes."""

    what: Chosen
    group: Nodes

    def action(self, order: Order) -> Action:
        return Stop(self.what, self.group.name, self.span)


class StopMotion(VerbSentence, frozen=True):
    """The end of a motion or turn of a set or tool."""

    what: Chosen
    mover: Moved

    def action(self, order: Order) -> Action:
        return Stop(self.what, self.mover.name, self.span)


class StopJets(VerbSentence, frozen=True):
    """The end of the jets on nodes, or of all jets."""

    what: Chosen
    group: Annotated[Group | None, SubjectPart("nodes", (SET,))]

    def action(self, order: Order) -> Action:
        return Stop(self.what, "" if self.group is None else self.group.name, self.span)


@VERBS.member("stop")
class Stop(Struct, frozen=True):
    """Ends all forces on a set, or stops the motion or turn of a set or tool where it is.

    Whatever was moved or turned stays held. ``pushing`` and ``pulling`` mean the same. ``stop
    pressing SET`` and ``stop activating SET`` end the pressures and activations on this set or
    body. ``stop irrigating SET`` ends the jets on it, ``stop irrigating`` all jets.
    """

    meant: ClassVar[str] = "halt pause"
    cases: ClassVar = Cases(
        "",
        {
            "pushing": StopForces,
            "pulling": StopForces,
            "pressing": StopForces,
            "moving": StopMotion,
            "turning": StopMotion,
            "irrigating": StopJets,
            "activating": StopForces,
        },
        '"{}" cannot be stopped',
        what="action to stop",
    )

    what: str  # such as "pushing"
    name: str  # of the set or mover; empty for all jets
    span: Span

    def holding(self) -> Stopped | None:
        return Stopped(self.name) if self.what in ("moving", "turning") else None

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        text = sentence(self.span)
        if not _STOPS[self.what](state, self.name):
            return (LoggedEvent("note", (), f"{text}: nothing to stop", self.span),)
        return (LoggedEvent("stop", (), text, self.span),)
