"""The words of the language by the block in which they occur, from tables of the compiler.

A term has a sentence about it for hovering, and knows what follows it, for completion.
"""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import NamedTuple, TypeAlias

from msgspec import Struct
from msgspec.structs import replace

from tissuec.compiler.learn_expectations import ALL, ERROR, HELD_OUT
from tissuec.compiler.profiles import PROFILES
from tissuec.core.fields import FileIn, FromTo, Measure, OneOf, Point, Several
from tissuec.core.markdown import code, described, fenced, paragraphs, summary
from tissuec.core.units import LENGTH, NUMBER, PRESSURE, Dimension, describe, show
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.procedures import PROCEDURES
from tissuec.forces import FORCES
from tissuec.fuzzy.operators import CHOICES
from tissuec.geometry.surfaces import SURFACES
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.meshes.generators import MESHES
from tissuec.scene import meanings, settings
from tissuec.scene.bodies import AXIAL, BENDING, BODY_ENTRIES, CIRCUMFERENTIAL, ELASTIC
from tissuec.scene.declarations import TOP_LEVEL
from tissuec.scene.entries import default_in_words, form_of, kind_in_words
from tissuec.scene.expressions import FUNCTIONS
from tissuec.scene.joints import JOINT_ENTRIES
from tissuec.scene.laws import FORMS, LAW_KINDS
from tissuec.scene.learn_entries import (
    ADJUSTED,
    DIMENSIONS,
    DIVIDED,
    METHODS,
    SENTENCES,
    learn_schema,
)
from tissuec.scene.parameters import CONSTANTS
from tissuec.scene.quantities import KNOWABLE, QUANTITIES
from tissuec.scene.scales import SHAPES
from tissuec.scene.schema import Entry, entries_of
from tissuec.scene.words import DIRECTIONS
from tissuec.script.fit_problem import POSITIONS, WORDS
from tissuec.script.measures import MEASURES
from tissuec.script.plan import AUTOMATIC, RELAXATION
from tissuec.script.tools import INSTRUMENTS
from tissuec.script.verbs import VERBS
from tissuec.script.verbs.preserve import FIRMNESS
from tissuec.script.verbs.tie import KNOTS

PART, ENTRY, VERB, MEASURE, CHOICE, KEYWORD, VARIABLE = (
    "part", "entry", "verb", "measure", "word", "keyword", "variable",
)  # fmt: skip


#: What completion writes before a text in quotes.
IN_QUOTES = ' "'


class Term(Struct, frozen=True):
    """A word of the language, which may be several words of English.

    Attributes:
        kind: What it is coloured as.
        about: Markdown.
        form: How it is written, with what comes behind it.
        behind: What completion writes behind it.
        dimension: Of the number that it takes or gives, if any.
        choices: What can stand behind its ``is``.
    """

    label: str
    kind: str
    about: str = ""
    form: str = ""
    behind: str = ""
    dimension: Dimension | None = None
    choices: "Terms | None" = None


Terms: TypeAlias = Mapping[str, Term]


class Block(NamedTuple):
    """The kind of a block: "mesh" and "tube", "script" and ""; empty outside of all."""

    kind: str = ""
    member: str = ""


def _by_label(terms: Iterable[Term]) -> Terms:
    """Return terms by what they are looked up as: "young's modulus"."""
    return {term.label.lower(): term for term in terms}


def plain(kind: str, labels: Iterable[str], about: str = "") -> Terms:
    """Return terms with the same description.

    Args:
        kind: Kind of the terms.
        labels: Their names.
        about: The description.
    """
    return _by_label(Term(label, kind, about) for label in labels)


def members(family: Mapping[str, type], kind: str = CHOICE) -> Terms:
    """Return the members of a family, described by their docstrings."""
    return _by_label(Term(name, kind, described(member)) for name, member in family.items())


# --- entries ----------------------------------------------------------------------------------


def _entry(entry: Entry, choices: Terms | None = None) -> Term:
    """Return an entry of a schema."""
    rest = default_in_words(entry)
    facts = kind_in_words(entry.kind) + (
        f"; without it {rest}" if rest != "needed" and rest else ""
    )
    behind, dimension = " = ", None
    match entry.kind:
        case OneOf(words=words):
            behind, choices = " is ", choices or plain(CHOICE, words)
        case FromTo(dimension=dimension):
            behind = " from "
        case FileIn(dimension=dimension):
            behind = IN_QUOTES
        case (
            Measure(dimension=dimension)
            | Point(dimension=dimension)
            | Several(dimension=dimension)
        ):
            pass
        case _:
            pass
    about = f"{entry.about[:1].upper()}{entry.about[1:]}\n\n{facts}"
    return Term(entry.name, ENTRY, about, form_of(entry), behind, dimension, choices)


