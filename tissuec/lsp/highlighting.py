"""A TextMate grammar of the language, from the tables that the compiler itself reads.

It colours as ``semantic_tokens`` does, as far as regular expressions can: a block is known by
its first word, but not which property a word belongs to, nor what a statement means that goes
on over several lines. Patterns are of the kind that both Oniguruma, which editors use, and
Python read.
"""

from collections.abc import Iterable, Mapping

from tissuec.lang.tokens import NUMBER_PATTERN, SIGN_PATTERN, WORD_PATTERN
from tissuec.lang.words import RESERVED
from tissuec.lsp import study
from tissuec.lsp import vocabulary as v
from tissuec.lsp.forms import forms_of
from tissuec.lsp.terms import CHOICE, ENTRY, MEASURE, BlockKind, Term, Terms
from tissuec.lsp.textmate import (
    RESERVED_WORD,
    RUN,
    SCOPE,
    SCOPES,
    START,
    Rule,
    any_of,
    basics,
    between,
    braces,
    called,
    include,
    listed,
    rule,
)  # fmt: skip
from tissuec.lsp.vocabulary import entries
from tissuec.scene.reading.parts import REPEAT, parts
from tissuec.scene.sentences import KINDS
from tissuec.scene.study.entries import EVENTS
from tissuec.script.measures import MEASURES
from tissuec.script.measures.cut_faces import CUT_FACES

#: Where a line, or a statement, ends; and where one with a block does.
_END, _END_OF_BLOCK = r"(?=[;}])|$", r"(?<=\})|(?=[;}])|$"


def grammar() -> Rule:
    """Return the grammar as the document that editors read."""
    return {
        "name": "tissuec",
        "scopeName": SCOPE,
        "fileTypes": ["tis"],
        "patterns": include("statements"),
        "repository": {name: {"patterns": rules} for name, rules in _repository().items()},
    }


def _repository() -> dict[str, list[Rule]]:
    blocks = {f"{kind}-part": [_part(kind)] for kind in parts("named", "single")}
    first = rule(rf"{START}({'|'.join((*parts('text'), 'hedge', REPEAT))})\b", {1: "part"})
    rest = include("hedge", "set", "expect", "expression")
    return {
        "statements": [*include("basics", "table", *blocks), first, *rest],
        **blocks,
        "basics": basics(),
        "choice": _choices(),
        "expression": _expression(),
        "table": [_table()],
        "hedge": [*called(v.HEDGE_TERMS), listed(v.DIRECTION_TERMS, r"(?<=,)\s*")],
        "set": [_line("set", [_chosen_from(), *include("conditions")])],
        "expect": [_line("expect", include("measures"))],
        "conditions": [*include("basics"), _where(), *include("expression")],
        "measures": [*include("basics"), *_measured(), *include("expression")],
        "orders": _orders(),
    }


# --- what many places have --------------------------------------------------------------------


def _expression() -> list[Rule]:
    """Return the rules that apply where no other rule does."""
    return [
        *called(v.functions()),
        {"match": rf"\b(?:{RESERVED_WORD})\b", "name": SCOPES["keyword"]},
        {"match": SIGN_PATTERN, "name": SCOPES["sign"]},
        {"match": RUN, "name": SCOPES["name"]},
    ]


def _choices() -> list[Rule]:
    """Return the rules of words after "is"."""
    holding = [
        choice
        for kind in ("rules", "study")
        for entry in entries(BlockKind(kind)).values()
        for choice in entry.choices or ()
        if RESERVED & set(choice.split())
    ]
    return [
        rule(rf"\b(is)\s+({any_of(holding)})", {1: "keyword", 2: "word"}),
        rule(
            rf"\b(is)\s+(between)\s+({RUN})\s+(and)\s+({RUN})",
            {1: "keyword", 2: "keyword", 3: "word", 4: "keyword", 5: "word"},
        ),
        rule(rf"\b(is)\s+(?:(not)\s+)?({RUN})", {1: "keyword", 2: "keyword", 3: "word"}),
    ]


def _line(word: str, patterns: list[Rule]) -> Rule:
    """Return the rule of a statement that begins with a reserved word, up to its line end."""
    return between(rf"{START}({word})\b", {1: "keyword"}, _END, patterns)


def _words_in_list(begin: str, kinds: Mapping[int, str], first: Rule) -> Rule:
    """Return the rule of a list, in which one rule goes before those of expressions."""
    patterns = [first, *include("basics", "expression")]
    return between(begin, kinds, r"\]|$", patterns, closes=True)


def _clauses(kind: str, first_words: Iterable[str]) -> list[Rule]:
    """Return the words of the language after joining words, from the forms of sentences.

    Args:
        kind: Of the block.
        first_words: Parts, entries or verbs of the sentences.
    """
    found: dict[tuple[str, str], set[str]] = {}
    for first in (word for word in first_words if word not in v.FORMULAS):
        for form in forms_of(kind, first):
            for word, expected, _ in form.clauses:
                if word in ("", "=", "is", "in"):
                    continue
                for term in (term for terms in expected.terms for term in terms.values()):
                    if term.kind in (CHOICE, ENTRY) and not term.label.startswith("table"):
                        found.setdefault((word, term.kind), set()).add(term.label)
    return [
        rule(rf"\b({word})\s+({any_of(labels)})", {1: "keyword", 2: colour})
        for (word, colour), labels in found.items()
    ]


