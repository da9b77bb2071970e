"""What the language consists of, as Markdown, part by part."""

from collections.abc import Iterable, Mapping
from math import isfinite

from tissuec.compiler.bodies.tables import LAW, NODE_COLUMNS, SPRING_COLUMNS
from tissuec.compiler.measures.statistics import field_named, names_of_fields
from tissuec.compiler.script.profiles import PROFILES
from tissuec.compiler.study.expectations import OVER_RUNS
from tissuec.core import units
from tissuec.core.markdown import code, described, fenced, summary, table
from tissuec.core.units import Dimension, describe, si_unit
from tissuec.engine.integrators import INTEGRATORS, Integrator
from tissuec.forces.acting import FORCES
from tissuec.geometry.surfaces import SURFACES
from tissuec.lang import words
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.meshes.generators import MESHES
from tissuec.results.fields import FIELDS
from tissuec.scene.bodies.block import EXPLICIT
from tissuec.scene.bodies.placement import PLACEMENT_ENTRIES
from tissuec.scene.learning.entries import (
    ADJUSTED,
    DIMENSIONS,
    PARTED,
    PLACED,
)
from tissuec.scene.program.parameters import CONSTANTS
from tissuec.scene.reading.entries import Entry, entries_of, entry_table
from tissuec.scene.reading.expressions import FUNCTIONS
from tissuec.scene.reading.parts import blocks
from tissuec.scene.reading.parts import parts as text_parts
from tissuec.scene.reading.spellings import AGGREGATES, form_over_time
from tissuec.scene.study.entries import DESIGNS, DISTRIBUTIONS
from tissuec.scene.tissues.quantities import QUANTITIES, TissueQuantity
from tissuec.script.forms import texts_of
from tissuec.script.measures import MEASURES
from tissuec.script.measures.needs import KINDS, meaning
from tissuec.script.measures.statistics import STATISTICS, form_of
from tissuec.script.procedures import PROCEDURES
from tissuec.script.tools import TOOLS
from tissuec.script.verbs import VERBS


def parts() -> dict[str, str]:
    """Return every generated part of the language reference by its name."""
    return {
        "parts": part_table(),
        "reserved words": reserved_words(),
        "units": unit_table(),
        "prefixes": prefix_table(),
        "dimensions": dimension_table(),
        "functions": f"Functions: {_listed(FUNCTIONS)} Constants: {_listed(CONSTANTS)}",
        "quantities": quantity_table(),
        "spring laws": joined(member_sections("spring law", SPRING_LAWS)),
        "viscosity laws": joined(member_sections("viscosity law", VISCOSITY_LAWS)),
        "placements": entry_table(PLACEMENT_ENTRIES),
        "node columns": column_table(NODE_COLUMNS),
        "spring columns": column_table(SPRING_COLUMNS),
        "forces": joined(member_sections("kind", FORCES, "###")),
        "procedures": procedure_sections(),
        "profiles": _listed(PROFILES),
        "surfaces": joined(member_sections("kind", SURFACES, "###")),
        "measures": measure_table(),
        "measures of bodies": meaning_table(),
        "statistics": table(
            ("statistic", "meaning"),
            [(code(form_of(name)), about) for name, about in STATISTICS.items()],
        ),
        "fields of statistics": statistics_table(),
        "frame fields": frame_field_table(),
        "integrators": integrator_table(),
        "adjusted": adjusted_table(),
        "study functions": study_functions(),
        "study designs": table(
            ("design", "how it combines values"),
            [(code(name), about) for name, about in DESIGNS.items()],
        ),
    }


def members() -> dict[str, dict[str, str]]:
    """Return the sections of members that have places of their own, by what a member is."""
    return {
        "mesh": mesh_sections(),
        "tool": member_sections("kind", TOOLS),
        "verb": verb_sections(),
    }


def block_parts() -> dict[str, str]:
    """Return the table and the sentences of each kind of block, which pages can show."""
    parts: dict[str, str] = {}
    for word, block in blocks().items():
        known = block.entries("")
        settings = {
            name: one
            for name, one in known.items()
            if name not in block.elsewhere and not one.has_section
        }
        parts[f"{word} entries"] = entry_table(settings)
        parts[f"{word} sentences"] = joined({
            name: sentence_section(one, word) for name, one in known.items() if one.has_section
        })  # fmt: skip
    return parts


def joined(sections: Mapping[str, str]) -> str:
    """Return sections one below the other."""
    return "\n\n".join(sections.values())


def _listed(names: Iterable[str]) -> str:
    return f"{', '.join(map(code, names))}."


def part_table() -> str:
    """Return what a text is made of."""
    rows = [(code(word), part.about) for word, part in text_parts().items()]
    return table(("part", "what it is"), rows)


