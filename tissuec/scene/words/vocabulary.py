"""Vocabularies: hedges, scales and rules of a program, turned into rule bases."""

from collections.abc import Mapping
from typing import Annotated

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.fields import OneOf
from tissuec.core.hints import Edit, Hint, alternatives, leaving_out
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import NUMBER
from tissuec.fuzzy import rules as c
from tissuec.fuzzy.hedges import Hedge
from tissuec.fuzzy.rulebase import RuleBase
from tissuec.fuzzy.rules import (
    CHOICES,
    ConcludedQuantity,
    Conclusion,
    Operators,
    Rule,
    conflicts,
)
from tissuec.fuzzy.sets import Word
from tissuec.lang import syntax as s
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import by_name, entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.words.phrases import NamedScale, read_hedge, read_word
from tissuec.scene.words.scales import QuantityScale, ScaleReader
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ConcludedClause, ConditionClause, NumberClause

#: What each choice of operators is for.
_OPERATORS = {
    "conjunction": 'the operator for "and"',
    "disjunction": 'the operator for "or"',
    "implication": "how the degree of a rule modifies the word that it concludes",
    "result": "how a number is computed from the conclusions of all rules",
}
OPERATOR_ENTRIES = by_name(
    *(
        entry(name, OneOf(words), _OPERATORS[name], getattr(Operators(), name))
        for name, words in CHOICES.items()
    )
)


class RuleWords(VerbSentence, frozen=True):
    """A rule, and its weight without a unit."""

    condition: Annotated[s.Expression, ConditionClause("", place="CONDITION")]
    conclusions: Annotated[
        tuple[s.Conclusion, ...], ConcludedClause("then", place="QUANTITY is WORD")
    ]
    weight: Annotated[
        float | None, NumberClause("weighing", NUMBER, what="weight of a rule", place="NUMBER")
    ]


_RULE = SentenceKind((RuleWords,))
_IF = written(
    "if", "A rule from words of properties to words of quantities.", *_RULE.forms,
    repeats=True, begins=" ",
)  # fmt: skip
_ENTRIES = {**OPERATOR_ENTRIES, "if": _IF}
declare(
    "rules", "Rules that conclude words of quantities from words of properties.", 13,
    block=block(_ENTRIES, elsewhere=("if",)),
)  # fmt: skip


class RulesBlock(Struct, frozen=True):
    """One ``rules`` block.

    Attributes:
        base: The rules; properties and quantities go by their lower-case names.
        spans: The place of each rule.
    """

    name: str
    base: RuleBase
    spans: tuple[Span, ...]
    span: Span

    @property
    def concluded(self) -> set[str]:
        """Return the quantities that rules conclude."""
        return {part.quantity for rule in self.base.rules for part in rule.conclusions}


class Vocabulary(Struct, frozen=True):
    """All words of a program; every mapping goes by lower-case names."""

    hedges: Mapping[str, Hedge]
    properties: Mapping[str, NamedScale]
    quantities: Mapping[str, QuantityScale]
    rules: Mapping[str, RulesBlock]


def read_vocabulary(declarations: Declarations, scope: Scope) -> Vocabulary:
    """Return the vocabulary of a program; each mistake rejects one entry only."""
    findings = scope.findings
    failures = findings.failures

    def scale(kind: str, declared: Declared) -> ScaleReader:
        return ScaleReader(kind, declared.name, declared.item, scope)

    concluded = {
        key: _concluded(declared.item) for key, declared in declarations.of("rules").items()
    }

    def rules(declared: Declared) -> RulesBlock:
        # A quantity belongs to the rules that conclude it; one that none concludes, to all.
        own = concluded[declared.name.key]
        known = {
            key: scale
            for key, scale in words.quantities.items()
            if key in own or not any(key in those for those in concluded.values())
        }
        return RulesReader(
            declared.name, declared.item, replace(words, quantities=known), scope
        ).read()

    words = Vocabulary(
        declarations.read_each("hedge", lambda d: read_hedge(d.item, scope), findings),
        declarations.read_each("property", lambda d: scale("property", d).property(), findings),
        declarations.read_each("quantity", lambda d: scale("quantity", d).quantity(), findings),
        {},
    )
    if findings.failures > failures:
        return words  # rules would only repeat what is wrong with the scales
    return replace(words, rules=declarations.read_each("rules", rules, findings))


def _concluded(block: s.Item) -> set[str]:
    """Return the quantities that a ``rules`` block concludes, by lower-case name."""
    assert isinstance(block, s.Block)
    rules = (item for item in block.items if isinstance(item, s.Rule))
    return {part.quantity.key for rule in rules for part in rule.conclusions}


