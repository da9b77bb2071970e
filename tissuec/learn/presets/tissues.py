"""The tissues of a preset as text: which numbers were learnt, how they and laws are written.

The first is the shortest and needs a file that can be used; the last needs no other file.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from msgspec import Struct, field

from tissuec.compiler.learning.laws import values_of, with_constants
from tissuec.core.fields import OneOf, Real, Several, Whole
from tissuec.core.names import key_of
from tissuec.core.prefixes import shown_units
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, NUMBER, Dimension, parse_unit, si_unit
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.lang.walk import names_in
from tissuec.lang.words import written_name
from tissuec.learn.fit.outcome import PARTS, Estimates, Learnt, interval, shown
from tissuec.learn.vocabulary.used import used_tissues
from tissuec.scene.model import AssignedQuantity, Body, PropertyFact, Scene, Tissue, WrittenLaw
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading.entries import Entry, entries_of
from tissuec.scene.tissues.laws import FORMS
from tissuec.scene.tissues.quantities import QUANTITIES

LEARNED = "learned"


class LearntNumber(Struct, frozen=True):
    """A number that was learnt, in SI units, with its interval."""

    value: float
    low: float
    high: float
    start: float
    identified: bool
    dimension: Dimension


class Draft(Struct):
    """A tissue that is to be written.

    Attributes:
        remark: Which part of a body it is for; empty where it is for all of its original.
        numbers: Quantities that were learnt, by name.
        constants: Constants of its laws that were learnt, by name.
    """

    name: str
    original: Tissue
    remark: str
    numbers: dict[str, LearntNumber] = field(default_factory=dict[str, LearntNumber])
    constants: dict[str, LearntNumber] = field(default_factory=dict[str, LearntNumber])

    def add(self, what: str, number: LearntNumber) -> None:
        """Enter a number that was learnt."""
        # A law has a stiffening, too.
        is_given = what in QUANTITIES and what in self.original.given
        (self.numbers if is_given else self.constants)[what] = number


def drafts_of(learnt: Learnt, scene: Scene) -> list[Draft]:
    """Return the tissues for which something was learnt, in the order of the entries.

    Where words moved, these are all tissues that are described in them and are used.
    """
    found: dict[tuple[str, str], Draft] = {}
    for estimates in learnt.estimates:
        if estimates.adjust.per == "tissue":
            original = scene.tissues[key_of(estimates.adjust.of)]
            draft = found.setdefault((key_of(original.name), ""), Draft("", original, ""))
            draft.add(estimates.adjust.what, number_of(estimates, 0))
    for estimates in learnt.estimates:
        if estimates.adjust.per == "region":
            _add_parts(found, estimates, scene)
    if learnt.words:
        for use in used_tissues(scene):
            found.setdefault((use.key, ""), Draft("", use.tissue, ""))
    _name_all(list(found.values()), learnt.fit_problem.name, scene)
    return list(found.values())


def number_of(estimates: Estimates, place: int) -> LearntNumber:
    """Return one of the numbers of an entry."""
    return LearntNumber(
        float(estimates.value[place]),
        float(estimates.low[place]),
        float(estimates.high[place]),
        float(estimates.start[place]),
        bool(estimates.identified[place]),
        estimates.adjust.dimension,
    )


def _add_parts(found: dict[tuple[str, str], Draft], estimates: Estimates, scene: Scene) -> None:
    """Enter numbers of the parts of a body, each on top of what its tissue learnt."""
    body = scene.bodies[key_of(estimates.adjust.of)]
    for place, part in enumerate(estimates.parts):
        name, tissue = _part(body, str(part))
        key = key_of(tissue.name), f"{key_of(body.name)}/{key_of(name)}"
        if key not in found:
            whole = found.get((key[0], ""))
            numbers = dict(whole.numbers) if whole else {}
            constants = dict(whole.constants) if whole else {}
            remark = f"{name} of {body.name}" if name else body.name
            found[key] = Draft(name or body.name, tissue, remark, numbers, constants)
        found[key].add(estimates.adjust.what, number_of(estimates, place))


def _part(body: Body, text: str) -> tuple[str, Tissue]:
    """Return the region that is meant, "" for the body itself, and its tissue."""
    name = text.removesuffix(f" of {body.name}")
    regions = {key_of(region.name): region for region in body.regions}
    region = regions.get(key_of(name))
    tissue = (region.tissue if region else None) or body.tissue
    assert tissue is not None, "a body without a tissue has nothing to adjust"
    return (region.name if region else ""), tissue


def _name_all(drafts: list[Draft], fit_problem: str, scene: Scene) -> None:
    """Give each draft a name that nothing else has.

    A single one is called like the fit problem, unless a tissue of the scene is called so.
    """
    taken: set[str] = set(scene.declarations.of("tissue")) | set(scene.tissues)
    for draft in drafts:
        wanted = _wanted(draft, fit_problem, alone=len(drafts) == 1)
        draft.name = next(name for name in wanted if key_of(name) not in taken)
        taken.add(key_of(draft.name))


def _wanted(draft: Draft, fit_problem: str, *, alone: bool) -> Iterator[str]:
    if alone:
        yield fit_problem
    base = draft.name or draft.original.name
    yield f"{LEARNED} {base}"
    if draft.remark and draft.name:
        yield f"{LEARNED} {draft.original.name} of {draft.remark}"
    number = 2
    while True:
        yield f"{LEARNED} {base} {number}"
        number += 1


LIKE, IN_WORDS, IN_NUMBERS = "like", "in words", "in numbers"
PRESET_FORMS = (LIKE, IN_WORDS, IN_NUMBERS)
WHOLE = "whole body"


class TissueWriter(Struct, frozen=True):
    """Writes tissues of one scene.

    Attributes:
        about: What every tissue says of itself, without quotes.
    """

    scene: Scene
    about: str

    def block(self, draft: Draft, form: str) -> list[str]:
        """Return the lines of a tissue."""
        parent = f" like {written_name(draft.original.name)}" if form == LIKE else ""
        lines = [f"# for {draft.remark}"] if draft.remark else []
        lines.append(f"tissue {written_name(draft.name)}{parent} {{")
        lines.append(f'about "{self.about}"')
        if form == IN_WORDS and draft.original.vocabulary:
            lines.append(f"described in {written_name(draft.original.vocabulary)}")
            lines += [self._fact(fact) for fact in draft.original.facts]
        elif form == IN_NUMBERS:
            lines += [f"# {fact.span.one_line}" for fact in draft.original.facts]
        lines += self._numbers(draft, form)
        lines += self._laws(draft, form)
        return [*lines, "}"]

    # --- entries ------------------------------------------------------------------------------

    def _fact(self, fact: PropertyFact) -> str:
        """Return the statement of a tissue on a property: its word, or a number."""
        scale = self.scene.vocabulary.properties[fact.property]
        if "=" in fact.span.text:
            return f"{written_name(fact.property)} = {exact(fact.number, scale.dimension)}"
        return fact.span.one_line

    def _numbers(self, draft: Draft, form: str) -> Iterator[str]:
        for name in self._written(draft, form):
            given = draft.original.given[name]
            if name in draft.numbers:
                yield _learnt_line(name, draft.numbers[name], given)
            elif given.spread == WHOLE:
                value = shown(given.value, given.quantity.dimension)
                yield f"# {name} of the whole body: {value}"
            else:
                yield _given_line(given)

    def _written(self, draft: Draft, form: str) -> Sequence[str]:
        """Return the names of the quantities that a form writes, in the order of the original.

        What rules say is written only where there are no rules.
        """
        given = draft.original.given
        if form == LIKE:
            return [name for name in given if name in draft.numbers]
        if form == IN_NUMBERS:
            return list(given)
        return [n for n, one in given.items() if one.how == "written" or n in draft.numbers]

    def _laws(self, draft: Draft, form: str) -> Iterator[str]:
        for word, law in draft.original.written_laws.items():
            changed = changed_constants(law, draft.constants)
            if form == LIKE and not changed:
                continue
            if law.law is not None and changed:
                values = {name: number.value for name, number in changed.items()}
                law = with_constants(word, law, values, self.scene)
            text = law_text(word, law, changed, self.scene.constants)
            remarks = [f"{name}: {remark(number)}" for name, number in changed.items()]
            yield f"{text}  # {'; '.join(remarks)}" if remarks else text


def remark(number: LearntNumber, what: str = "") -> str:
    """Return the comment after a learnt number: its interval, and its former value."""
    known = f"95 %: {interval(number.low, number.high, number.dimension, what)}"
    if not number.identified:
        known = "not identified by the data"
    return f"{known}; before: {shown(number.start, number.dimension, what)}"


def _learnt_line(name: str, number: LearntNumber, given: AssignedQuantity) -> str:
    if given.spread == WHOLE:
        return (
            f"# {name} of the whole body: {shown(number.value, number.dimension, digits=6)}, "
            f"to be written in the body ({remark(number)})"
        )
    text = learnt(
        number.value, number.low, number.high, number.dimension, percent=name in PARTS
    )
    return f"{given.quantity.name} = {text}{_per(given)}  # {remark(number, name)}"


def _given_line(given: AssignedQuantity) -> str:
    name = given.quantity.name
    if given.value == given.quantity.none:
        return f"{name} is none"
    value = exact(given.value, given.quantity.dimension, percent=name in PARTS)
    return f"{name} = {value}{_per(given)}"


def _per(given: AssignedQuantity) -> str:
    """Return the length of springs that a number is for, if it is for one."""
    if given.length is None:
        return ""
    return f" per {exact(given.length, LENGTH)}"


def constants_in(law: WrittenLaw) -> set[str]:
    """Return the keys of what can be learnt of a law: its entries, and names in it."""
    entries = set[str]() if law.law is None else set(entries_of(type(law.law)))
    return entries | {name.key for name in names_in(values_of(_parsed(law)))}


def changed_constants(
    law: WrittenLaw, learned: Mapping[str, LearntNumber]
) -> dict[str, LearntNumber]:
    """Return those of the learnt constants that belong to a law."""
    own = constants_in(law)
    return {name: number for name, number in learned.items() if s.key_of(name) in own}


def law_text(
    word: str, law: WrittenLaw, learned: Mapping[str, LearntNumber], constants: Constants
) -> str:
    """Return the entry of a tissue that writes a law, with its learnt constants.

    Args:
        word: "spring law", "viscosity law" or "solid law".
        constants: Values of the names in a formula.
    """
    if law.law is None:
        return _formula_text(law, learned, constants)
    numbers = dict(learned)
    if learned:  # an entry that is a param itself has the digits of that
        parsed, by_key = _parsed(law), {s.key_of(name): one for name, one in learned.items()}
        for item in parsed.items if isinstance(parsed, s.Block) else ():
            match item:
                case s.Assign(name=entry, value=s.Name(key=key)) if key in by_key:
                    numbers[entry.key] = by_key[key]
                case _:
                    pass
    entries = [
        f"{entry.name} {_entry_text(entry, getattr(law.law, entry.field), numbers)}"
        for entry in entries_of(type(law.law)).values()
    ]
    inner = f" {{ {'; '.join(entries)} }}" if entries else ""
    return f"{word} is {law.name}{inner}"


def _entry_text(entry: Entry, value: Any, learned: Mapping[str, LearntNumber]) -> str:
    """Return the text after the name of an entry."""
    match entry.kind:
        case Real(dimension=dimension):
            if entry.name in learned:
                return f"= {_learnt(learned[entry.name])}"
            return f"= {exact(value, dimension)}"
        case Several(dimension=dimension):
            return f"= [{', '.join(exact(one, dimension) for one in value)}]"
        case Whole():
            return f"= {value}"
        case OneOf():
            return f"is {value}"
        case _:
            raise TypeError(f"a law with an entry of {entry.kind} cannot be written")


def _learnt(number: LearntNumber) -> str:
    return learnt(number.value, number.low, number.high, number.dimension)


def _formula_text(
    law: WrittenLaw, learned: Mapping[str, LearntNumber], constants: Constants
) -> str:
    """Return a free formula in which every name that is no variable is a number."""
    function = _parsed(law)
    assert isinstance(function, s.Function)
    own = FORMS[function.name.key].variables(function)
    by_key = {s.key_of(name): number for name, number in learned.items()}
    text = function.span.source.text
    end = function.span.end
    pieces: list[str] = []
    for name in sorted(names_in(function.value), key=lambda name: -name.span.start):
        if name.key in own:
            continue
        value = constants.name(name)
        number = by_key.get(name.key)
        if number is None:
            shown = exact(float(value.amount), value.dimension)
        else:
            shown = _learnt(replace(number, dimension=value.dimension))
        pieces += [text[name.span.end : end], f"({shown})"]
        end = name.span.start
    return text[function.span.start : end] + "".join(reversed(pieces))


def _parsed(law: WrittenLaw) -> s.Item:
    """Return the syntax of a law, read again from its own text."""
    return parse(Source(law.span.source.name, law.span.text), has_heading=False).items[0]


LEAST = 6  # significant digits of what was learnt
BEYOND = 2  # digits after the first one in which the interval is seen
MOST = 17  # this many distinguish every number from the next
_PERCENT = (0.01, "%")


def learnt(
    value: float, low: float, high: float, dimension: Dimension, *, percent: bool = False
) -> str:
    """Return a learnt value with its unit, and with as many digits as its interval needs."""
    factor, unit = _scale(value, dimension, percent=percent)
    return f"{_plain(value / factor, digits(value, low, high))} {unit}".rstrip()


def _plain(value: float, count: int) -> str:
    """Return a number with so many significant digits, without an exponent where it can be."""
    return repr(float(f"{value:.{count}g}")).removesuffix(".0")


def digits(value: float, low: float, high: float) -> int:
    """Return how many significant digits a value needs for its interval to be resolved."""
    half = (high - low) / 2.0
    if value == 0.0 or not math.isfinite(half) or half <= 0.0:
        return LEAST
    needed = math.ceil(math.log10(max(abs(value) / half, 1.0))) + BEYOND
    return min(max(needed, LEAST), MOST)


def exact(value: float, dimension: Dimension, *, percent: bool = False) -> str:
    """Return the shortest text that is read as exactly this value, which is finite.

    Where no number of another unit is exactly this one, it is in SI units.
    """
    for amount, factor, unit in _spellings(value, dimension, percent=percent):
        if float(amount) * factor == value:
            return f"{amount} {unit}".rstrip()
    return f"{value!r} {si_unit(dimension)}".rstrip()


def _spellings(
    value: float, dimension: Dimension, *, percent: bool
) -> Iterator[tuple[str, float, str]]:
    factor, unit = _scale(value, dimension, percent=percent)
    for count in range(1, MOST + 1):
        yield _plain(value / factor, count), factor, unit


def _scale(value: float, dimension: Dimension, *, percent: bool) -> tuple[float, str]:
    """Return the unit in which a value is easiest to read, and what it is in SI."""
    if percent and dimension == NUMBER:
        return _PERCENT
    known = shown_units(si_unit(dimension))
    chosen = ([one for one in known if one.size <= abs(value)] or known[:1])[-1]
    factor = parse_unit(chosen.unit).factor if chosen.unit else 1.0
    return factor, chosen.unit  # as texts are read: not exactly 1e-12 for ng