# --- parts of a text --------------------------------------------------------------------------


def _part(kind: str) -> Rule:
    """Return the rule of a block outside of all others: its head and contents."""
    named = "" if kind in parts("single") else r"(?!\s*(?:=|is\b))"
    head = [*include("basics"), *_clauses("", [kind])]
    if kind == "quantity":
        head.append(rule(rf"(?<=quantity)\s+({any_of(v.QUANTITY_TERMS)})", {1: "word"}))
    patterns = [*head, braces(_inside(kind)), *include("expression")]
    begin = rf"{START}({kind})\b{named}"
    return between(begin, {1: "part"}, r"(?<=\})|(?=;)|$", patterns)


def _inside(kind: str) -> list[Rule]:
    """Return the rules for the contents of a block."""
    if kind == "script":
        return include("orders")
    known = entries(BlockKind(kind))
    rules = {
        "learn": _learning, "study": _studying, "rules": _rules, "property": _scale,
        "quantity": _scale, "output": _output, "tissue": _tissue, "law": _tissue, "body": _body,
    }.get(kind, _plain)(known)  # fmt: skip
    # The sentences of studies are examples.
    clauses = [] if kind == "study" else _clauses(kind, known)
    return _block(*clauses, *rules)


def _block(*rules: Rule) -> list[Rule]:
    """Return the rules of a block, between those that hold in all of them."""
    return [*include("basics"), *rules, *include("choice", "expression")]


def _entries(known: Iterable[str]) -> Rule:
    """Return the rule of the entries of a block."""
    return rule(rf"{START}({any_of(known)})", {1: "entry"})


def _inner(*kinds: str) -> Rule:
    """Return the rule of a block inside of another one."""
    return braces(
        _block(_entries([name for kind in kinds for name in entries(BlockKind(kind))]))
    )


def _named(entry: str, known: Iterable[str]) -> Rule:
    """Return the rule of an entry with its subject."""
    return rule(rf"{START}({entry})\s+({any_of(known)})", {1: "entry", 2: "entry"})


def _plain(known: Mapping[str, Term]) -> list[Rule]:
    return [_made_of(), _entries(known), _inner("integrator")]


def _made_of() -> Rule:
    return rule(rf"{START}(tissue)\s+(is)\s+({RUN})", {1: "entry", 2: "keyword", 3: "name"})


def _tissue(known: Mapping[str, Term]) -> list[Rule]:
    own = rule(rf"{START}({RUN})", {1: "entry"})
    laws = _inner("spring law", "viscosity law", "solid law")
    modes = listed(v.MODE_TERMS, r"(?<=\bstress in)\s+")
    return [_named("known", v.KNOWN_TERMS), modes, _entries(known), own, laws]


def _output(known: Mapping[str, Term]) -> list[Rule]:
    logged = [term.label for term in known.values() if term.kind == MEASURE]
    measured = rule(rf"{START}({any_of(logged)})", {1: "measure"})
    of_what = [
        rule(rf"(?<=\b{name}\()\s*({any_of(words)})", {1: "word"})
        for name, words in _of_what().items()
        if name not in v.errors()
    ]
    rules = [measured, *of_what, _entries(known), _inner("surface")]
    copies = [*include("basics"), braces(_block(*rules)), *include("expression")]
    repeated = between(rf"{START}({REPEAT})\b", {1: "entry"}, _END_OF_BLOCK, copies)
    return [repeated, *rules]


def _body(known: Mapping[str, Term]) -> list[Rule]:
    kinds = {1: "entry", 2: "keyword", 3: "word"}
    of_mesh = [*include("basics"), _inner("mesh"), *include("expression")]
    mesh = between(rf"{START}(mesh)\s+(is)\s+({RUN})", kinds, _END_OF_BLOCK, of_mesh)
    named = rule(rf"(?<=region)\s+({RUN})", {1: "name"})
    inner = braces(_block(_made_of(), _entries(entries(BlockKind("region")))))
    of_region = [named, inner, *include("conditions")]
    region = between(rf"{START}(region)\b", {1: "entry"}, _END_OF_BLOCK, of_region)
    return [mesh, region, _made_of(), _entries(known)]


def _scale(known: Mapping[str, Term]) -> list[Rule]:
    """Return the words of a scale and the shapes that they have."""
    words = {"match": RUN, "name": SCOPES["word"]}
    own = rule(rf"{START}({RUN})", {1: "word"})
    listing = _words_in_list(r"\[", {0: "sign"}, words)
    return [_entries(known), *called(v.SHAPE_TERMS), own, listing]


def _rules(known: Mapping[str, Term]) -> list[Rule]:
    """Return the names of properties and quantities, which precede "is"."""
    chosen = _entries(name for name in known if name not in RESERVED)
    return [chosen, rule(rf"\b({RUN})(?=\s+is\b)", {1: "entry"})]