class RulesReader:
    """Reads one ``rules`` block."""

    def __init__(self, name: s.Name, item: s.Item, vocabulary: Vocabulary, scope: Scope):
        assert isinstance(item, s.Block)
        self.name = name
        self.block = item
        self.vocabulary = vocabulary
        self.scope = scope
        self.findings = scope.findings

    def read(self) -> RulesBlock:
        """Return the rules with the choice of operators."""
        chosen: dict[str, str] = {}
        rules: list[Rule] = []
        spans: list[Span] = []
        with self.findings.together():
            for item in self.block.items:
                with self.findings.item():
                    if isinstance(item, s.Rule):
                        rules.append(self._rule(item))
                        spans.append(item.span)
                    else:
                        self._operator(item, chosen)
        for clash in conflicts(rules):
            self.findings.add(
                "W204",
                "two rules with the same condition "
                f"conclude different words for {clash.quantity}",
                spans[clash.second],
                hint=leaving_out(
                    "remove one of them, or change its condition",
                    spans[clash.second],
                    spans[clash.first],
                ),
                notes=(Note("the other rule", spans[clash.first]),),
            )
        base = RuleBase(
            {key: named.scale.axis for key, named in self.vocabulary.properties.items()},
            {key: self._quantity(scale) for key, scale in self.vocabulary.quantities.items()},
            tuple(rules),
            Operators(**chosen),  # type: ignore[arg-type]  # checked against CHOICES
        )
        return RulesBlock(self.name.text, base, tuple(spans), self.block.head)

    def _quantity(self, scale: QuantityScale) -> ConcludedQuantity:
        otherwise = None
        if scale.otherwise is not None:
            otherwise = self._concluded(scale.otherwise.word, scale.named)
        return ConcludedQuantity(scale.named.scale.axis, otherwise)

    def _operator(self, item: s.Item, chosen: dict[str, str]) -> None:
        entry = schema.find_entry(_ENTRIES, item, self.scope, what="rules")
        chosen[entry.name] = schema.read_entry(entry, item, self.scope)

    # --- rules --------------------------------------------------------------------------------

    def _rule(self, item: s.Rule) -> Rule:
        reader = SentenceReader("if", _RULE, item, self.scope)
        said: RuleWords = reader.get()
        condition = self._condition(said.condition)
        conclusions = tuple(self._conclusion(part) for part in said.conclusions)
        weight = 1.0 if said.weight is None else said.weight
        if not 0.0 < weight <= 1.0:
            self.findings.reject(
                "TIS308",
                f"the weight of a rule must be above 0 and at most 1, not {weight:g}",
                reader.clauses["weighing"].value.span,
                hint="leave it out for a weight of 1",
            )
        return Rule(condition, conclusions, weight)

    def _condition(self, node: s.Expression) -> c.Condition:
        match node:
            case s.And(operands=operands):
                return c.And(tuple(self._condition(part) for part in operands))
            case s.Or(operands=operands):
                return c.Or(tuple(self._condition(part) for part in operands))
            case s.Not(operand=operand):
                return c.Not(self._condition(operand))
            case s.Is(subject=s.Name()):
                return self._is(node)
            case _:
                self.findings.reject(
                    "TIS312", "a condition of a rule has the form: hardness is soft", node.span
                )

    def _is(self, node: s.Is) -> c.Condition:
        assert isinstance(node.subject, s.Name)
        scale = find_property(node.subject, self.vocabulary, self.name.text, self.scope)
        words = [self._word(name, scale) for name in node.phrase.words]
        key = node.subject.key
        match node.phrase.kind:
            case "not":
                return c.Not(c.Is(key, words[0]))
            case "between":
                self.findings.reject(
                    "TIS312",
                    '"between" is allowed in a tissue, not in a rule',
                    node.phrase.span,
                    hint=Hint("join two conditions with or", Edit(_either(node), node.span)),
                )
            case _:
                return c.Is(key, words[0])

    def _word(self, name: s.Name, scale: NamedScale) -> Word:
        return read_word(name, scale, self.vocabulary.hedges, self.scope)

    def _conclusion(self, part: s.Conclusion) -> Conclusion:
        key = part.quantity.key
        if key in self.vocabulary.properties:
            known = ", ".join(scale.named.name for scale in self.vocabulary.quantities.values())
            self.findings.reject(
                "TIS203",
                f"{part.quantity.text} describes a tissue; a rule can only conclude a quantity",
                part.quantity.span,
                hint=f"quantities: {known}",
            )
        if key not in self.vocabulary.quantities:
            self.findings.pass_over_doubtful(key)
            names = [scale.named.name for scale in self.vocabulary.quantities.values()]
            self.findings.reject(
                "TIS202",
                f'"{part.quantity.text}" is not a quantity of vocabulary {self.name.text}',
                part.quantity.span,
                hint=alternatives(part.quantity.text, names, what="quantities"),
            )
        if part.phrase.kind != "word":
            self.findings.reject("TIS312", "a rule must conclude one word", part.phrase.span)
        scale = self.vocabulary.quantities[key].named
        return Conclusion(key, self._concluded(part.phrase.words[0], scale))

    def _concluded(self, name: s.Name, scale: NamedScale) -> Word:
        hedges = self.vocabulary.hedges
        return read_word(name, scale, hedges, self.scope, in_conclusion=True)


def find_property(name: s.Name, vocabulary: Vocabulary, rules: str, scope: Scope) -> NamedScale:
    """Return the scale of a property, or reject the name.

    Args:
        rules: Name of the vocabulary in messages.
    """
    if name.key not in vocabulary.properties:
        scope.findings.pass_over_doubtful(name.key)
        names = [scale.name for scale in vocabulary.properties.values()]
        scope.findings.reject(
            "TIS202",
            f'"{name.text}" is not a property of vocabulary {rules}',
            name.span,
            hint=alternatives(name.text, names, what="properties"),
        )
    return vocabulary.properties[name.key]


def _either(node: s.Is) -> str:
    """Return the tests for each of the words of a phrase with ``between``."""
    name, text = node.subject.span.text, node.span.source.text
    tests = " or ".join(f"{name} is {word.span.text}" for word in node.phrase.words)
    is_alone = text[: node.span.start].endswith("if ") and text.startswith(
        " then", node.span.end
    )
    return tests if is_alone else f"({tests})"
