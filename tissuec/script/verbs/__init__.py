"""Verbs of the script, each with the parts and the action of its sentences.

A verb is a class registered by its word. The annotations of its fields declare the parts of
a sentence (``script.parts``), from which the compiler makes a frozen action that holds network
indices and SI numbers; ``apply`` carries it out. Methods of their own give the facts that
checks need before a run: ``Demanding``, ``Breaking`` and ``Shifting`` here, and ``Holding`` in
``holding``.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn, Protocol, Self, TypeGuard, TypeVar, runtime_checkable

import numpy as np
from msgspec import Struct

from tissuec.core.registry import Family
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.phantoms import NotDivisible

T = TypeVar("T")
_FOLLOWS: dict[tuple[type, type], bool] = {}  # by the classes of actions and the protocols


#: Kind of an event that is not logged, of an action that has changed the state.
CHANGED = "changed"


class LoggedEvent(Struct, frozen=True):
    """One row of the event log: what happened, to which springs, and why."""

    kind: str  # "cut", "grasp", "release", "rupture", "trigger", …
    springs: Sequence[int]
    cause: str  # such as "cut oviduct with shears"
    span: Span


class EventQueue(Protocol):
    """Future actions; an action may add to it, such as the end of a motion."""

    def add(self, time: float, action: "Action") -> None:
        """Add an action at an absolute time [s]; a step ends exactly there."""
        ...

    def land(self, times: Floats) -> None:
        """Let steps end at absolute times [s], shape (n,), at which a derivative jumps."""
        ...

    def end(self, ended: LoggedEvent) -> None:
        """End the run after everything that happens at the present time."""
        ...


class Action(Protocol):
    """An action at one time; immutable, so that a plan can be run many times."""

    @property
    def span(self) -> Span: ...

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Change the state (at ``state.time``) and say what happened.

        Raises:
            ActionFailed: It cannot be done; the state is as it was.
        """
        ...


class Flaw(str):
    """Why an action can never be done, with a remedy.

    Attributes:
        hint: The remedy; empty if none is known.
    """

    hint: str = ""

    def __new__(cls, text: str, hint: str = "") -> "Flaw":
        flaw = super().__new__(cls, text)
        flaw.hint = hint
        return flaw


@runtime_checkable
class Demanding(Protocol):
    """An action that only some networks support, which is checked before any run."""

    @property
    def span(self) -> Span: ...

    def flaw(self, network: Network) -> str:
        """Return why it can never be done, empty if it can; a ``Flaw`` has a remedy, too."""
        ...


@runtime_checkable
class Breaking(Protocol):
    """An action after which springs may break that could not before, or a knot may slip."""

    def breakable(self, network: Network) -> Indices:
        """Return the springs that it gives a breaking or a crushing force, shape (n,)."""
        ...


@runtime_checkable
class Dividing(Protocol):
    """An action that may cut springs and edges of elements."""

    def lines_within(self, network: Network) -> Indices:
        """Return the springs and edges that it may cut, shape (n,)."""
        ...


def follows(action: Action, protocol: type[T]) -> TypeGuard[T]:
    """Return whether an action has the members of a protocol such as ``Breaking``.

    A script may have 100 000 actions, and ``isinstance`` compares all members each time.
    """
    key = type(action), protocol
    if key not in _FOLLOWS:
        _FOLLOWS[key] = isinstance(action, protocol)
    return _FOLLOWS[key]


def may_break(action: Action, network: Network) -> bool:
    """Return whether springs may break, or a knot slip, that could not before an action."""
    return follows(action, Breaking) and len(action.breakable(network)) > 0


@runtime_checkable
class Shifting(Protocol):
    """An action that moves nodes, also of others than its own."""

    @property
    def shift(self) -> float:
        """Return how far a node moves at most [m]; infinite if that is not known."""
        ...


class ActionFailed(Exception):
    """An action cannot be carried out, so that the run cannot continue.

    Attributes:
        message: What failed and why, in words that a node can follow.
        node: The one to name; None if there is none.
        span: The sentence.
        springs: Those that broke before, so that it cannot be carried out, shape (n,).
    """

    def __init__(self, message: str, node: int | None, span: Span, springs: Sequence[int] = ()):
        super().__init__(message)
        self.message, self.node, self.span = message, node, span
        self.springs = np.array(springs, dtype=np.int64)


class Group(Struct, frozen=True, eq=False):
    """Nodes or lines under a name: a set or a whole body.

    Attributes:
        indices: Ascending, shape (n,).
        are_lines: Whether they are springs and edges of elements.
    """

    name: str
    indices: Indices
    are_lines: bool = False

    def after_cuts(self, state: State) -> Self:
        """Return it with the copies of its nodes that cuts have made."""
        if self.are_lines:
            return self
        return replace(self, indices=state.with_copies(self.indices))


class Mover(Struct, frozen=True, eq=False):
    """A set that moves (``nodes`` given), or a tool with the nodes it holds then (None)."""

    name: str
    nodes: Indices | None

    def after_cuts(self, state: State) -> Self:
        """Return it with the copies of its nodes that cuts have made."""
        return (
            self if self.nodes is None else replace(self, nodes=state.with_copies(self.nodes))
        )


def after_cuts(action: Action, state: State) -> Action:
    """Return an action on the copies, too, that cuts have made of its nodes."""
    if not (isinstance(action, Struct) and state.is_cut):
        return action
    own: dict[str, Any] = {name: getattr(action, name) for name in action.__struct_fields__}
    changed = {
        name: each.after_cuts(state)
        for name, each in own.items()
        if isinstance(each, Group | Mover)
    }
    return replace(action, **changed) if changed else action


class Order(Protocol):
    """A sentence of the script after its parts are read, for what else a verb checks."""

    span: Span
    words: str  # those after the verb, such as "waist" or "pushing pressed"

    def has(self, word: str) -> bool:
        """Return whether a clause with this joining word was written."""
        ...

    def names_springs(self) -> bool:
        """Return whether the object of the verb is a set of springs."""
        ...

    def reject(
        self, code: str, message: str, *, hint: str = "", word: str | None = None
    ) -> NoReturn:
        """Refuse the sentence with a located diagnostic.

        Args:
            code: Code of the diagnostic.
            message: What is wrong.
            hint: How to fix it.
            word: Clause to mark; the whole sentence if None.
        """
        ...


#: By word: a ``VerbSentence`` of ``script.forms``, or a class with the ``cases`` of its
#: sentences. Its docstring is the text of the reference; ``meant`` are other words for it.
VERBS: Family[type[object]] = Family("tissuec.script.verbs", "verb")


@contextmanager
def stopping(span: Span) -> Iterator[None]:
    """Let an action fail where a body cannot be divided further.

    Args:
        span: The sentence.

    Raises:
        ActionFailed: It cannot.
    """
    try:
        yield
    except NotDivisible as error:
        raise ActionFailed(str(error), None, span) from error
