"""Words of the language: entries of blocks, verbs, measures, functions, words of clauses."""

from collections.abc import Iterable
from functools import cache

from tissuec.compiler.learning.expectations import ALL, HELD_OUT
from tissuec.compiler.measures.conditions import COUNT
from tissuec.compiler.script.profiles import PROFILES
from tissuec.compiler.selections import CRITERIA
from tissuec.core.fields import Real
from tissuec.core.markdown import code, described, fenced
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, NUMBER, PRESSURE, describe
from tissuec.forces.acting import FORCES
from tissuec.lang.words import RESERVED
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.laws.solid import SOLID_LAWS
from tissuec.lsp.terms import (
    CHOICE,
    ENTRY,
    IN_QUOTES,
    MEASURE,
    PART,
    VARIABLE,
    VERB,
    BlockKind,
    Term,
    Terms,
    by_label,
    plain,
)
from tissuec.scene.learning.entries import ADJUSTED, DIMENSIONS
from tissuec.scene.learning.errors import ERROR
from tissuec.scene.program.parameters import CONSTANTS
from tissuec.scene.reading import spellings
from tissuec.scene.reading.entries import (
    Entry,
    default_in_words,
    entries_of,
    entries_of_members,
    sentence,
    taken_in_words,
)
from tissuec.scene.reading.expressions import FUNCTIONS
from tissuec.scene.reading.parts import entries_in
from tissuec.scene.reading.parts import forms_of as part_forms
from tissuec.scene.reading.parts import parts as text_parts
from tissuec.scene.tissues.known_curves import MODES, RELAXATION, STRESS
from tissuec.scene.tissues.laws import FORMS
from tissuec.scene.tissues.quantities import KNOWABLE, QUANTITIES
from tissuec.scene.words.phrases import DIRECTIONS
from tissuec.scene.words.scales import SHAPES
from tissuec.script.fit_problem import POSITIONS, WEIGHTS, WORDS
from tissuec.script.forms import texts_of
from tissuec.script.measures import MEASURES
from tissuec.script.measures.cut_faces import CUT_FACES
from tissuec.script.measures.statistics import STATISTICS, form_of
from tissuec.script.verbs import VERBS


@cache
def parts() -> Terms:
    """Return the first words of statements outside of all blocks."""
    begins = {"text": IN_QUOTES, "single": " { "}
    return by_label(
        Term(word, PART, part.about, part_forms(word)[0], begins.get(part.sort, " "))
        for word, part in text_parts().items()
    )


@cache
def verbs() -> Terms:
    """Return the verbs of a script."""
    return by_label(
        Term(
            name, VERB, f"{fenced(chr(10).join(forms))}\n\n{described(verb)}",
            forms[0], "" if forms[0] == name else " ",
        )
        for name, verb in VERBS.items()
        if (forms := texts_of(name))
    )  # fmt: skip


@cache
def logged() -> Terms:
    """Return the measures, as outputs name them."""
    return {
        name: Term(
            name, MEASURE, f"{described(measure)}\n\n{describe(measure.dimension)}",
            measure.form, "(" if measure.subjects else "", measure.dimension,
        )
        for name, measure in MEASURES.items()
    }  # fmt: skip


@cache
def measures() -> Terms:
    """Return the measures, as conditions name them."""
    found = {name: term for name, term in logged().items() if name not in COUNTED}
    about = "Number of nodes, springs or pieces."
    counted = Term(
        "count", MEASURE, about, "count(nodes of A)", "(", MEASURES["nodes"].dimension
    )
    return found | {"count": counted} | statistics()


@cache
def statistics() -> Terms:
    """Return the statistics of fields."""
    return by_label(
        Term(name, MEASURE, f"Of a field over A: {about}.", form_of(name), "(")
        for name, about in STATISTICS.items()
    )


@cache
def fitted() -> Terms:
    """Return the measures that a learn block can compare with data."""
    about = "The positions of all nodes of a set."
    places = Term(POSITIONS, MEASURE, about, "positions(A)", "(", LENGTH)
    return {**measures(), POSITIONS: places}


