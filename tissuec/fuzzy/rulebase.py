"""Rule bases: from facts about properties to numbers for quantities, with reasons.

Inference is that of E. H. Mamdani and S. Assilian (Int. J. Man-Mach. Stud. 7:1, 1975). A rule
fires with the degree of its condition times its weight. A rule speaks only if every property it
names has a fact, whatever the other facts say; the properties it misses are reported. Rules
that conclude the same set count once, with the largest degree; in a gradual mean each counts.
On a quantity of which no rule holds to more than a negligible degree, no rule speaks.
"""

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Literal

from msgspec import Struct, field
from msgspec.structs import force_setattr

from tissuec.fuzzy.centroid import (
    Saying,
    Stretching,
    centre_of_gravity,
    gradual_mean,
    progress,
    stretched,
    stretching,
    unstretched,
    weighted_mean,
)
from tissuec.fuzzy.duals import fsum, snapped
from tissuec.fuzzy.rules import ConcludedQuantity, Is, Operators, Rule, atoms, degree, negations
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import FAINTEST, NEGLIGIBLE, AnyShape, Powered, Shape


class AtomDegree(Struct, frozen=True):
    """Degree of one ``is`` of a condition; None where its property has no fact.

    Attributes:
        negated: Whether the condition tests the opposite, of degree 1 less this one.
    """

    property: str
    word: str
    degree: float | None
    negated: bool = False


class Firing(Struct, frozen=True):
    """One rule as it bears on one quantity.

    Attributes:
        rule: Index of the rule in its rule base.
        degree: Degree of the condition times the weight of the rule; 0 if facts are missing.
        word: The word the rule concludes.
        atoms: Every ``is`` of the condition in written order.
        missing: Properties of the condition without a fact, in written order.
        progress: In a gradual mean, how far its facts have gone beyond where outer words are
            fully true, 0 to 1; otherwise 0.
    """

    rule: int
    degree: float
    word: str
    atoms: tuple[AtomDegree, ...]
    missing: tuple[str, ...] = ()
    progress: float = 0.0


class Inference(Struct, frozen=True):
    """The number found for a quantity.

    Attributes:
        value: The number, in the unit of the quantity (on a log scale: not its logarithm).
        source: "rules", or "otherwise" where no rule fired.
        fired: The rules that fired, in written order.
        silent: The rules on this quantity that did not fire.
    """

    value: float
    source: Literal["rules", "otherwise"]
    fired: tuple[Firing, ...]
    silent: tuple[Firing, ...]


class NoRule(Struct, frozen=True):
    """No rule fired for a quantity that declares no ``otherwise``.

    Attributes:
        silent: Every rule on this quantity, with the degrees that kept it from firing.
    """

    silent: tuple[Firing, ...]

    @property
    def missing(self) -> tuple[str, ...]:
        """Return the properties without a fact that kept rules from firing."""
        return tuple(dict.fromkeys(name for firing in self.silent for name in firing.missing))


class _Bearing(Struct, frozen=True):
    """A rule as it bears on one quantity."""

    rule: int
    word: str
    shape: Shape


class _Verdict(Struct, frozen=True):
    """What one rule says about the facts, for all its conclusions.

    Attributes:
        degree: Of the condition, times the weight of the rule.
        holds: Whether the degree of the condition by itself is more than negligible.
    """

    degree: float
    atoms: tuple[AtomDegree, ...]
    missing: tuple[str, ...]
    progress: float = 0.0
    holds: bool = False


