"""A TextMate grammar of the language, from the tables that the compiler itself reads.

It colours as ``semantic_tokens`` does, as far as regular expressions can: a block is known by
its first word, but not which property a word belongs to, nor what a statement means that goes
on over several lines. Patterns are of the kind that both Oniguruma, which editors use, and
Python read.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Any

from tissuec.core.units import unit_pattern
from tissuec.lang.tokens import NUMBER_PATTERN, SIGN_PATTERN, WORD_PATTERN
from tissuec.lang.words import RESERVED
from tissuec.lsp import study
from tissuec.lsp import vocabulary as v
from tissuec.lsp.entries import entries
from tissuec.lsp.forms import forms_of
from tissuec.lsp.terms import MEASURE, Block, Term
from tissuec.scene.declarations import NAMED, SINGLE

Rule = dict[str, Any]

SCOPE = "source.tissuec"
#: What each kind of ``semantic_tokens`` is called in themes.
SCOPES = {
    "comment": "comment.line.number-sign.tissuec",
    "string": "string.quoted.double.tissuec",
    "number": "constant.numeric.tissuec",
    "unit": "keyword.other.unit.tissuec",
    "keyword": "keyword.control.tissuec",
    "part": "storage.type.tissuec",
    "entry": "entity.other.attribute-name.tissuec",
    "verb": "support.function.verb.tissuec",
    "measure": "support.function.measure.tissuec",
    "word": "constant.language.tissuec",
    "name": "variable.other.tissuec",
    "sign": "keyword.operator.tissuec",
}

_START = r"(?:^|(?<=[;{}]))\s*"
#: A word that ends no name, and several of them.
_RESERVED = "|".join(sorted(RESERVED, key=lambda word: (-len(word), word)))
_WORD = rf"(?!(?:{_RESERVED})\b){WORD_PATTERN}"
_RUN = rf"{_WORD}(?:\s+{_WORD})*"
_SINGLE = frozenset(SINGLE)


def grammar() -> Rule:
    """Return the grammar as the document that editors read."""
    return {
        "name": "tissuec",
        "scopeName": SCOPE,
        "fileTypes": ["tis"],
        "patterns": _include("statements"),
        "repository": _repository(),
    }


def _repository() -> dict[str, Rule]:
    parts = [_include(f"{kind}-part")[0] for kind in (*NAMED, *SINGLE)]
    return {
        "statements": {
            "patterns": [
                *_include("basics"),
                *_include("table"),
                *parts,
                _rule(rf"{_START}(use|about|hedge)\b", {1: "part"}),
                *_include("hedge", "set", "expect", "expression"),
            ]
        },
        **{f"{kind}-part": _part(kind) for kind in (*NAMED, *SINGLE)},
        "basics": {"patterns": _basics()},
        "choice": {"patterns": _choices()},
        "expression": {"patterns": _expression()},
        "table": _table(),
        "hedge": {"patterns": _hedge()},
        "set": _line("set", [_chosen_from(), *_include("conditions")]),
        "expect": _line("expect", _include("measures")),
        "conditions": {"patterns": [*_include("basics"), _where(), *_include("expression")]},
        "measures": {"patterns": [*_include("basics"), *_measured(), *_include("expression")]},
        "orders": {"patterns": _orders()},
    }  # fmt: skip


# --- small pieces -----------------------------------------------------------------------------


def _include(*names: str) -> list[Rule]:
    return [{"include": f"#{name}"} for name in names]


def _captures(kinds: Mapping[int, str]) -> Rule:
    return {str(number): {"name": SCOPES[kind]} for number, kind in kinds.items()}


def _rule(match: str, kinds: Mapping[int, str]) -> Rule:
    return {"match": match, "captures": _captures(kinds)}


def _any(labels: Iterable[str]) -> str:
    """Return a pattern of any of some words, which may be several words each."""
    longest_first = sorted(labels, key=lambda label: (-len(label), label))
    words = "|".join(re.escape(label).replace(r"\ ", r"\s+") for label in longest_first)
    return rf"(?i:{words})(?!\w)"


def _listed(found: Mapping[str, Term], before: str = r"\b") -> Rule:
    """Return the rule of words that stand behind something."""
    return _rule(f"{before}({_any(found)})", {1: "word"})


def _called(found: Mapping[str, Term]) -> list[Rule]:
    """Return the rules of what stands before a bracket, and of what stands alone."""
    called = [term.label for term in found.values() if term.behind == "("]
    alone = [term.label for term in found.values() if term.behind != "("]
    rules = [_rule(rf"\b({_any(called)})(?=\s*\()", {1: "measure"})] if called else []
    return rules + ([_rule(rf"\b({_any(alone)})", {1: "measure"})] if alone else [])


def _basics() -> list[Rule]:
    """Return comments, texts, numbers with units."""
    return [
        {"match": r"#.*$", "name": SCOPES["comment"]},
        {"match": r'"[^"\n]*"?', "name": SCOPES["string"]},
        _rule(rf"({NUMBER_PATTERN})(?:[ \t]*({unit_pattern()}))?", {1: "number", 2: "unit"}),
        _rule(rf"(\))[ \t]*({unit_pattern()})", {1: "sign", 2: "unit"}),
    ]


def _expression() -> list[Rule]:
    """Return what holds wherever nothing else does."""
    return [
        *_called(v.functions()),
        {"match": rf"\b(?:{_RESERVED})\b", "name": SCOPES["keyword"]},
        {"match": SIGN_PATTERN, "name": SCOPES["sign"]},
        {"match": _RUN, "name": SCOPES["name"]},
    ]


def _choices() -> list[Rule]:
    """Return what stands behind "is"."""
    holding = [
        choice
        for entry in entries(Block("rules")).values()
        for choice in entry.choices or ()
        if RESERVED & set(choice.split())
    ]
    return [
        _rule(rf"\b(is)\s+({_any(holding)})", {1: "keyword", 2: "word"}),
        _rule(
            rf"\b(is)\s+(between)\s+({_RUN})\s+(and)\s+({_RUN})",
            {1: "keyword", 2: "keyword", 3: "word", 4: "keyword", 5: "word"},
        ),
        _rule(rf"\b(is)\s+(?:(not)\s+)?({_RUN})", {1: "keyword", 2: "keyword", 3: "word"}),
    ]


def _line(word: str, patterns: list[Rule]) -> Rule:
    """Return the rule of a statement that begins with a reserved word, up to its line end."""
    return {
        "begin": rf"{_START}({word})\b",
        "beginCaptures": _captures({1: "keyword"}),
        "end": r"(?=[;}])|$",
        "patterns": patterns,
    }


def _braces(patterns: list[Rule]) -> Rule:
    return {
        "begin": r"\{",
        "beginCaptures": {"0": {"name": SCOPES["sign"]}},
        "end": r"\}",
        "endCaptures": {"0": {"name": SCOPES["sign"]}},
        "patterns": patterns,
    }


#: The rest of a list of words.
_LISTED_WORDS: Rule = {
    "end": r"\]|$",
    "endCaptures": {"0": {"name": SCOPES["sign"]}},
    "patterns": [
        {"match": _RUN, "name": SCOPES["word"]},
        *_include("basics", "expression"),
    ],
}


# --- parts of a text --------------------------------------------------------------------------


def _part(kind: str) -> Rule:
    """Return the rule of a block outside of all others: its head, and what is in it."""
    named = "" if kind in _SINGLE else r"(?!\s*(?:=|is\b))"
    head: list[Rule] = [*_include("basics")]
    if kind == "quantity":
        head.append(_rule(rf"(?<=quantity)\s+({_any(v.QUANTITY_TERMS)})", {1: "word"}))
    if kind in ("property", "quantity"):
        head.append(_listed(v.LOG_SCALE, r"(?<=\bon)\s+"))
    return {
        "begin": rf"{_START}({kind})\b{named}",
        "beginCaptures": _captures({1: "part"}),
        "end": r"(?<=\})|(?=;)|$",
        "patterns": [*head, _braces(_inside(kind)), *_include("expression")],
    }


def _inside(kind: str) -> list[Rule]:
    """Return the rules of what stands in a block."""
    known = entries(Block(kind))
    match kind:
        case "script":
            return _include("orders")
        case "learn":
            return _block(*_learning(known))
        case "study":
            return _block(*_studying(known))
        case "rules":
            chosen = {name: term for name, term in known.items() if name not in RESERVED}
            return _block(_entries(chosen), *_rules())
        case "property" | "quantity":
            return _block(_entries(known), *_scale())
        case "output":
            surface = _block(_entries(entries(Block("surface"))))
            return _block(_logged(known), _entries(known), _braces(surface))
        case "tissue" | "law":
            own = _rule(rf"{_START}({_RUN})", {1: "entry"})
            evidence = _rule(
                rf"{_START}(known)\s+({_any(v.KNOWN_TERMS)})", {1: "entry", 2: "entry"}
            )
            source = _listed_behind("by", v.SOURCE_TERMS, "word")
            rules = (evidence, source, _entries(known), own)
            return _block(*rules, _braces(_block(*_laws())))
        case "simulate":
            choices = _block(_entries(entries(Block("integrator"))))
            return _block(_entries(known), _braces(choices))
        case "body":
            return _block(_mesh(), _region(), _made_of(), _entries(known))
        case _:
            return _block(_made_of(), _entries(known))


def _block(*rules: Rule) -> list[Rule]:
    """Return the rules of a block, between those that hold in all of them."""
    return [*_include("basics"), *rules, *_include("choice", "expression")]


def _entries(known: Mapping[str, Term]) -> Rule:
    """Return the rule of the entries of a block."""
    return _rule(rf"{_START}({_any(known)})", {1: "entry"})


def _learning(known: Mapping[str, Term]) -> list[Rule]:
    """Return what stands in a learn block."""
    return [
        _rule(rf"{_START}(adjust)\s+({_any(v.adjusted())})", {1: "entry", 2: "entry"}),
        _entries(known),
        *_called({name: term for name, term in v.fitted().items() if term.behind == "("}),
        _listed_behind("using", v.COLUMN, "entry"),
        _listed_behind("with", v.FREE_ZERO, "word"),
        _listed_behind("per", v.DIVISIONS, "word"),
        {
            "begin": r"(?<=adjust)\s*(=)\s*(\[)",
            "beginCaptures": _captures({1: "sign", 2: "sign"}),
            "end": r"\]|$",
            "endCaptures": {"0": {"name": SCOPES["sign"]}},
            "patterns": [
                _rule(rf"\b({_any(v.adjusted())})", {1: "entry"}),
                *_include("basics", "expression"),
            ],
        },
        _braces([*_include("basics", "expression")]),
    ]


def _studying(known: Mapping[str, Term]) -> list[Rule]:
    """Return what stands in a study block."""
    varied = study.varied()
    words = {name for term in varied.values() for name in term.choices or ()}
    designs = _any(known["design"].choices or ())
    return [
        _rule(rf"{_START}(vary)\s+({_any(varied)})", {1: "entry", 2: "entry"}),
        {
            "begin": rf"{_START}(vary)\s+({_RUN})\s+(of)\s+({_RUN})\s*(=)\s*(\[)",
            "beginCaptures": _captures(
                {1: "entry", 2: "name", 3: "keyword", 4: "name", 5: "sign", 6: "sign"}
            ),
            **_LISTED_WORDS,
        },
        _rule(rf"{_START}(measure)\s+({_RUN})(?=\s*=)", {1: "entry", 2: "name"}),
        _rule(rf"{_START}(design)\s+(is)\s+({designs})", {1: "entry", 2: "keyword", 3: "word"}),
        _entries(known),
        _rule(
            rf"\b(time)\s+(of)\s+({_any(study.EVENT_TERMS)})",
            {1: "measure", 2: "keyword", 3: "word"},
        ),
        *_called({**study.measures(), **study.DISTRIBUTION_TERMS, **study.OVER_RUNS_TERMS}),
        _listed(study.STEPS_TERMS, r"(?<=[0-9])[ \t]+"),
        _listed(v.RUN, r"(?<=\bover)\s+"),
        _rule(rf"(?<=[\[,=])\s*({_any(words)})", {1: "word"}),
    ]


def _listed_behind(word: str, found: Mapping[str, Term], kind: str) -> Rule:
    """Return the rule of words that stand behind a joining word."""
    return _rule(rf"\b({word})\s+({_any(found)})", {1: "keyword", 2: kind})


def _logged(known: Mapping[str, Term]) -> Rule:
    """Return the rule of measures that an output logs."""
    labels = [term.label for term in known.values() if term.kind == MEASURE]
    return _rule(rf"{_START}({_any(labels)})", {1: "measure"})


def _made_of() -> Rule:
    return _rule(rf"{_START}(tissue)\s+(is)\s+({_RUN})", {1: "entry", 2: "keyword", 3: "name"})


def _mesh() -> Rule:
    inner = _block(_entries(entries(Block("mesh"))))
    return {
        "begin": rf"{_START}(mesh)\s+(is)\s+({_RUN})",
        "beginCaptures": _captures({1: "entry", 2: "keyword", 3: "word"}),
        "end": r"(?<=\})|(?=[;}])|$",
        "patterns": [*_include("basics"), _braces(inner), *_include("expression")],
    }  # fmt: skip


def _region() -> Rule:
    inner = _block(_made_of(), _entries(entries(Block("region"))))
    return {
        "begin": rf"{_START}(region)\b",
        "beginCaptures": _captures({1: "entry"}),
        "end": r"(?<=\})|(?=[;}])|$",
        "patterns": [
            _rule(rf"(?<=region)\s+({_RUN})", {1: "name"}), _braces(inner),
            *_include("conditions"),
        ],
    }  # fmt: skip


def _laws() -> list[Rule]:
    known = {**entries(Block("spring law")), **entries(Block("viscosity law"))}
    return [_entries(known)]


def _scale() -> list[Rule]:
    """Return the words of a scale and the shapes that they have."""
    return [
        *_called(v.SHAPE_TERMS),
        _listed(v.SPREADS, r"(?<=\bto)\s+"),
        _rule(rf"{_START}({_RUN})", {1: "word"}),
        {
            "begin": r"\[",
            "beginCaptures": {"0": {"name": SCOPES["sign"]}},
            **_LISTED_WORDS,
        },
    ]


def _rules() -> list[Rule]:
    """Return the names of properties and quantities, which stand before "is"."""
    return [_rule(rf"\b({_RUN})(?=\s+is\b)", {1: "entry"})]


def _table() -> Rule:
    """Return tables: cells are no sentences."""
    return {
        "begin": rf"{_START}(table)\b",
        "beginCaptures": _captures({1: "keyword"}),
        "end": r"(?<=\})|(?=;)|$",
        "patterns": [
            *_include("basics"),
            _rule(r"(?<=table)\s+((?i:nodes|springs))\b", {1: "word"}),
            _rule(rf"\b(with)\s+({_any(v.COLUMNS)})", {1: "keyword", 2: "entry"}),
            _braces(
                [
                    {"match": r"#.*$", "name": SCOPES["comment"]},
                    {"match": r'"[^"\n]*"?', "name": SCOPES["string"]},
                    {"match": NUMBER_PATTERN, "name": SCOPES["number"]},
                    {"match": SIGN_PATTERN, "name": SCOPES["sign"]},
                    {"match": WORD_PATTERN, "name": SCOPES["name"]},
                ]
            ),
            *_include("expression"),
        ],
    }


# --- conditions and orders --------------------------------------------------------------------


def _chosen_from() -> Rule:
    return _rule(rf"(?<==)\s*({_any(v.CHOSEN_FROM)})(?=\s+of\b)", {1: "word"})


def _hedge() -> list[Rule]:
    return [*_called(v.HEDGE_TERMS), _listed(v.DIRECTION_TERMS, r"(?<=,)\s*")]


def _where() -> Rule:
    """Return conditions; what nodes and springs are chosen by is known behind "where" only."""
    part_of = _rule(
        rf"\b((?i:region|group))\s+(is)\s+(?:(not)\s+)?({_RUN})",
        {1: "measure", 2: "keyword", 3: "keyword", 4: "name"},
    )
    chosen_by = _rule(rf"\b({_any(v.conditions())})", {1: "measure"})
    return {
        "begin": r"\b(where)\b",
        "beginCaptures": _captures({1: "keyword"}),
        "end": r"(?=[;{}])|$",
        "patterns": [*_include("basics"), part_of, chosen_by, *_include("expression")],
    }


def _measured() -> list[Rule]:
    return [
        _rule(
            rf"\b((?i:count))\s*(\()\s*({_any(v.COUNTED)})",
            {1: "measure", 2: "sign", 3: "word"},
        ),
        _rule(
            rf"\b({_any(v.errors())})\s*(\()\s*({_any(v.ERRORS_OF)})",
            {1: "measure", 2: "sign", 3: "word"},
        ),
        *_called({**v.logged(), **v.measures(), **v.errors()}),
        _listed(v.RUN, r"(?<=\bover)\s+"),
    ]


def _orders() -> list[Rule]:
    """Return what stands in a script."""
    before = r"(?:^|(?<=[;{}:]))\s*"
    return [
        *_include("basics"),
        *(
            _rule(rf"{before}({verb})\s+({_any(literals)})", {1: "verb", 2: "entry"})
            for verb in v.verbs()
            if (literals := {form.literal for form in forms_of("script", verb) if form.literal})
        ),
        _rule(rf"{before}({_any(v.verbs())})", {1: "verb"}),
        *_clauses(),
        {
            "begin": rf"{_START}(when)\b",
            "beginCaptures": _captures({1: "keyword"}),
            "end": r"(?=[:;{}])|$",
            "patterns": _include("measures"),
        },
        _braces(_include("orders")),
        *_include("expression"),
    ]


def _clauses() -> list[Rule]:
    """Return the words of the language that stand behind joining words of orders."""
    found: dict[str, set[str]] = {"using": set(v.profiles()) - {"table"}}
    for verb in v.verbs():
        for form in forms_of("script", verb):
            for word, content in form.clauses:
                literal = " ".join(part for part in content if part.islower())
                if literal and not literal.startswith("table"):
                    found.setdefault(word, set()).add(literal)
                found.setdefault(word, set()).update(v.kinds_of_clause(verb, word))
    rules = [
        _rule(rf"\b({word})\s+({_any(labels)})", {1: "keyword", 2: "word"})
        for word, labels in found.items()
        if labels
    ]
    return [*rules, _rule(r"\b(table)(?=\s+\")", {1: "keyword"})]
