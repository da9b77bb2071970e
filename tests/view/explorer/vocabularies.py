"""Random vocabularies, written as text: every layout of words, hedge, operator and unit.

A text that the compiler refuses (words that overlap, a set that is a single point) is drawn
again, so that what is left is what somebody could have written.
"""

import random
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from msgspec import Struct

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.fuzzy.hedges import hedged, moves
from tissuec.fuzzy.scale import Axis
from tissuec.pipeline import read_words
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.request import Request
from tissuec.scene.words.phrases import reading
from tissuec.view.explorer.tables import tables

TRIES = 200
BREAK = "\n  "
SCALES = (
    ("0", "1", "", False),
    ("0 %", "100 %", "%", False),
    ("-3", "7", "", False),
    ("1000", "1001", "", False),
    ("1 kPa", "1 MPa", "kPa", True),
    ("10 mm", "12 mm", "mm", True),
    ("0.001", "1000", "", True),
)
QUANTITIES = (
    ("spring constant", "2 N/m", "2000 N/m", "N/m", True, "each spring of 5 mm"),
    ("viscosity", "0.1 mN*s/m", "100 mN*s/m", "mN*s/m", True, "each spring"),
    ("mass", "3 mg", "300 mg", "mg", False, "each node"),
    ("breaking force", "0.05 N", "5 N", "N", True, "each spring"),
    ("prestress", "-5 %", "20 %", "%", False, "each spring"),
    ("relaxation time", "1 ms", "10 s", "ms", True, "each spring"),
)
NAMES = ("firmness", "Grösse", '"feel of it"', "wetness", "age of wall", "grip")
WORDS = ("faint", "low", "very low", "middling", '"on edge"', "high", "utmost", "x9")
HEDGES = (
    "hedge very = shift({} %, outward)",
    "hedge rather = shift({} %, inward)",
    "hedge utterly = power(2)",
    "hedge vaguely = power(0.5)",
)


class Vocabulary(Struct, frozen=True):
    """A text, what the compiler makes of it, and its tables."""

    text: str
    words: ResolvedProgram
    tables: dict


@cache
def vocabulary(seed: int) -> Vocabulary:
    """Return a random vocabulary that the compiler accepts."""
    for attempt in range(TRIES):
        text = Writer(random.Random(1000 * seed + attempt)).text()
        request = Request(Source("words.tis", text, Path("words.tis")))
        try:
            words = read_words(request)[0]
        except CompileError:
            continue
        return Vocabulary(text, words, tables(words))
    raise AssertionError(f"{TRIES} texts in a row were refused:\n{text}")


def of_file(path: Path) -> Vocabulary:
    """Return the vocabulary of a file."""
    request = Request.file(path)
    words = read_words(request)[0]
    return Vocabulary(request.source.text, words, tables(words))