def reserved_words() -> str:
    """Return the reserved words by what they are for."""
    groups = {
        "times": words.TIME_WORDS,
        "joining": words.JOINING_WORDS,
        "logic": words.LOGIC_WORDS,
        "beginning a sentence": words.DECLARING_WORDS,
    }
    rows = [(name, " ".join(map(code, group))) for name, group in groups.items()]
    continuing = " ".join(map(code, words.CONTINUING))
    return table(("for", "words"), rows) + (
        f"\n\nA line that begins with one of these continues the line above: {continuing}."
    )


def unit_table() -> str:
    """Return the units without prefixes, with what one of them is."""
    rows = [
        (code(symbol), _in_si(factor, dimension), describe(dimension), _mark(symbol))
        for symbol, (factor, dimension) in units.SYMBOLS.items()
        if _takes_prefix(symbol) or not _has_prefix(symbol)
    ]
    return table(("unit", "is", "measures", "prefixes"), rows)


def prefix_table() -> str:
    """Return the prefixes; micro has three spellings."""
    sizes: dict[float, list[str]] = {}
    for prefix, size in _prefixes().items():
        sizes.setdefault(size, []).append(code(prefix))
    rows = [(" or ".join(spellings), f"{size:g}") for size, spellings in sizes.items()]
    return table(("prefix", "factor"), rows)


def dimension_table() -> str:
    """Return what the compiler calls dimensions, and their SI units."""
    rows = [(name, code(unit) if unit else "") for name, unit in units.DIMENSION_NAMES.values()]
    return table(("dimension", "SI unit"), rows)


def _prefixes() -> dict[str, float]:
    """Return each prefix and its factor, as they stand before the unit of frequency."""
    return {
        symbol.removesuffix("Hz"): factor
        for symbol, (factor, _) in units.SYMBOLS.items()
        if symbol.endswith("Hz") and symbol != "Hz"
    }


def _takes_prefix(symbol: str) -> bool:
    return all(prefix + symbol in units.SYMBOLS for prefix in _prefixes())


def _has_prefix(symbol: str) -> bool:
    return symbol[:1] in _prefixes() and _takes_prefix(symbol[1:])


def _mark(symbol: str) -> str:
    return "yes" if _takes_prefix(symbol) else "no"


def _in_si(factor: float, dimension: Dimension) -> str:
    unit = units.si_unit(dimension)
    return (
        f"{factor:.6g}{unit[1:]}" if unit.startswith("1/") else f"{factor:.6g} {unit}".strip()
    )


def quantity_table() -> str:
    """Return the physical quantities of a tissue."""
    rows = [
        (
            code(q.name),
            describe(q.dimension),
            _spreads(q),
            "yes" if q.scales else "no",
            _rest(q),
        )
        for q in QUANTITIES.values()
        if not q.is_of_matter
    ]
    return table(("quantity", "is", "applies to", "per length", "without it"), rows)


def _spreads(quantity: TissueQuantity) -> str:
    return " or ".join(map(code, quantity.spreads))


def _rest(quantity: TissueQuantity) -> str:
    if quantity.default is None:
        return "an error"
    return code("none" if quantity.default == quantity.none else f"{quantity.default:g}")


def mesh_sections() -> dict[str, str]:
    """Return a section for each mesh."""
    sections = {
        name: f"## `mesh is {name}`\n\n{described(mesh)}" for name, mesh in MESHES.items()
    }
    for name in sections.keys() - {EXPLICIT}:
        sections[name] += f"\n\n{entry_table(entries_of(MESHES[name]))}"
    return sections


def member_sections(
    word: str, family: Mapping[str, type], heading: str = "##"
) -> dict[str, str]:
    """Return a section for each member of a family, which a scene chooses behind a word."""
    sections = {}
    for name, member in family.items():
        entries = entries_of(member)
        table_of = f"\n\n{entry_table(entries)}" if entries else ""
        sections[name] = f"{heading} `{word} is {name}`\n\n{described(member)}{table_of}"
    return sections


def procedure_sections() -> str:
    """Return a section for each published procedure with what can be chosen of it."""
    return "\n\n".join(
        f"## `integrator is {name}`\n\n{entry_table(entries_of(choices))}"
        for name, choices in PROCEDURES.items()
    )


def column_table(columns: Mapping[str, Dimension | None]) -> str:
    """Return the columns of a table of nodes or springs."""
    rows = [(code(name), _cells(name, dimension)) for name, dimension in columns.items()]
    return table(("column", "is"), rows)


