"""The entries of each block as terms, from the schemas by which the compiler reads them."""

from collections.abc import Iterable, Mapping
from functools import cache

from msgspec.structs import replace

from tissuec.core.fields import FileIn, FromTo, Named, OneOf, Point, Real, Several
from tissuec.core.markdown import described, fenced, paragraphs, summary
from tissuec.core.units import describe
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.procedures import PROCEDURES
from tissuec.forces import FORCES
from tissuec.fuzzy.operators import CHOICES
from tissuec.geometry.surfaces import SURFACES
from tissuec.lang.words import RESERVED
from tissuec.lsp.terms import (
    CHOICE,
    ENTRY,
    IN_QUOTES,
    MEASURE,
    BlockKind,
    Term,
    Terms,
    by_label,
    members,
    plain,
)
from tissuec.lsp.vocabulary import logged, parts
from tissuec.meshes.generators import MESHES
from tissuec.scene import learn_entries, meanings, settings, study_entries
from tissuec.scene.bending import BENDING, ELASTIC
from tissuec.scene.block_sentences import Sentences
from tissuec.scene.body_entries import BODY_ENTRIES
from tissuec.scene.entries import default_in_words, form_of, kind_in_words
from tissuec.scene.fibres import AXIAL, CIRCUMFERENTIAL
from tissuec.scene.idle_words import CONCLUDED
from tissuec.scene.joints import JOINT_ENTRIES
from tissuec.scene.laws import BY_ENTRY, FORMS, LAW_KINDS
from tissuec.scene.learn_entries import METHODS, learn_schema
from tissuec.scene.quantities import QUANTITIES
from tissuec.scene.schema import Entry, entries_of
from tissuec.script.measures import MEASURES
from tissuec.script.plan import AUTOMATIC, EQUILIBRIUM, RELAXATION
from tissuec.script.tools import TOOLS


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
        case FileIn() | Named():
            behind = IN_QUOTES
        case (
            Real(dimension=dimension)
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
def entries(block: BlockKind) -> Terms:
    """Return the first words of statements of a block, or of parts, without own names."""
    match block:
        case BlockKind(""):
            return parts()
        case BlockKind("tissue" | "law" | "region" | "interface" | "springs"):
            return _of_material(block.kind)
        case BlockKind("body"):
            own = _meant(
                "body",
                {"made": " of ", "region": " ", "springs": " where ", "prestress": " along "},
                mesh=meshes(),
                rupture=_rupture(),
                bending=_bending(),
                fibres=_fibres(),
            )
            found = own | {name: _entry(entry) for name, entry in BODY_ENTRIES.items()}
            # It goes on with "is", or between two regions with "from".
            return found | {"interface": replace(found["interface"], behind=" ")}
        case BlockKind("joint"):
            own = _meant("joint", {"springs": " from "}, rupture=_rupture())
            return own | {name: _entry(entry) for name, entry in JOINT_ENTRIES.items()}
        case BlockKind("tool", kind):
            own = _meant("tool", {}, kind=members(TOOLS))
            return own | _of_kind(TOOLS, kind)
        case BlockKind("force", kind):
            own = _meant("force", {"acts": " on "}, kind=members(FORCES))
            return own | _of_kind(FORCES, kind)
        case BlockKind("surface", kind):
            return _meant("surface", {}, kind=members(SURFACES)) | _of_kind(SURFACES, kind)
        case BlockKind("mesh", kind):
            return _of_kind(MESHES, kind)
        case BlockKind("spring law" | "viscosity law" | "solid law", kind):
            return _of_kind(BY_ENTRY[block.kind].family, kind)
        case BlockKind("environment"):
            own = _meant("environment", {settings.SYMMETRIC: " through "})
            return own | _entries(settings.EnvironmentEntries)
        case BlockKind("simulate"):
            schema = settings.simulate_schema()
            return {
                name: _entry(entry, integrators() if name == "integrator" else None)
                for name, entry in schema.items()
            }
        case BlockKind("integrator", kind):
            return _of_kind(PROCEDURES, kind)
        case BlockKind("property" | "quantity"):
            found = _meant("scale", {"evenly": " = [", "applies": " to "})
            return found if block.kind == "quantity" else {"evenly": found["evenly"]}
        case BlockKind("rules"):
            chosen = {name: plain(CHOICE, words) for name, words in CHOICES.items()}
            return _meant("rules", {"if": " "}, **chosen)
        case BlockKind("output"):
            return _of_output()
        case BlockKind("learn"):
            return _of_learning()
        case BlockKind("study"):
            return _of_study()
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
    concluded = plain(CHOICE, [CONCLUDED], "What rules conclude, not the number of the parent.")
    no_limit = plain(CHOICE, ["none"], "No limit.")
    quantities = {
        name: Term(
            quantity.name, ENTRY,
            f"{describe(quantity.dimension)}, of {' or '.join(quantity.spreads)}",
            f"{quantity.name} = …", " = ", quantity.dimension,
            {**concluded, **({} if quantity.none is None else no_limit)},
        )
        for name, quantity in QUANTITIES.items()
    }  # fmt: skip
    laws: dict[str, Terms] = {kind.word: members(kind.family) for kind in LAW_KINDS}
    forms = {name: f"{form.heads[0].removeprefix(name)} = " for name, form in FORMS.items()}
    if kind in ("region", "interface", "springs"):
        own = _meant(kind, {"prestress": " = "})
        return own | {"prestress": quantities["prestress"]}
    own = _meant(
        "tissue",
        {
            "about": IN_QUOTES,
            "described": " in ",
            "known": " ",
            "colour": ' = "#',
            "gloss": " = ",
            **forms,
        },
        **laws,
    )
    if kind == "law":
        return {name: own[name] for name in (*laws, *forms)}
    return own | quantities


def _of_output() -> Terms:
    own = _meant("output", dict.fromkeys(("trajectory", "energy"), " every "))
    own["surface"] = Term("surface", ENTRY, own["surface"].about, "", " of ")
    for word in ("compress", "blocks"):
        own[word] = Term(word, ENTRY, own[word].about, word, "")
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
    schema = learn_schema()
    kind = schema["integrator"].kind
    assert isinstance(kind, OneOf)
    named = {name: term for name, term in integrators().items() if name in kind.words}
    dashed = {name: Term(f'"{name}"' if "-" in name else name, CHOICE) for name in METHODS}
    chosen = {"integrator": named, "method": dashed}
    settings_of = {name: _entry(entry, chosen.get(name)) for name, entry in schema.items()}
    return _sentences(learn_entries.SENTENCES) | settings_of


def _of_study() -> Terms:
    found = _sentences(study_entries.SENTENCES)
    designs = (Term(name, CHOICE, about) for name, about in study_entries.DESIGNS.items())
    found["design"] = replace(found["design"], choices=by_label(designs))
    return found | _entries(study_entries.StudySettings)


def _sentences(known: Mapping[str, Sentences]) -> dict[str, Term]:
    """Return the kinds of sentences of a block, from their forms."""
    return {
        name: Term(
            name, ENTRY, f"{fenced(chr(10).join(one.forms), 'tis')}\n\n{paragraphs(one.about)}",
            one.forms[0], _behind(name, one.forms), None, _chosen(one.forms),
        )
        for name, one in known.items()
    }  # fmt: skip


def _behind(name: str, forms: Iterable[str]) -> str:
    """Return what stands behind the first words of all forms; a quote, if any has one."""
    first = {form.removeprefix(name).split()[0] for form in forms}
    if any(word.startswith('"') for word in first):
        return IN_QUOTES
    (word, *more) = first
    return f" {word} " if not more and (word == "=" or word in RESERVED) else " "


def _chosen(forms: Iterable[str]) -> Terms | None:
    """Return the words that forms have behind "is"."""
    words = [form.partition(" is ")[2] for form in forms]
    return plain(CHOICE, words) if all(words) else None


def _rupture() -> Terms:
    return plain(CHOICE, ["allowed"], "Springs and elements break above their limits.")


def _fibres() -> Terms:
    return by_label(
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
    return by_label([*parts, Term(ELASTIC, CHOICE, "like a wall of its thickness")])


@cache
def meshes() -> Terms:
    """Return the meshes that there are."""
    found = by_label(
        Term(name, CHOICE, described(mesh), "", "" if name == "explicit" else " { ")
        for name, mesh in MESHES.items()
    )
    return found


@cache
def integrators() -> Terms:
    """Return the methods that can be named."""
    automatic = Term(AUTOMATIC, CHOICE, "Chosen automatically; the run shows which and why.")
    static = (
        Term(EQUILIBRIUM, CHOICE, "Statics: equilibria by Newton's method, without inertia."),
        Term(RELAXATION, CHOICE, "The published procedure without inertia: nodes are relaxed."),
    )
    named = (Term(name, CHOICE, summary(method)) for name, method in INTEGRATORS.items())
    return by_label((automatic, *named, *static))