@cache
def errors() -> Terms:
    """Return the errors about which learning can have expectations."""
    about = (
        "The difference between the scene and the measured data after learning, "
        "relative to the data."
    )
    return by_label([Term(ERROR, MEASURE, about, "error(held out)", "(", NUMBER)])


@cache
def adjusted() -> Terms:
    """Return the quantities that a learn block can adjust, with those of laws and forces."""
    found = {
        name: Term(name, ENTRY, f"{describe(DIMENSIONS[name])}, to be learned", "", " of ")
        for name in ADJUSTED
        if name in DIMENSIONS
    }
    found[WORDS] = Term(WORDS, ENTRY, "The words of a quantity or property.", "", " of ")
    found[WEIGHTS] = Term(WEIGHTS, ENTRY, "The weights of rules.", "", " of ")
    laws = (
        law for family in (SPRING_LAWS, VISCOSITY_LAWS, SOLID_LAWS) for law in family.values()
    )
    constants = (name for law in laws for name in entries_of(law))
    about = "A constant of a law, to be learned."
    found = {name: Term(name, ENTRY, about, "", " of ") for name in constants} | found
    about = "A number of a force, to be learned."
    return {name: Term(name, ENTRY, about, "", " of ") for name in numbers_of_forces()} | found


@cache
def numbers_of_forces() -> tuple[str, ...]:
    """Return the entries of forces that are numbers."""
    every = (entry for force in FORCES.values() for entry in entries_of(force).values())
    return tuple(dict.fromkeys(one.name for one in every if isinstance(one.kind, Real)))


@cache
def adjusted_in_lists() -> Terms:
    """Return the adjustable quantities as a list without "of" names them."""
    return {key: replace(term, behind="") for key, term in adjusted().items()}


@cache
def conditions(*, of_springs: bool | None = None, are_tests: bool = True) -> Terms:
    """Return the criteria by which nodes and springs are chosen.

    Args:
        of_springs: Whether to return the criteria of springs or those of nodes; None for both.
        are_tests: Whether to include the criteria that are tests rather than numbers.
    """
    other = {None: "none", False: "springs", True: "nodes"}[of_springs]
    return by_label(
        Term(name, MEASURE, one.about, one.form, " is " if one.form else "")
        for name, one in CRITERIA.items()
        if one.of != other and (are_tests or not one.is_test)
    )


@cache
def coordinates() -> Terms:
    """Return the coordinates of places in a body."""
    return {name: term for name, term in conditions().items() if name in ("x", "y", "z")}


#: Variables and other terms of free formulas, by the name of the formula.
FORMULAS: dict[str, Terms] = {
    called: by_label(
        Term(name, VARIABLE, f"Here {describe(dimension)}.", dimension=dimension)
        for name, dimension in (
            *form.arguments, *((name, of) for name, (_, of) in form.names.items())
        )
    )
    for called, form in FORMS.items()
}  # fmt: skip


#: What each of them is of, if it does not give those names of its own.
ARGUMENTS = {
    called: tuple(name for name, _ in form.arguments) for called, form in FORMS.items()
}


@cache
def functions() -> Terms:
    """Return mathematical functions and constants."""
    called = (Term(name, MEASURE, "A function.", f"{name}(…)", "(") for name in FUNCTIONS)
    fixed = (Term(name, MEASURE, f"{value:.10g}") for name, value in CONSTANTS.items())
    return by_label((*called, *fixed))


@cache
def profiles() -> Terms:
    """Return the profiles of motions and forces in time."""
    return plain(CHOICE, PROFILES, "A time profile.")


@cache
def fields() -> Terms:
    """Return the fields of which there are statistics."""
    from tissuec.compiler.measures.statistics import field_named, names_of_fields

    return by_label(
        Term(name, CHOICE, f"The {field_named(name).text}.", "", " of ")
        for name in names_of_fields()
    )


@cache
def frame_fields() -> Terms:
    """Return the fields that a trajectory can record."""
    from tissuec.results.fields import FIELDS

    return by_label(
        Term(name, CHOICE, f"The {field.text}.")
        for name, field in FIELDS.items()
        if not field.always
    )