def _entries(cls: type) -> dict[str, Term]:
    return {name: _entry(entry) for name, entry in entries_of(cls).items()}


def _meant(block: str, behind: Mapping[str, str], **choices: Terms) -> dict[str, Term]:
    """Return the entries of a block that no schema describes."""
    return {
        name: Term(name, ENTRY, about, "", behind.get(name, " is "), None, choices.get(name))
        for name, about in meanings.ENTRIES[block].items()
    }


@cache
def entries(block: Block) -> Terms:
    """Return the first words of statements of a block, without names of the text."""
    match block:
        case Block("tissue" | "law" | "region" | "interface" | "springs"):
            return _of_material(block.kind)
        case Block("body"):
            own = _meant(
                "body",
                {"region": " ", "springs": " where "},
                mesh=meshes(),
                rupture=_rupture(),
                bending=_bending(),
                fibres=_fibres(),
            )
            found = own | {name: _entry(entry) for name, entry in BODY_ENTRIES.items()}
            # It goes on with "is", or between two regions with "from".
            return found | {"interface": replace(found["interface"], behind=" ")}
        case Block("joint"):
            own = _meant("joint", {"springs": " from "}, rupture=_rupture())
            return own | {name: _entry(entry) for name, entry in JOINT_ENTRIES.items()}
        case Block("tool", kind):
            own = _meant("tool", {}, kind=members(INSTRUMENTS))
            return own | _of_kind(INSTRUMENTS, kind)
        case Block("force", kind):
            own = _meant("force", {"acts": " on "}, kind=members(FORCES))
            return own | _of_kind(FORCES, kind)
        case Block("surface", kind):
            return _meant("surface", {}, kind=members(SURFACES)) | _of_kind(SURFACES, kind)
        case Block("mesh", kind):
            return _of_kind(MESHES, kind)
        case Block("spring law" | "viscosity law", kind):
            family = SPRING_LAWS if block.kind == "spring law" else VISCOSITY_LAWS
            return _of_kind(family, kind)
        case Block("environment"):
            return _entries(settings.EnvironmentEntries)
        case Block("simulate"):
            schema = settings.simulate_schema()
            return {
                name: _entry(entry, integrators() if name == "integrator" else None)
                for name, entry in schema.items()
            }
        case Block("integrator", kind):
            return _of_kind(PROCEDURES, kind)
        case Block("property" | "quantity"):
            found = _meant("scale", {"evenly": " = [", "applies": " to "})
            return found if block.kind == "quantity" else {"evenly": found["evenly"]}
        case Block("rules"):
            chosen = {name: plain(CHOICE, words) for name, words in CHOICES.items()}
            return _meant("rules", {"if": " "}, **chosen)
        case Block("output"):
            return _of_output()
        case Block("learn"):
            return _of_learning()
        case _:
            return {}


def _of_kind(family: Mapping[str, type], kind: str) -> dict[str, Term]:
    """Return the entries of one member; of all where it is not known which."""
    known = [family[kind]] if kind in family else family.values()
    return {name: term for member in known for name, term in _entries_if_any(member).items()}


def _entries_if_any(member: type) -> dict[str, Term]:
    try:
        return _entries(member)
    except TypeError:  # an explicit mesh stands in tables
        return {}


def _of_material(kind: str) -> Terms:
    quantities = {
        name: Term(
            quantity.name, ENTRY,
            f"{describe(quantity.dimension)}, of {' or '.join(quantity.spreads)}",
            f"{quantity.name} = …", " = ", quantity.dimension,
            None if quantity.none is None else plain(CHOICE, ["none"], "No limit."),
        )
        for name, quantity in QUANTITIES.items()
    }  # fmt: skip
    laws: dict[str, Terms] = {kind.word: members(kind.family) for kind in LAW_KINDS}
    forms = {name: f"{form.heads[0].removeprefix(name)} = " for name, form in FORMS.items()}
    if kind in ("region", "interface", "springs"):
        own = _meant(kind, {"prestress": " = "})
        return own | {"prestress": quantities["prestress"]}
    own = _meant(
        "tissue", {"about": IN_QUOTES, "described": " in ", "known": " ", **forms}, **laws
    )
    if kind == "law":
        return {name: own[name] for name in (*laws, *forms)}
    return own | quantities


