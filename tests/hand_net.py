"""Small nets, sentences and a diary of times, written by hand for tests."""

import numpy as np
from msgspec import Struct, field

from tissuec.core.source import Source, Span
from tissuec.laws import LINEAR
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Network, Origin, Provenance
from tissuec.model.profiles import TimeProfile
from tissuec.model.springs import Springs
from tissuec.script import parts
from tissuec.script.forms import forms_of
from tissuec.script.verbs import Group, Mover


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
    """An order given in values: what is behind the verb, and the clauses."""

    words: str
    clauses: dict
    groups: dict
    tools: dict = field(default_factory=dict)
    duration: float | None = None
    span: Span = field(default_factory=span)

    def has(self, word):
        return word in self.clauses

    def names_springs(self):
        return True

    def reject(self, code, message, *, hint="", word=None):
        raise Refused(code, message)

    def read(self, form):
        """Return what the order says, read by the parts of its form."""
        name = self.words
        if form.cases is not None and not form.cases.word:
            name = name.removeprefix(form.literal).strip()
        for word, refusal in form.kind.refused.items():
            if word in self.clauses and form.of_word(word) is None:
                self.reject("TIS303", refusal.message)
        parts = {
            field: self._part(part, name, form, is_optional=field in form.optional)
            for field, part in form.parts.items()
        }
        return form.kind(span=self.span, **parts)

    def _part(self, part, name, form, *, is_optional):
        match part:
            case parts.LastingPart():
                return self.duration
            case parts.CasePart():
                return form.literal
            case parts.FlagPart():
                given = self.clauses.get(part.word)
                if given is not None and f"{part.word} {given}" != part.text:
                    self.reject("TIS305", f"unexpected {given}")
                return given is not None
            case parts.ProfileClause():
                return self._profiles(part)
            case parts.SubjectPart() | parts.ToolClause():
                named = self.clauses.get(part.word) if part.word else name or None
                if named is None and not is_optional:
                    self.reject("TIS304", "a name is missing")
                return None if named is None else self._named(part, named)
        if isinstance(part, parts.EitherClause):
            written = [one for one in part.clauses if one.word in self.clauses]
            if len(written) != 1:
                self.reject("TIS306" if written else "TIS304", "either one or the other")
            word = written[0].word
            return parts.Amount(word, self._value(written[0], self.clauses[word]))
        if part.word not in self.clauses:
            return None if is_optional else self.reject("TIS304", f"no {part.word}")
        return self._value(part, self.clauses[part.word])

    def _named(self, part, name):
        if isinstance(part, parts.ToolClause):
            if part.kind not in ("grasping", self.tools[name]):
                self.reject("TIS312", f"{name} is no {part.kind}")
            return name
        if part.kind == "moved" and name in self.tools:
            return Mover(name, None)
        nodes = np.asarray(self.groups[name], dtype=np.int64)
        return Mover(name, nodes) if part.kind == "moved" else Group(name, nodes)

    def _value(self, part, value):
        match part:
            case parts.NumberClause():
                signs = {"any": True, "positive": value > 0.0, "not negative": value >= 0.0}
                return value if signs[part.sign] else self.reject("TIS308", f"{value}")
            case parts.VectorClause():
                return np.array(value, dtype=float)
            case parts.DirectionClause():
                return np.array(value, dtype=float) / np.linalg.norm(value)
            case parts.DirectedClause():
                return self._directed(part, value)
            case _:
                return value

    def _directed(self, part, value):
        if np.ndim(value) == (part.along in self.clauses):
            self.reject("TIS304" if np.ndim(value) == 0 else "TIS306", "no or two directions")
        if np.ndim(value) == 1:
            return np.array(value, dtype=float)
        way = np.array(self.clauses[part.along], dtype=float)
        return value * way / np.linalg.norm(way)

    def _profiles(self, part):
        default = part.at_once if self.duration is None else part.over
        if default is None:
            return None
        found = self.clauses.get("using", default)
        if not found:
            self.reject("TIS304", "the profile of the motion is missing")
        if not isinstance(found, str):
            return found if part.path else found[0]
        kind = {"constant speed": "ramp", "smooth profile": "smooth"}.get(found, found)
        if not default and kind == "constant":
            self.reject("TIS306", "a jump")
        stop = np.inf if self.duration is None else self.duration
        profile = TimeProfile(kind, 0.0, stop)
        if not part.path:
            return profile
        if part.path not in self.clauses:
            self.reject("TIS304", "no vector")
        return (profile,)


def order(sentence, groups, *, tools=None, duration=None, **clauses):
    """Return the action of a sentence: order("push all", groups, **{"with": (0, 0, 1)})."""
    verb, _, words = sentence.partition(" ")
    named = {word.rstrip("_"): value for word, value in clauses.items()}
    saying = Saying(words, named, groups, tools or {}, duration, span(sentence))
    forms = {form.literal: form for form in forms_of(verb)}
    cases = forms_of(verb)[0].cases
    if cases is None:
        chosen = ""
    elif cases.word:
        chosen = named.get(cases.word, "")
    else:
        fitting = [one for one in forms if one and f"{words} ".startswith(f"{one} ")]
        chosen = max(fitting, key=len, default="")
    if chosen not in forms:
        saying.reject(cases.code, f"unknown {chosen}")
    return saying.read(forms[chosen]).action(saying)


def table(times, values):
    """Return a profile through values, straight lines between them being good enough."""
    times, values = np.array(times, dtype=float), np.array(values, dtype=float)
    return TimeProfile("table", 0.0, times[-1], 0.0, times, values, np.gradient(values, times))


def event_action(name):
    """Return some action, told from others by its name."""
    return order(f"fix {name}", {name: [0]})
