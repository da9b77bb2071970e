"""Inference against exact rational arithmetic, written independently.

The reference knows sets as lists of rational points, evaluates their maximum wherever it wants,
and integrates it exactly between all corners, clipping points and crossings. It shares no code
with the package. On log scales the floating-point logarithms are the rational coordinates.
"""

import math
import random
from fractions import Fraction
from itertools import combinations, pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.every import every
from tests.examples import examples
from tissuec.fuzzy.centroid import centre_of_gravity
from tissuec.fuzzy.rulebase import NoRule, RuleBase
from tissuec.fuzzy.rules import (
    CHOICES,
    And,
    ConcludedQuantity,
    Conclusion,
    Is,
    Not,
    Operators,
    Or,
    Rule,
)
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import Word, points

PROMISE = 1e-12  # of the range, the largest error allowed


# --- the reference ---


def exact_degree(pairs, x):
    """Return the degree at ``x`` of rational points; a vertical edge counts as its top."""
    at = [y for px, y in pairs if px == x]
    if at:
        return max(at)
    if x < pairs[0][0] or x > pairs[-1][0]:
        return pairs[0][1] if x < pairs[0][0] else pairs[-1][1]
    for (x0, y0), (x1, y1) in pairwise(pairs):
        if x0 < x < x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    raise AssertionError("unreachable")


def exact_centre(terms, low, high, implication):
    """Return the centre of the maximum of clipped or scaled sets, as a Fraction."""

    def clipped(pairs, weight):
        if implication == "product":
            return lambda x: weight * exact_degree(pairs, x)
        return lambda x: min(weight, exact_degree(pairs, x))

    functions = [clipped(pairs, weight) for pairs, weight in terms]
    corners = {low, high}
    for pairs, weight in terms:
        corners |= {x for x, _ in pairs if low < x < high}
        for (x0, y0), (x1, y1) in pairwise(pairs):
            if y0 != y1:
                x = x0 + (x1 - x0) * (weight - y0) / (y1 - y0)
                corners |= {x} if max(x0, low) < x < min(x1, high) else set()
    crossings = set()
    for a, b in pairwise(sorted(corners)):
        lines = [line_through(f, a, b) for f in functions]
        for (s0, c0), (s1, c1) in combinations(lines, 2):
            if s0 != s1 and a < (c1 - c0) / (s0 - s1) < b:
                crossings.add((c1 - c0) / (s0 - s1))
    area = moment = Fraction(0)
    for a, b in pairwise(sorted(corners | crossings)):
        slope, constant = line_through(lambda x: max(f(x) for f in functions), a, b)
        area += slope * (b**2 - a**2) / 2 + constant * (b - a)
        moment += slope * (b**3 - a**3) / 3 + constant * (b**2 - a**2) / 2
    return moment / area


def line_through(function, a, b):
    """Return slope and constant of a function that is linear inside ``(a, b)``."""
    x0, x1 = a + (b - a) / 3, a + 2 * (b - a) / 3
    slope = (function(x1) - function(x0)) / (x1 - x0)
    return slope, function(x0) - slope * x0


def rational(pairs):
    return [(Fraction(x), Fraction(y)) for x, y in pairs]


# --- the centre of gravity ---


@st.composite
def raw_sets(draw, low, high):
    """Draw points with vertical edges, plateaus, bumps, and feet outside the range."""
    place = st.one_of(st.integers(-4, 20).map(lambda k: k / 16), st.floats(-0.2, 1.2))
    shares = sorted(draw(st.lists(place, min_size=2, max_size=6)))
    degree = st.one_of(st.sampled_from([0.0, 0.25, 0.5]), st.floats(0.0, 0.75))
    ys = [draw(degree) for _ in shares]
    peak = draw(st.integers(0, len(ys) - 1))
    ys[peak] = draw(st.sampled_from([1.0, 0.875]))
    return [(low + (high - low) * share, y) for share, y in zip(shares, ys, strict=True)]


@st.composite
def unions(draw):
    log = Axis("log", 1e-6, 1e6, log=True).bounds
    low, high = draw(st.sampled_from([(0.0, 1.0), (1000.0, 1001.0), (-1e-7, 2e-7), log]))
    weight = st.one_of(st.sampled_from([0.0, 0.25, 0.5, 1.0]), st.floats(0.0, 1.0))
    terms = []
    for pairs in draw(st.lists(raw_sets(low, high), min_size=1, max_size=5)):
        try:
            terms.append((pairs, points(pairs).within(low, high), draw(weight)))
        except ValueError:
            continue  # a spike, or a peak outside the range
    return low, high, terms, draw(st.sampled_from(CHOICES["implication"]))