def _of_output() -> Terms:
    own = _meant("output", dict.fromkeys(("trajectory", "energy"), " every "))
    own["surface"] = Term("surface", ENTRY, own["surface"].about, "", " of ")
    own["precision"] = Term(
        "precision", ENTRY, own["precision"].about, "", " is ", None,
        plain(CHOICE, ["single", "double"]),
    )  # fmt: skip
    measured = {
        name: Term(
            name, MEASURE, term.about, "", " of " if MEASURES[name].subjects else " every "
        )
        for name, term in logged().items()
    }
    return measured | own


def _of_learning() -> Terms:
    """Return the entries of a learn block: sentences, and settings by their schema."""
    behind = dict.fromkeys(("data", "hold out", "against column", "write"), IN_QUOTES)
    behind |= {"fit": " = ", "time": " using ", "displacement": " of ", "revise rules": " of "}
    behind["against column"] = IN_QUOTES
    sentences: dict[str, Term] = {}
    for name, entry in SENTENCES.items():
        forms = fenced("\n".join(entry.forms), "tis")
        about = f"{forms}\n\n{paragraphs(entry.about)}"
        sentences[name] = Term(name, ENTRY, about, entry.forms[0], behind.get(name, " "))
    schema = learn_schema()
    settings_of = {name: _entry(entry) for name, entry in schema.items()}
    kind = schema["integrator"].kind
    assert isinstance(kind, OneOf)
    settings_of["integrator"] = _entry(
        schema["integrator"],
        {name: term for name, term in integrators().items() if name in kind.words},
    )
    dashed = {name: Term(f'"{name}"' if "-" in name else name, CHOICE) for name in METHODS}
    settings_of["method"] = _entry(schema["method"], dashed)
    return sentences | settings_of


def _rupture() -> Terms:
    return plain(CHOICE, ["allowed"], "Springs break above their breaking force.")


def _fibres() -> Terms:
    return _by_label(
        [
            Term(AXIAL, CHOICE, "along the axis of a tube"),
            Term(CIRCUMFERENTIAL, CHOICE, "around the axis of a tube"),
        ]
    )


def _bending() -> Terms:
    parts = [
        Term(word, CHOICE, f"{part:.0%} of the spring constant and viscosity of the tissue")
        for word, part in BENDING.items()
    ]
    return _by_label([*parts, Term(ELASTIC, CHOICE, "like a wall of its thickness")])


@cache
def meshes() -> Terms:
    """Return the meshes that there are."""
    found = _by_label(
        Term(name, CHOICE, described(mesh), "", "" if name == "explicit" else " { ")
        for name, mesh in MESHES.items()
    )
    return found


@cache
def integrators() -> Terms:
    """Return the methods that can be named."""
    automatic = Term(AUTOMATIC, CHOICE, "Chosen automatically; the run shows which and why.")
    relaxation = Term(RELAXATION, CHOICE, "Follows static equilibria without inertia.")
    named = (Term(name, CHOICE, summary(method)) for name, method in INTEGRATORS.items())
    return _by_label((automatic, *named, relaxation))


# --- the rest of the language -----------------------------------------------------------------


@cache
def parts() -> Terms:
    """Return what statements outside of all blocks begin with."""
    behind = {"use": IN_QUOTES, "about": IN_QUOTES}
    single = dict.fromkeys(("environment", "script", "simulate", "output"), " { ")
    return _by_label(
        Term(part, PART, meanings.PARTS[part], "", (behind | single).get(part, " "))
        for part in TOP_LEVEL
    )


@cache
def verbs() -> Terms:
    """Return the verbs of a script."""
    return _by_label(
        Term(
            name, VERB, f"{fenced(chr(10).join(verb.forms))}\n\n{described(verb)}",
            verb.forms[0], "" if verb.forms[0] == name else " ",
        )
        for name, verb in VERBS.items()
    )  # fmt: skip


@cache
def logged() -> Terms:
    """Return what can be measured, as outputs name it."""
    return {
        name: Term(
            name, MEASURE, f"{described(measure)}\n\n{describe(measure.dimension)}",
            measure.form, "(" if measure.subjects else "", measure.dimension,
        )
        for name, measure in MEASURES.items()
    }  # fmt: skip


@cache
def measures() -> Terms:
    """Return what can be measured, as it is written in conditions."""
    found = {name: term for name, term in logged().items() if name not in COUNTED}
    about = "Number of nodes, springs or pieces."
    counted = Term(
        "count", MEASURE, about, "count(nodes of A)", "(", MEASURES["nodes"].dimension
    )
    return found | {"count": counted}


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
    return _by_label([Term(ERROR, MEASURE, about, "error(held out)", "(", NUMBER)])