SHAPE_TERMS = by_label(
    Term(name, MEASURE, f"A word defined by its shape: {code(name + form)}.", name + form, "(")
    for name, form in SHAPES.items()
)
HEDGE_TERMS = by_label(
    (
        Term("shift", MEASURE, "Moves a word along its scale.", "shift(50 %, outward)", "("),
        Term("power", MEASURE, "Raises degrees to a power; for conditions.", "power(2)", "("),
    )
)
DIRECTION_TERMS = plain(CHOICE, DIRECTIONS)
ERRORS_OF = plain(CHOICE, [HELD_OUT, ALL], "The data whose error is given.")
COLUMN = plain(
    ENTRY, ["column", "columns"], 'Columns of a table: column "force_N", columns "x y z".'
)
COUNTED = plain(CHOICE, spellings.COUNTED)
FACES = plain(CHOICE, [CUT_FACES], "Both faces of all cuts through a solid.")
KNOWN_TERMS: dict[str, Term] = {
    key: Term(
        quantity.name, ENTRY, f"{describe(quantity.dimension)}, from a source",
        f'known {quantity.name} from … to … by "…"', " from ", quantity.dimension,
    )
    for key, quantity in KNOWABLE.items()
} | dict(by_label([
    Term(
        STRESS, ENTRY, "Nominal stress over strain, with its scatter, from a source.",
        'known stress in tension at […] from […] to […] by "…"', " in ", PRESSURE,
    ),
    Term(
        RELAXATION, ENTRY, "The share of the stress that is left, over time, from a source.",
        'known relaxation at […] from […] to […] by "…"', " at ", NUMBER,
    ),
]))  # fmt: skip
MODE_TERMS = plain(CHOICE, MODES, "How the tissue is loaded.")
SOURCE_TERMS = by_label(
    [Term("unverified", CHOICE, "The source was not checked.", "", IN_QUOTES)]
)
QUANTITY_TERMS = by_label(
    Term(quantity.name, CHOICE, describe(quantity.dimension))
    for quantity in QUANTITIES.values()
)


@cache
def entries(block: BlockKind) -> Terms:
    """Return the first words of statements of a block, or of parts, without own names."""
    if not block.kind:
        return parts()
    found = {name: _term(entry) for name, entry in entries_in(*block).items()}
    return {**_measured(), **found} if block.kind == "output" else found


def _term(entry: Entry) -> Term:
    facts, rest = taken_in_words(entry), default_in_words(entry)
    if facts and rest and rest != "needed":
        facts = f"{facts}; without it {rest}"
    forms = fenced("\n".join(entry.forms), "tis") if entry.has_section else ""
    about = "\n\n".join(part for part in (forms, sentence(entry.about), facts) if part)
    begins = entry.begins or _begins(entry.name, entry.forms)
    return Term(
        entry.name, ENTRY, about, entry.forms[0], begins, entry.dimension, _choices(entry)
    )


def _begins(name: str, forms: Iterable[str]) -> str:
    """Return the text after the name in all forms; a quote, if any form has one."""
    rest = [form.removeprefix(name).split()[:1] for form in forms]
    first = {word for words in rest for word in words}
    if not all(rest):
        return ""
    if any(word.startswith('"') for word in first):
        return IN_QUOTES
    (word, *more) = first
    return f" {word} " if not more and (word == "=" or word in RESERVED) else " "


def _choices(entry: Entry) -> Terms | None:
    """Return the words that can be chosen, with their meanings."""
    return {word: _choice(word, about, entry) for word, about in entry.words.items()} or None


def _choice(word: str, about: object, entry: Entry) -> Term:
    members = entry.members
    own = entries_of_members(members, word) if word in members else {}
    needs_block = any(one.is_required for one in own.values())
    return Term(
        f'"{word}"' if "-" in word else word,
        CHOICE,
        about if isinstance(about, str) else described(about),
        behind=" { " if needs_block else "",
    )


def _measured() -> Terms:
    """Return the measures that an output can log."""
    found = {
        name: Term(name, MEASURE, term.about, "", "(" if MEASURES[name].subjects else " every ")
        for name, term in logged().items()
    }
    return {**found, COUNT: measures()[COUNT], **statistics()}