class RuleBase(Struct, frozen=True, dict=True):
    """Properties, quantities and the rules between them.

    Attributes:
        properties: Range of each property.
        quantities: Range and fallback of each quantity.
        rules: The rules; results refer to them by index.
        operators: What the rules' joining words mean, and how sets become a number.

    Raises:
        ValueError: A rule names an unknown property or quantity, or concludes a powered set.
    """

    properties: Mapping[str, Axis]
    quantities: Mapping[str, ConcludedQuantity]
    rules: tuple[Rule, ...]
    operators: Operators = field(default_factory=Operators)

    def __post_init__(self) -> None:
        force_setattr(self, "properties", MappingProxyType(dict(self.properties)))
        force_setattr(self, "quantities", MappingProxyType(dict(self.quantities)))
        _ = self._corners, self._bearings  # raise ValueError if a rule is wrong

    @cached_property
    def _atoms(self) -> tuple[tuple[Is, ...], ...]:
        return tuple(tuple(atoms(rule.condition)) for rule in self.rules)

    @cached_property
    def asked(self) -> frozenset[str]:
        """Return the properties that conditions of rules use."""
        return frozenset(part.property for parts in self._atoms for part in parts)

    @cached_property
    def _corners(self) -> Mapping[str, list[float]]:
        return _corners(self.properties, self._atoms)

    @cached_property
    def _stretchings(self) -> Mapping[str, Stretching]:
        """Return how facts are stretched; nothing is outside of gradual rules."""
        if not self._is_gradual:
            return dict.fromkeys(self.properties, ())
        shapes: dict[str, list[AnyShape]] = {name: [] for name in self.properties}
        for part in (part for parts in self._atoms for part in parts):
            shapes[part.property].append(part.word.shape)
        return {name: stretching(shapes[name], axis) for name, axis in self.properties.items()}

    @cached_property
    def _bearings(self) -> Mapping[str, list[_Bearing]]:
        return _bearings(self.quantities, self.rules)

    def __reduce__(self) -> tuple[type["RuleBase"], tuple[object, ...]]:
        axes, quantities = dict(self.properties), dict(self.quantities)
        return RuleBase, (axes, quantities, self.rules, self.operators)

    def infer(self, facts: Mapping[str, float]) -> dict[str, Inference | NoRule]:
        """Return the conclusions of the rules about every quantity.

        Args:
            facts: Values of properties, in their own units; properties may be left out.

        Raises:
            OutOfRange: A fact lies outside the range of its property; nothing is clipped.
            ValueError: A fact is about something that is no property.
        """
        verdicts = self._verdicts(facts, range(len(self.rules)))
        return {name: self._conclude(name, verdicts) for name in self.quantities}

    def conclude(self, quantity: str, facts: Mapping[str, float]) -> Inference | NoRule:
        """Return the conclusions of the rules about one quantity; see ``infer``."""
        rules = {bearing.rule for bearing in self._bearings[quantity]}
        return self._conclude(quantity, self._verdicts(facts, rules))

    def value_at(self, name: str, place: float) -> float:
        """Return the value of a property that counts at a coordinate of its sets."""
        return self.properties[name].from_scale(unstretched(place, self._stretchings[name]))

    def _verdicts(
        self, facts: Mapping[str, float], rules: Iterable[int]
    ) -> dict[int, _Verdict]:
        places = {name: self._place(name, value) for name, value in facts.items()}
        return {number: self._verdict(number, places) for number in rules}

    def _place(self, name: str, value: float) -> float:
        """Return where a fact counts; one that is a corner up to rounding is the corner.

        Otherwise "medium" given as a fact could wake the words beside it, at a degree of 1e-16.
        """
        if name not in self.properties:
            raise ValueError(f'"{name}" is not a property of these rules')
        axis = self.properties[name]
        place = axis.to_scale(value)
        anchors, corners = self._stretchings[name], self._corners[name]
        at_word = [counts for x, counts in anchors if abs(x - place) <= axis.rounding]
        place = stretched(place, anchors)
        if at_word:
            return snapped(at_word[0], place)
        i = bisect_left(corners, place)
        for corner in corners[max(i - 1, 0) : i + 1]:
            if abs(corner - place) <= axis.rounding:
                return snapped(corner, place)
        return place

    def _verdict(self, number: int, places: Mapping[str, float]) -> _Verdict:
        rule, parts = self.rules[number], self._atoms[number]
        degrees = [
            part.word.shape.degree(places[part.property]) if part.property in places else None
            for part in parts
        ]
        told = tuple(
            AtomDegree(part.property, part.word.text, d, is_not)
            for part, d, is_not in zip(parts, degrees, negations(rule.condition), strict=True)
        )
        known = [d for d in degrees if d is not None]
        if len(known) < len(degrees):
            return _Verdict(0.0, told, _unique(a.property for a in told if a.degree is None))
        truth = degree(rule.condition, iter(known), self.operators)
        strength = rule.weight * truth
        far = self._progress(number, places) if self._is_gradual else 0.0
        return _Verdict(
            strength if strength >= FAINTEST else 0.0, told, (), far, truth >= NEGLIGIBLE
        )

    @property
    def _is_gradual(self) -> bool:
        return self.operators.result == "gradual mean"

    def _progress(self, number: int, places: Mapping[str, float]) -> float:
        """Return how far facts have gone beyond outer words, on average over a condition."""
        rule, parts = self.rules[number], self._atoms[number]
        gone = [
            progress(part.word.shape, places[part.property], self.properties[part.property])
            for part, is_not in zip(parts, negations(rule.condition), strict=True)
            if not is_not
        ]
        return fsum(gone) / len(parts)

    def _conclude(self, name: str, verdicts: Mapping[int, _Verdict]) -> Inference | NoRule:
        fired: list[Firing] = []
        silent: list[Firing] = []
        sayings: list[Saying] = []
        bearings = self._bearings[name]
        is_spoken = any(verdicts[bearing.rule].holds for bearing in bearings)
        for bearing in bearings:
            said = verdicts[bearing.rule]
            firing = Firing(
                bearing.rule, said.degree, bearing.word, said.atoms, said.missing, said.progress
            )
            if is_spoken and said.degree > 0.0:
                fired.append(firing)
                sayings.append((bearing.shape, said.degree, said.progress))
            else:
                silent.append(firing)
        quantity = self.quantities[name]
        if sayings:
            value = self._value(sayings, quantity.axis)
            return Inference(value, "rules", tuple(fired), tuple(silent))
        if quantity.otherwise is not None:
            value = quantity.axis.value_of(quantity.otherwise.shape)
            return Inference(value, "otherwise", (), tuple(silent))
        return NoRule(tuple(silent))

    def _value(self, sayings: Sequence[Saying], axis: Axis) -> float:
        if self._is_gradual:
            return axis.from_scale(gradual_mean(sayings, axis))
        strongest: dict[AnyShape, float] = {}
        for shape, strength, _ in sayings:
            strongest[shape] = max(strength, strongest.get(shape, 0.0))
        terms = list(strongest.items())
        low, high = axis.bounds
        if self.operators.result == "weighted mean":
            return axis.from_scale(weighted_mean(terms, low, high))
        implication = self.operators.implication
        return axis.from_scale(centre_of_gravity(terms, low, high, implication=implication))