@cache
def adjusted() -> Terms:
    """Return what a learn block can adjust; constants of laws come last."""
    found = {
        name: Term(name, ENTRY, f"{describe(DIMENSIONS[name])}, to be learned", "", " of ")
        for name in ADJUSTED
        if name in DIMENSIONS
    }
    found[WORDS] = Term(WORDS, ENTRY, "The words of a quantity or property.", "", " of ")
    laws = (law for family in (SPRING_LAWS, VISCOSITY_LAWS) for law in family.values())
    constants = (name for law in laws for name in entries_of(law))
    about = "A constant of a law, to be learned."
    return {name: Term(name, ENTRY, about, "", " of ") for name in constants} | found


@cache
def adjusted_in_lists() -> Terms:
    """Return what a list of what is to be adjusted holds, where nothing says of what."""
    return {key: replace(term, behind="") for key, term in adjusted().items()}


@cache
def conditions(*, of_springs: bool | None = None, are_tests: bool = True) -> Terms:
    """Return what nodes and springs are chosen by.

    Args:
        of_springs: Whether to return that of springs or that of nodes; None for both.
        are_tests: Whether to return that which is a test, and no number, as well.
    """
    left_out = {None: (), False: ("length", "bending"), True: ("surface", "group")}[of_springs]
    left_out += () if are_tests else ("region", "group", "surface", "bending")
    return _by_label(
        Term(name, MEASURE, about, "", " is " if name in ("region", "group") else "")
        for name, about in meanings.CONDITIONS.items()
        if name not in left_out
    )


#: What free formulas are of, and what else stands in them, by what they are called.
FORMULAS: dict[str, Terms] = {
    called: _by_label(
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
    return _by_label((*called, *fixed))


@cache
def profiles() -> Terms:
    """Return the profiles of motions and forces in time."""
    return plain(CHOICE, PROFILES, "A time profile.")


@cache
def kinds_of_clause(verb: str, word: str) -> Terms:
    """Return the words of which one clause of one verb takes one."""
    match verb, word:
        case "tie", "with":
            return _by_label(
                Term(knot, CHOICE, f"Holds {part:.1%} of the breaking force of its thread.")
                for knot, part in KNOTS.items()
            )
        case "preserve", "with":
            return _by_label(
                Term(words, CHOICE, show(pressure, PRESSURE))
                for words, pressure in FIRMNESS.items()
            )
        case _:
            return {}


SHAPE_TERMS = _by_label(
    Term(name, MEASURE, f"A word defined by its shape: {code(name + form)}.", name + form, "(")
    for name, form in SHAPES.items()
)
HEDGE_TERMS = _by_label(
    (
        Term("shift", MEASURE, "Moves a word along its scale.", "shift(50 %, outward)", "("),
        Term("power", MEASURE, "Raises degrees to a power; for conditions.", "power(2)", "("),
    )
)
DIRECTION_TERMS = plain(CHOICE, DIRECTIONS)
FREE_ZERO = plain(CHOICE, ["free zero"], "The data has an unknown constant offset.")
DIVISIONS = plain(CHOICE, DIVIDED, "Each has its own number.")
ERRORS_OF = plain(CHOICE, [HELD_OUT, ALL], "The data whose error is given.")
COLUMN = plain(
    ENTRY, ["column", "columns"], 'Columns of a table: column "force_N", columns "x y z".'
)
LOG_SCALE = plain(CHOICE, ["log scale"], "Use the logarithm of the values.")
CHOSEN_FROM = plain(CHOICE, ["nodes", "springs"])
COUNTED = plain(CHOICE, ["nodes", "springs", "pieces"])
RUN = plain(CHOICE, ["run"], "The whole run.")
COLUMNS = plain(ENTRY, ["columns"], 'The columns of the table: with columns "id x y z".')
SPREADS = plain(CHOICE, ["each spring", "each node", "whole body"])
KNOWN_TERMS = {
    key: Term(
        quantity.name, ENTRY, f"{describe(quantity.dimension)}, from a source",
        f'known {quantity.name} from … to … by "…"', " from ", quantity.dimension,
    )
    for key, quantity in KNOWABLE.items()
}  # fmt: skip
SOURCE_TERMS = _by_label(
    [Term("unverified", CHOICE, "The source was not checked.", "", IN_QUOTES)]
)
QUANTITY_TERMS = _by_label(
    Term(quantity.name, CHOICE, describe(quantity.dimension))
    for quantity in QUANTITIES.values()
)