def _learning(known: Mapping[str, Term]) -> list[Rule]:
    """Return the rules of a learn block."""
    adjusted = rule(rf"\b({any_of(v.adjusted())})", {1: "entry"})
    return [
        _named("adjust", v.adjusted()),
        _entries(known),
        *called({name: term for name, term in v.fitted().items() if term.behind == "("}),
        _words_in_list(r"(?<=adjust)\s*(=)\s*(\[)", {1: "sign", 2: "sign"}, adjusted),
        braces(include("basics", "expression")),
    ]


def _studying(known: Mapping[str, Term]) -> list[Rule]:
    """Return the rules of a study block."""
    varied = study.varied()
    choices = {name for term in varied.values() for name in term.choices or ()}
    words = {"match": RUN, "name": SCOPES["word"]}
    described = rf"{START}(vary)\s+({RUN})\s+(of)\s+({RUN})\s*(=)\s*(\[)"
    kinds = {1: "entry", 2: "name", 3: "keyword", 4: "name", 5: "sign", 6: "sign"}
    event = rf"\b(time)\s+(of)\s+({any_of(EVENTS)})"
    return [
        _named("vary", varied),
        _words_in_list(described, kinds, words),
        rule(rf"{START}(measure)\s+({RUN})(?=\s*=)", {1: "entry", 2: "name"}),
        _entries(known),
        rule(event, {1: "measure", 2: "keyword", 3: "word"}),
        *called(
            {
                **v.logged(),
                **study.OVER_TIME_TERMS,
                **study.DISTRIBUTION_TERMS,
                **study.OVER_RUNS_TERMS,
            }
        ),
        listed(study.STEPS_TERMS, r"(?<=[0-9])[ \t]+"),
        *_clauses("", ["expect"]),
        rule(rf"(?<=[\[,=])\s*({any_of(choices)})", {1: "word"}),
    ]


def _table() -> Rule:
    """Return tables: cells are no sentences."""
    cells = {
        r"#.*$": "comment", r'"[^"\n]*"?': "string", NUMBER_PATTERN: "number",
        SIGN_PATTERN: "sign", WORD_PATTERN: "name",
    }  # fmt: skip
    patterns = [
        *include("basics"),
        rule(r"(?<=table)\s+((?i:nodes|springs))\b", {1: "word"}),
        *_clauses("", ["table"]),
        braces([{"match": match, "name": SCOPES[kind]} for match, kind in cells.items()]),
        *include("expression"),
    ]
    return between(rf"{START}(table)\b", {1: "keyword"}, r"(?<=\})|(?=;)|$", patterns)


# --- conditions and orders --------------------------------------------------------------------


def _chosen_from() -> Rule:
    return rule(rf"(?<==)\s*({any_of(KINDS)})(?=\s+of\b)", {1: "word"})


def _where() -> Rule:
    """Return conditions; what nodes and springs are chosen by is known after "where" only."""
    part_of = rule(
        rf"\b((?i:region|group))\s+(is)\s+(?:(not)\s+)?({RUN})",
        {1: "measure", 2: "keyword", 3: "keyword", 4: "name"},
    )
    chosen_by = rule(rf"\b({any_of(v.conditions())})", {1: "measure"})
    patterns = [*include("basics"), part_of, chosen_by, *include("expression")]
    return between(r"\b(where)\b", {1: "keyword"}, r"(?=[;{}])|$", patterns)


def _of_what() -> dict[str, Terms]:
    """Return the words that begin the arguments of what is written like measures."""
    return {
        "count": v.COUNTED,
        **{name: v.FACES for name, one in MEASURES.items() if one.takes == CUT_FACES},
        **dict.fromkeys(v.statistics(), v.fields()),
        **dict.fromkeys(v.errors(), v.ERRORS_OF),
    }


def _measured() -> list[Rule]:
    return [
        *(
            rule(
                rf"\b((?i:{name}))\s*(\()\s*({any_of(known)})",
                {1: "measure", 2: "sign", 3: "word"},
            )
            for name, known in _of_what().items()
        ),
        *called({**v.logged(), **v.measures(), **v.errors()}),
        *_clauses("", ["expect"]),
    ]


def _orders() -> list[Rule]:
    """Return the rules of a script."""
    before = r"(?:^|(?<=[;{}:]))\s*"
    return [
        *include("basics"),
        *(
            rule(rf"{before}({verb})\s+({any_of(literals)})", {1: "verb", 2: "entry"})
            for verb in v.verbs()
            if (literals := {form.literal for form in forms_of("script", verb) if form.literal})
        ),
        rule(rf"{before}({any_of(v.verbs())})", {1: "verb"}),
        rule(rf"{before}({REPEAT})\b", {1: "entry"}),
        *_clauses("script", v.verbs()),
        rule(r"\b(table)(?=\s+\")", {1: "keyword"}),
        between(rf"{START}(when)\b", {1: "keyword"}, r"(?=[:;{}])|$", include("measures")),
        braces(include("orders")),
        *include("expression"),
    ]