def _corners(
    properties: Mapping[str, Axis], conditions: Iterable[Iterable[Is]]
) -> dict[str, list[float]]:
    """Return the corners of all sets that conditions use, ascending, for each property."""
    corners: dict[str, set[float]] = {name: set() for name in properties}
    for condition in conditions:
        for part in condition:
            if part.property not in corners:
                raise ValueError(f'"{part.property}" is not a property of these rules')
            corners[part.property].update(part.word.shape.corners)
    return {name: sorted(places) for name, places in corners.items()}


def _bearings(
    quantities: Mapping[str, ConcludedQuantity], rules: Iterable[Rule]
) -> dict[str, list[_Bearing]]:
    """Return the conclusions on each quantity, with sets that span its range exactly."""
    bearings: dict[str, list[_Bearing]] = {name: [] for name in quantities}
    for number, rule in enumerate(rules):
        for conclusion in rule.conclusions:
            name, word = conclusion.quantity, conclusion.word
            if name not in quantities:
                raise ValueError(f'"{name}" is not a quantity of these rules')
            if isinstance(word.shape, Powered):
                raise ValueError(
                    f'"{name} is {word.text}": a power hedge is not allowed in a conclusion'
                )
            shape = word.shape.within(*quantities[name].axis.bounds)
            bearings[name].append(_Bearing(number, word.text, shape))
    return bearings


def _unique(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))