def _cells(name: str, dimension: Dimension | None) -> str:
    """Return what the cells of a column hold."""
    if name == LAW:
        return "the name of a [law](laws.md)"
    return "a whole number" if dimension is None else describe(dimension)


def verb_sections() -> dict[str, str]:
    """Return a section for each verb."""
    return {
        name: f"## `{name}`\n\n{fenced(chr(10).join(texts_of(name)))}\n\n{described(verb)}"
        for name, verb in VERBS.items()
    }


def verb_table(pages: Mapping[str, str]) -> str:
    """Return all verbs with what they do; ``pages`` has the page of each, if not this one."""
    rows = [
        (f"[`{name}`]({pages.get(name, '')}#{name})", code(texts_of(name)[0]), summary(verb))
        for name, verb in VERBS.items()
    ]
    return table(("verb", "for example", "what it does"), rows)


def sentence_section(entry: Entry, block: str) -> str:
    """Return the section of a kind of sentence of a block."""
    forms, needed = fenced("\n".join(entry.forms)), " Needed." if entry.is_required else ""
    return f"## `{entry.name}` of `{block}`\n\n{forms}\n\n{entry.about}{needed}"


def study_functions() -> str:
    """Return the functions of a study, by the sentence in which they stand."""
    aggregates = {form_over_time(name): about for name, about in AGGREGATES.items()}
    distributions = dict.fromkeys(DISTRIBUTIONS.values(), "a distribution")
    over_runs = dict.fromkeys(OVER_RUNS.values(), "over all runs that have a value")
    rows = [
        (sentence, code(form), about)
        for sentence, forms in (
            (code("vary"), distributions),
            (code("measure"), aggregates),
            (code("expect"), over_runs),
        )
        for form, about in forms.items()
    ]
    return table(("sentence", "function", "meaning"), rows)


def adjusted_table() -> str:
    """Return what of tissues and what of nodes and springs can be adjusted."""
    rows = [
        (
            code(name),
            describe(DIMENSIONS[name]),
            "no" if name in PLACED else "yes",
            " or ".join(code(f"per {one}") for one in PARTED.get(name, ())),
        )
        for name in ADJUSTED
        if name in DIMENSIONS
    ]
    return table(("quantity", "is", "of a tissue", "of a set, body or region"), rows)


def measure_table() -> str:
    """Return what can be measured."""
    subjects = {"any": "nodes or springs"}
    rows = [
        (
            code(measure.form),
            describe(measure.dimension),
            subjects.get(measure.takes, measure.takes) if measure.subjects else "the scene",
            described(measure),
        )
        for measure in MEASURES.values()
    ]
    return table(("measure", "is", "taken of", "meaning"), rows)


def meaning_table() -> str:
    """Return the table of measures by kind of body."""
    rows: list[tuple[str, ...]] = []
    for measure in MEASURES.values():
        needs = getattr(measure, "needs", ())
        cells = [meaning(measure.takes, needs, kind) or "–" for kind in KINDS]
        if measure.subjects:
            rows.append((code(measure.form), *cells))
    return table(("measure", *KINDS.values()), rows)


def frame_field_table() -> str:
    """Return the table of the fields that frames contain besides positions and velocities."""
    rows = [
        (
            code(name),
            f"`[{si_unit(field.dimension)}]`",
            f"{field.text}. {field.remark}".removesuffix(" "),
            "always" if field.always else f"`trajectory with {name}`",
        )
        for name, field in FIELDS.items()
    ]
    return table(("field", "unit", "is", "recorded by"), rows)


def statistics_table() -> str:
    """Return the table of the fields of which there are statistics."""
    whose = {
        "node": "nodes", "spring": "springs", "triangle": "triangles", "cell": "cells",
        "element": "elements",
    }  # fmt: skip
    rows = [
        (
            code(name),
            describe(field.dimension),
            "points of elements" if field.of_points else whose[field.at],
            "yes" if name in FIELDS else "no",
        )
        for name in names_of_fields()
        for field in [field_named(name)]
    ]
    return table(("field", "is", "numbers of", "recorded by trajectories"), rows)


def _limit(method: type[Integrator]) -> str:
    """Return the largest stable step of a method for the angular frequency ω, in words."""
    limit = method.stability_limit(1.0, 0.0)
    return f"{limit:.3g} / ω" if isfinite(limit) else "none"


def integrator_table() -> str:
    """Return the methods that can be named."""
    rows = [
        (
            code(name),
            str(method.order),
            str(method.evaluations),
            _limit(method),
            "yes" if method.symplectic else "no",
            summary(method),
        )
        for name, method in INTEGRATORS.items()
    ]
    heads = ("name", "order", "forces per step", "stable up to", "symplectic", "what it is")
    return table(heads, rows)