class Writer:
    """Writes one text."""

    def __init__(self, source: random.Random):
        self.random = source

    def text(self) -> str:
        hedges = [
            h.format(self.random.choice([10, 50, 90]))
            for h in HEDGES
            if self.random.random() < 0.7
        ]
        self.hedges = [h.split()[1] for h in hedges]
        self.scales: dict[str, list[str]] = {}
        names = self.random.sample(NAMES, self.random.randint(1, 5))
        properties = [self.property(n.replace("age of wall", '"age of wall"')) for n in names]
        chosen = self.random.sample(QUANTITIES, self.random.randint(1, 4))
        quantities = [self.quantity(*one) for one in chosen]
        self.properties = list(self.scales)[: len(names)]
        self.quantities = [name for name, *_ in chosen]
        blocks = [self.rules(k) for k in range(self.random.choice([1, 1, 2]))]
        return "\n".join(["language 1", *hedges, *properties, *quantities, *blocks, ""])

    def property(self, name: str) -> str:
        low, high, unit, log = self.random.choice(SCALES)
        head = f"property {name} from {low} to {high}{' on log scale' if log else ''}"
        return f"{head} {{\n  {self.layout(name, low, high, unit, log)}\n}}"

    def quantity(self, name, low, high, unit, log, applies) -> str:
        head = f"quantity {name} from {low} to {high}{' on log scale' if log else ''}"
        layout = self.layout(name, low, high, unit, log)
        otherwise = ""
        if self.random.random() < 0.5:
            otherwise = f"\n  otherwise is {self.random.choice(self.scales[name])}"
        return f"{head} {{\n  {layout}\n  applies to {applies}{otherwise}\n}}"

    # --- words ------------------------------------------------------------------------------

    def layout(self, name: str, low: str, high: str, unit: str, log: bool) -> str:
        words = self.random.sample(WORDS, self.random.randint(1, 6))
        self.scales[name] = words
        kind = self.random.choice(["evenly", "plateaus", "shapes", "shapes"])
        if kind == "evenly":
            return f"evenly = [{', '.join(words)}]"
        start, end = (float(text.split()[0]) for text in (low, high))
        end *= 1000.0 if high.endswith("MPa") or high.endswith("10 s") else 1.0
        axis = Axis(name, start, end, log=log)
        number = lambda share: f"{self.at(axis, share):.6g} {unit}".strip()  # noqa: E731
        if kind == "plateaus" and len(words) > 1:
            return self.plateaus(words, number)
        return "\n  ".join(f"{word} = {self.shape(number)}" for word in words)

    def at(self, axis: Axis, share: float) -> float:
        low, high = axis.bounds
        return axis.from_scale(low + (high - low) * share)

    def plateaus(self, words, number) -> str:
        cuts = sorted(self.random.random() for _ in range(2 * len(words) - 2))
        if self.random.random() < 0.5:
            cuts[1::2] = cuts[::2]  # they touch: sharp edges
        first, *rest = words
        lines = [f"{first} until {number(cuts[0])}"]
        for k, word in enumerate(rest[:-1]):
            lines.append(f"{word} from {number(cuts[2 * k + 1])} to {number(cuts[2 * k + 2])}")
        return "\n  ".join([*lines, f"{rest[-1]} from {number(cuts[-1])}"])

    def shape(self, number) -> str:
        kind = self.random.choice(["triangle", "trapezoid", "gaussian", "points"])
        shares = sorted(
            self.random.choice([self.random.random(), 0.0, 0.5, 1.0]) for _ in "abcd"
        )
        if kind == "gaussian":
            width = self.random.uniform(0.02, 0.4)
            mean, aside = number(shares[1] * 0.9), number(shares[1] * 0.9 + width)
            return f"gaussian({mean}, {aside} - ({mean}))"
        if kind == "points":
            ys = [self.random.choice([0, 0.25, 0.7]), 1, self.random.choice([1, 0.5]), 0]
            pairs = (f"{number(x)}, {y}" for x, y in zip(shares, ys, strict=True))
            return f"points({', '.join(pairs)})"
        feet = shares[: 3 if kind == "triangle" else 4]
        return f"{kind}({', '.join(map(number, feet))})"

    # --- rules ------------------------------------------------------------------------------

    def rules(self, number: int) -> str:
        choose = self.random.choice
        name = choose(["simple", '"of the trade"']) if number == 0 else "others"
        lines = [
            f"conjunction is {choose(['minimum', 'product'])}",
            f"disjunction is {choose(['maximum', 'probabilistic sum'])}",
            f"implication is {choose(['minimum', 'product'])}",
            f"result is {choose(['centre of gravity', 'weighted mean', 'gradual mean'])}",
            *(self.rule() for _ in range(self.random.randint(1, 12))),
        ]
        return f"rules {name} {{\n  {BREAK.join(lines)}\n}}"

    def rule(self) -> str:
        said = self.random.sample(
            self.quantities, self.random.randint(1, min(2, len(self.quantities)))
        )
        conclusions = " and ".join(f"{name} is {self.word(name, 2)}" for name in said)
        weight = self.random.choice(["", "", " weighing 0.3"])
        remark = self.random.choice(["", "", "  # as experts say; with; signs"])
        return f"if {self.condition(2)}{remark}\n    then {conclusions}{weight}"

    def condition(self, depth: int) -> str:
        kind = self.random.choice(["is", "is", "not", "and", "or"] if depth else ["is"])
        if kind == "is":
            name = self.random.choice(self.properties)
            negation = self.random.choice(["", "", "not "])
            return f"{name} is {negation}{self.word(name, 4)}"
        if kind == "not":
            return f"not ({self.condition(depth - 1)})"
        parts = [f"({self.condition(depth - 1)})" for _ in range(self.random.randint(2, 3))]
        return f" {kind} ".join(parts)

    def word(self, name: str, hedges: int) -> str:
        """Return a word, perhaps with one of the first hedges before it."""
        usable = [
            h.split()[1] for h in HEDGES[:hedges] if h.split()[1] in self.hedges
        ]  # powers stand last
        hedge = self.random.choice(["", *usable])
        return f"{hedge} {self.random.choice(self.scales[name])}".strip()


# --- facts ----------------------------------------------------------------------------------


def facts(one: Vocabulary, rules: str, count: int, seed: int) -> Iterator[dict[str, float]]:
    """Yield values of properties: ends, corners and middles of sets, hedged words, and any.

    Sometimes a property is left out. The first cases have every property at one end.
    """
    source = random.Random(seed)
    properties = one.words.vocabulary.properties
    places = {key: _places(one, rules, key) for key in properties}
    yield {key: named.scale.axis.low for key, named in properties.items()}
    yield {key: named.scale.axis.high for key, named in properties.items()}
    for _ in range(count - 2):
        case = {}
        for key, named in properties.items():
            axis = named.scale.axis
            share = source.uniform(*axis.bounds)
            value = axis.from_scale(source.choice([share, source.choice(places[key])]))
            if source.random() > 0.08:
                case[key] = value
        yield case


def _places(one: Vocabulary, rules: str, key: str) -> list[float]:
    """Return coordinates at which something happens on one property."""
    vocabulary = one.words.vocabulary
    scale = vocabulary.properties[key].scale
    axis, hedges = scale.axis, vocabulary.hedges
    places = [*axis.bounds, *vocabulary.rules[rules].base._corners[key]]
    for word, shape in scale.words.items():
        places.append(shape.middle)
        for name, hedge in hedges.items():
            phrase = f"{name} {word}"
            if moves(hedge, shape, axis) and reading(phrase, scale.words, hedges):
                places.append(hedged([hedge], shape, axis).middle)
    return [min(max(place, axis.bounds[0]), axis.bounds[1]) for place in places]
