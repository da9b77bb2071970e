"""Small nets, sentences and a diary of times, written by hand for tests."""

import numpy as np
from msgspec import Struct, field

from tissuec.core.source import Source, Span
from tissuec.laws import LINEAR
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Network, Origin, Provenance
from tissuec.model.profiles import TimeProfile
from tissuec.model.springs import Springs
from tissuec.script.verbs import VERBS, Group, Mover


def span(text="sentence"):
    source = Source("hand.tis", text)
    return Span(source, 0, len(text))


def make_net(
    position,
    ends,
    *,
    mass=1.0,
    stiffness=1.0,
    damping=0.0,
    rest=None,
    strength=np.inf,
    crush=np.inf,
    velocity=0.0,
    law=None,
):
    """Return a network of one body called "net"; rest lengths are the drawn ones by default."""
    position = np.array(position, dtype=float).reshape(-1, 3)
    ends = np.array(ends, dtype=np.int32).reshape(-1, 2)
    nodes, springs = len(position), len(ends)
    drawn = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)

    def per(count, value):
        return np.broadcast_to(np.asarray(value, dtype=float), (count,)).copy()

    place = span("body net")
    names = {"mass": nodes} | dict.fromkeys(
        ("stiffness", "damping", "rest", "strength", "crush"), springs
    )
    return Network(
        position=position,
        velocity=np.broadcast_to(np.asarray(velocity, dtype=float), (nodes, 3)).copy(),
        mass=per(nodes, mass),
        springs=Springs(
            ends=ends,
            stiffness=per(springs, stiffness),
            damping=per(springs, damping),
            rest=drawn if rest is None else per(springs, rest),
            strength=per(springs, strength),
            crush=per(springs, crush),
            law=np.full(springs, 0 if law is None else 1, dtype=np.int32),
            laws=(LINEAR,) if law is None else (LINEAR, law),
            ids=np.arange(springs) + 500,
        ),
        skin=np.zeros((0, 3), dtype=np.int32),
        node_ids=np.arange(nodes) + 100,
        bodies=(BodyPart("net", slice(0, nodes), slice(0, springs), place),),
        provenance={
            name: Provenance(np.zeros(count, dtype=np.int32), (Origin(place, "written"),))
            for name, count in names.items()
        },
    )


def chain(count, *, spacing=1.0, **parameters):
    """Return nodes along x, each joined to the next."""
    position = np.zeros((count, 3))
    position[:, 0] = spacing * np.arange(count)
    ends = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    return make_net(position, ends, **parameters)


def start(network, *, gravity=(0.0, 0.0, 0.0), drag=0.0):
    return State.start(network, gravity=np.array(gravity, dtype=float), drag=drag)


class Diary:
    """A queue that only remembers."""

    def __init__(self):
        self.added = []
        self.landings = set()

    def add(self, time, action):
        self.added.append((time, action))

    def land(self, times):
        self.landings |= set(map(float, times))

    def end(self, ended):
        self.ended = ended

    def play(self, state, until):
        """Carry out what was added up to a time, driven nodes being on their paths."""
        logged_events = []
        while due := [entry for entry in self.added if entry[0] <= until]:
            entry = min(due, key=lambda entry: entry[0])
            self.added.remove(entry)
            state.time = entry[0]
            logged_events += entry[1].apply(state, self)
        state.time = until
        state.place_held()
        return logged_events


class Refused(Exception):
    """An order was rejected; holds the code and the message."""


class Saying(Struct):
    """An order given in values: what stands behind the verb, and the clauses."""

    words: str
    clauses: dict
    groups: dict
    tools: dict = field(default_factory=dict)
    duration: float | None = None
    span: Span = field(default_factory=span)

    def has(self, word):
        return word in self.clauses

    def _group(self, name):
        return Group(name, np.asarray(self.groups[name], dtype=np.int64))

    def nodes(self, *, after=""):
        return self._group(self.words.removeprefix(after).strip())

    def nodes_of(self, word):
        return self._group(self.clauses[word])

    def springs(self):
        return self.nodes()

    def springs_of(self, word):
        return self.nodes_of(word)

    def names_springs(self):
        return True

    def mover(self, *, after=""):
        name = self.words.removeprefix(after).strip()
        return Mover(name, None if name in self.tools else self._group(name).indices)

    def is_tool(self):
        return self.words in self.tools

    def tool(self, word, *, kinds=()):
        if word not in self.clauses:
            return None
        name = self.clauses[word]
        if kinds and self.tools[name] not in kinds:
            self.reject("TIS312", f"{name} is no {kinds[0]}")
        return name

    def vector(self, word, dimension):
        return np.array(self._clause(word), dtype=float)

    def number(self, word, dimension):
        return float(self._clause(word))

    def direction(self, word):
        vector = self.vector(word, None)
        return vector / np.linalg.norm(vector)

    def is_vector(self, word):
        return np.ndim(self.clauses[word]) == 1

    def text(self, word):
        return self._clause(word)

    def profiles(self, *, default, columns=1):
        found = self.clauses.get("using", default)
        if not isinstance(found, str):
            return found
        if not found:
            self.reject("TIS304", "the profile of the motion is missing")
        kind = {"constant speed": "ramp", "smooth profile": "smooth"}.get(found, found)
        stop = np.inf if self.duration is None else self.duration
        return (TimeProfile(kind, 0.0, stop),) * columns

    def reject(self, code, message, *, hint="", word=None):
        raise Refused(code, message)

    def _clause(self, word):
        if word not in self.clauses:
            self.reject("TIS304", f'"{word}" is missing')
        return self.clauses[word]


def order(sentence, groups, *, tools=None, duration=None, **clauses):
    """Return the action of a sentence: order("push all", groups, **{"with": (0, 0, 1)})."""
    verb, _, words = sentence.partition(" ")
    named = {word.rstrip("_"): value for word, value in clauses.items()}
    saying = Saying(words, named, groups, tools or {}, duration, span(sentence))
    return VERBS[verb].read(saying)


def table(times, values):
    """Return a profile through values, straight lines between them being good enough."""
    times, values = np.array(times, dtype=float), np.array(values, dtype=float)
    return TimeProfile("table", 0.0, times[-1], 0.0, times, values, np.gradient(values, times))


def event_action(name):
    """Return some action, told from others by its name."""
    return order(f"fix {name}", {name: [0]})