@settings(max_examples=examples(400), derandomize=True)
@given(unions())
def test_the_centre_of_any_union_is_exact(union):
    low, high, terms, implication = union
    firing = [(pairs, shape, w) for pairs, shape, w in terms if w >= 1e-100]
    if not firing:
        with pytest.raises(ValueError, match="no word fires"):
            centre_of_gravity([(s, w) for _, s, w in terms], low, high, implication=implication)
        return
    found = centre_of_gravity(
        [(shape, w) for _, shape, w in terms], low, high, implication=implication
    )
    exact = exact_centre(
        [(rational(pairs), Fraction(w)) for pairs, _, w in firing],
        Fraction(low),
        Fraction(high),
        implication,
    )
    assert abs(Fraction(found) - exact) <= PROMISE * Fraction(high - low)


# --- whole systems ---

RANGES = [
    (0.0, 1.0, False),
    (1000.0, 1001.0, False),
    (-3.0, 7.0, False),
    (1e-6, 1e6, True),
    (0.001, 1.0, True),
]


def each_is(condition, negated=False):
    """Yield for each ``is`` whether it is negated, its property and its word."""
    kind, *rest = condition
    if kind == "is":
        yield negated, *rest
    else:
        for part in rest:
            yield from each_is(part, negated != (kind == "not"))


class System:
    """A random rule base, and the same thing in rational numbers."""

    def __init__(self, seed: int):
        self.random = random.Random(seed)
        self.operators = Operators(**{k: self.random.choice(v) for k, v in CHOICES.items()})
        self.axes = {name: self.axis(name) for name in ("p0", "p1", "p2", "q0", "q1")}
        self.sets = {name: self.scale(axis) for name, axis in self.axes.items()}
        self.rules = [self.rule() for _ in range(self.random.randint(3, 9))]

    def axis(self, name):
        low, high, log = self.random.choice(RANGES)
        return Axis(name, low, high, log=log)

    def scale(self, axis):
        """Return overlapping words with sharp edges, in coordinates: word -> points."""
        low, high = axis.bounds
        scale = {}
        for k in range(self.random.randint(2, 5)):
            draw = self.random.choice(
                [lambda: self.random.randint(0, 8) / 8, self.random.random]
            )
            a, b, c, d = sorted(low + (high - low) * draw() for _ in range(4))
            if a == d:
                a, d = low, high
            scale[f"w{k}"] = [(a, 0.0), (b, 1.0), (c, 1.0), (d, 0.0)]
        return scale

    def rule(self):
        """Return (condition, conclusions, weight); conditions are nested tuples."""
        conclusions = {
            q: self.random.choice(list(self.sets[q])) for q in self.random.choice(
                [("q0",), ("q1",), ("q0", "q1")]
            )
        }  # fmt: skip
        return self.condition(2), conclusions, self.random.choice([1.0, 1.0, 0.5, 0.3])

    def condition(self, depth):
        kind = self.random.choice(["is", "not", "and", "or"] if depth else ["is"])
        if kind == "is":
            name = self.random.choice(["p0", "p1", "p2"])
            return ("is", name, self.random.choice(list(self.sets[name])))
        count = 1 if kind == "not" else self.random.randint(2, 3)
        return (kind, *(self.condition(depth - 1) for _ in range(count)))

    def base(self) -> RuleBase:
        return RuleBase(
            {n: a for n, a in self.axes.items() if n.startswith("p")},
            {n: ConcludedQuantity(a) for n, a in self.axes.items() if n.startswith("q")},
            tuple(
                Rule(
                    self.tree(c),
                    tuple(Conclusion(q, self.word(q, w)) for q, w in to.items()),
                    k,
                )
                for c, to, k in self.rules
            ),
            self.operators,
        )

    def word(self, name, word):
        return Word(word, points(self.sets[name][word]).within(*self.axes[name].bounds))

    def tree(self, condition):
        kind, *rest = condition
        if kind == "is":
            return Is(rest[0], self.word(*rest))
        parts = tuple(map(self.tree, rest))
        return Not(*parts) if kind == "not" else {"and": And, "or": Or}[kind](parts)

    def counting(self, name, place):
        """Return where a place counts in gradual rules.

        The middle of an outer word counts as its inner end; its foot, and what lies beyond,
        stays, unless the other outer word begins there.
        """
        low, high = map(Fraction, self.axes[name].bounds)
        used = {w for c, *_ in self.rules for _, n, w in each_is(c) if n == name}
        sets = [tuple(Fraction(x) for x, _ in self.sets[name][w]) for w in used]
        left = max((s for s in sets if s[1] <= low < s[2]), key=lambda s: s[2:], default=None)
        right = min(
            (s for s in sets if s[1] < high <= s[2]), key=lambda s: (s[1], s[0]), default=None
        )
        left = left and (max(left[1], low), *left[2:])  # what lies outside is cut off
        right = right and (*right[:2], min(right[2], high))
        left = left if left and left[1] < min(left[2], high) else None
        right = right if right and max(right[0], low) < right[1] else None
        if (left[1] if left else low) >= (right[1] if right else high):
            return place
        known = {low: low, high: high}
        foot = [min(left[2], high) if left else low, max(right[0], low) if right else high]
        if foot[0] <= foot[1]:
            known |= {x: x for x in foot}
        if left:
            known[(left[0] + left[1]) / 2] = left[1]
        if right:
            known[(right[1] + right[2]) / 2] = right[1]
        if place in known:
            return known[place]
        a = max(x for x in known if x < place)
        b = min(x for x in known if x > place)
        return known[a] + (known[b] - known[a]) * (place - a) / (b - a)

    def exact(self, quantity, places):
        """Return the exact coordinate of a quantity, or None where no rule fires."""
        strongest, every = {}, []
        if self.operators.result == "gradual mean":
            places = {name: self.counting(name, place) for name, place in places.items()}
        for condition, conclusions, weight in self.rules:
            degree = Fraction(weight) * self.truth(condition, places)
            if quantity in conclusions and degree > 0:
                pairs = tuple(self.sets[quantity][conclusions[quantity]])
                strongest[pairs] = max(degree, strongest.get(pairs, 0))
                every.append((pairs, degree, self.gone(condition, places)))
        if not strongest:
            return None
        if self.operators.result == "gradual mean":
            return self.gradual(every, *map(Fraction, self.axes[quantity].bounds))
        terms = [(rational(pairs), degree) for pairs, degree in strongest.items()]
        if self.operators.result == "weighted mean":
            middles = [(pairs[1][0] + pairs[2][0]) / 2 for pairs, _ in terms]
            total = sum(d for _, d in terms)
            return sum(m * d for m, (_, d) in zip(middles, terms, strict=True)) / total
        low, high = map(Fraction, self.axes[quantity].bounds)
        return exact_centre(terms, low, high, self.operators.implication)

    def gradual(self, every, low, high):
        """Return the mean of middles that move on their way to the nearer end."""
        total = moment = Fraction(0)
        for pairs, degree, gone in every:
            middle = (Fraction(pairs[1][0]) + Fraction(pairs[2][0])) / 2
            side = (middle > (low + high) / 2) - (middle < (low + high) / 2)
            end = high if side > 0 else low
            total += degree
            moment += degree * (middle + abs(side) * gone * (end - middle))
        return moment / total

    def gone(self, condition, places):
        """Return the mean over all tests of how far facts are beyond what is fully true."""
        far = []
        for negated, name, word in each_is(condition):
            low, high = map(Fraction, self.axes[name].bounds)
            start, end = (Fraction(self.sets[name][word][k][0]) for k in (1, 2))
            place, share = places[name], Fraction(0)
            if not negated and start <= low and place < end:
                share = (end - place) / (end - low)
            elif not negated and end >= high and place > start:
                share = (place - start) / (high - start)
            far.append(share)
        return sum(far) / len(far)

    def truth(self, condition, places):
        kind, *rest = condition
        if kind == "is":
            return exact_degree(rational(self.sets[rest[0]][rest[1]]), places[rest[0]])
        truths = [self.truth(part, places) for part in rest]
        if kind == "not":
            return 1 - truths[0]
        if kind == "and":
            product = self.operators.conjunction == "product"
            return math.prod(truths) if product else min(truths)
        if self.operators.disjunction == "maximum":
            return max(truths)
        return 1 - math.prod(1 - t for t in truths)


@every("seed", range(60))
def test_a_generated_system_infers_the_rational_value(seed):
    system = System(seed)
    base = system.base()
    for _ in range(4):
        facts = {
            name: axis.from_scale(system.random.uniform(*axis.bounds))
            for name, axis in base.properties.items()
        }
        places = {n: Fraction(base.properties[n].to_scale(v)) for n, v in facts.items()}
        for name, result in base.infer(facts).items():
            exact = system.exact(name, places)
            if exact is None:
                assert isinstance(result, NoRule)
                continue
            assert not isinstance(result, NoRule)
            axis = system.axes[name]
            found = math.log(result.value) if axis.log else result.value
            low, high = axis.bounds
            assert abs(Fraction(found) - exact) <= PROMISE * Fraction(high - low)


def test_generated_systems_meet_what_they_are_meant_to_meet():
    systems = [System(seed) for seed in range(60)]
    edges = [
        shape
        for system in systems
        for scale in system.sets.values()
        for shape in scale.values()
        if shape[0][0] == shape[1][0] or shape[2][0] == shape[3][0]
    ]
    assert len(edges) > 30
    assert len({s.operators for s in systems}) >= 12
    assert sum(axis.log for s in systems for axis in s.axes.values()) > 30
