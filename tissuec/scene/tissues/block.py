"""Tissues: words and numbers of a preset, its parent's first, turned into quantities."""

from collections.abc import Mapping
from typing import Annotated, NoReturn

import numpy as np
from msgspec import Struct, field

from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.hints import Edit, Hint, alternatives, leaving_out
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.fuzzy.rulebase import Inference
from tissuec.lang import syntax as s
from tissuec.laws import MODULUS, REST, E, stress_in
from tissuec.scene.model import (
    STRETCHED,
    Appearance,
    AssignedQuantity,
    KnownQuantity,
    PropertyFact,
    Tissue,
    WrittenLaw,
)
from tissuec.scene.overrides.entries import SET
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.program.metadata import TextWords, read_text
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import by_name, written
from tissuec.scene.reading.entry_hints import left_side
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import LIKE, block, declare
from tissuec.scene.tissues.appearance import APPEARANCE, read_appearance
from tissuec.scene.tissues.conclusions import conclude
from tissuec.scene.tissues.curve_evidence import (
    KNOWN_ENTRY,
    is_curve,
    read_curve,
    refuse_crossing,
    refuse_fibres,
)
from tissuec.scene.tissues.evidence import (
    KNOWN,
    is_evidence,
    read_known,
    refuse_contradiction,
    warn_of_contradictions,
    warn_of_words,
)
from tissuec.scene.tissues.facts import FACT_KIND, FactReader
from tissuec.scene.tissues.idle_words import Answers, TissueWords
from tissuec.scene.tissues.known_curves import KnownCurve
from tissuec.scene.tissues.laws import BY_ENTRY, LAW_ENTRIES, read_law
from tissuec.scene.tissues.quantities import (
    CONCLUDED,
    FIBRE_MODULUS,
    LISTED,
    QUANTITIES,
    STIFFENING,
    YOUNGS_MODULUS,
    exclude,
    replaced_by,
    rivals,
)
from tissuec.scene.tissues.written_numbers import quantity_meant, read_given
from tissuec.scene.usual_ranges import unusual
from tissuec.scene.words.vocabulary import RulesBlock, Vocabulary
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import RULES, TISSUE, NameClause, new_name

MOST_PARENTS = 50
_RULES = 'use "fuzzy/soft_matter", and in the tissue first: described in soft matter'


class TissueHead(VerbSentence, frozen=True):
    """A tissue, and the one that it is like."""

    name: Annotated[s.Name, new_name("tissue")]
    like: Annotated[s.Name | None, NameClause(LIKE, places=(TISSUE,))]


class DescribedWords(VerbSentence, frozen=True):
    """The rules whose words describe a tissue."""

    rules: Annotated[
        s.Name,
        NameClause("in", what="name of the rules", places=(RULES,), example="in soft tissue"),
    ]


_TISSUE, _DESCRIBED = SentenceKind((TissueHead,)), SentenceKind((DescribedWords,))
#: Entries of a tissue, beside the words of a vocabulary.
ENTRIES = {
    **by_name(
        written(
            "about", "Describes the tissue and the source of its numbers in one sentence.",
            TextWords,
        ),
        written(
            "described", "The rules that define the words of this tissue: described in RULES.",
            DescribedWords,
        ),
    ),
    **APPEARANCE,
    KNOWN: KNOWN_ENTRY,
    **LAW_ENTRIES,
    **{key: quantity.entry for key, quantity in QUANTITIES.items()},
}  # fmt: skip
declare(
    "tissue",
    "A material of springs and nodes, given by words of a vocabulary, numbers or both.", 21,
    sentences=_TISSUE.forms, example="tissue NAME { … }",
    block=block(ENTRIES, *FACT_KIND.forms), entries_vary=True,
)  # fmt: skip
_NAMED = s.Sentence | s.Assign | s.Block | s.Function


class _Written(Struct):
    """The entries of a tissue and its parents, the nearest one winning.

    Attributes:
        inherited: What the parent has by itself; None without one.
        left: Quantities whose inherited numbers are left out, so that rules conclude them.
    """

    rules: RulesBlock | None = None
    about: str = ""
    facts: dict[str, s.Sentence | s.Assign] = field(
        default_factory=dict[str, s.Sentence | s.Assign]
    )
    numbers: dict[str, AssignedQuantity] = field(default_factory=dict[str, AssignedQuantity])
    laws: dict[str, WrittenLaw] = field(default_factory=dict[str, WrittenLaw])
    known: dict[str, list[KnownQuantity]] = field(
        default_factory=dict[str, list[KnownQuantity]]
    )
    curves: dict[str, list[KnownCurve]] = field(default_factory=dict[str, list[KnownCurve]])
    appearance: Appearance = field(default_factory=Appearance)
    inherited: "_Written | None" = None
    left: set[str] = field(default_factory=set[str])

    def heir(self) -> "_Written":
        """Return the quantities that a child inherits."""
        return replace(
            self,
            facts=dict(self.facts),
            numbers=dict(self.numbers),
            laws=dict(self.laws),
            known=dict(self.known),
            curves=dict(self.curves),
            inherited=self,
            left=set(self.left),
        )


def read_tissues(
    declarations: Declarations, vocabulary: Vocabulary, scope: Scope
) -> dict[str, Tissue]:
    """Return every tissue by lower-case name; each error rejects one tissue only."""
    reader = TissueReader(declarations, vocabulary, scope)
    return declarations.read_each("tissue", reader.read, scope.findings)


class TissueReader:
    """Reads ``tissue`` blocks."""

    def __init__(self, declarations: Declarations, vocabulary: Vocabulary, scope: Scope):
        self.declarations = declarations
        self.vocabulary = vocabulary
        self.scope = scope
        self.findings = scope.findings
        self.facts = FactReader(vocabulary, scope)
        #: Tissues of which it was said that they need one another.
        self.circles: set[str] = set()

    def read(self, declared: Declared) -> Tissue:
        """Return a tissue with everything it inherits."""
        written = self._collect(declared, ())
        facts = tuple(self.facts.read(item) for item in written.facts.values())
        given = dict(written.numbers)
        missing: dict[str, str] = {}
        concluded: dict[str, float] = {}
        if written.rules is not None:
            answers = written.rules.base.infer({fact.property: fact.number for fact in facts})
            concluded = {key: a.value for key, a in answers.items() if isinstance(a, Inference)}
            said = self._said(written)
            conclude(
                written.rules, self.vocabulary, answers, said, given, missing, self.findings
            )
            self._check_words(declared, written, facts, answers)
        self._scale_stress(written, given)
        assert isinstance(declared.item, s.Block)
        known = tuple(one for several in written.known.values() for one in several)
        curves = tuple(one for several in written.curves.values() for one in several)
        if FIBRE_MODULUS not in given:
            refuse_fibres(curves, declared.item.head, self.findings)
        warn_of_contradictions(known, given, declared.item.head, self.findings)
        news = self._news(written)
        warn_of_words(news, given, concluded, declared.item.head, self.findings)
        self._warn_of_unusual_numbers(declared.name.text, written, given)
        vocabulary = written.rules.name if written.rules else ""
        return Tissue(
            declared.name.text,
            written.about,
            vocabulary,
            facts,
            given,
            missing,
            concluded,
            written.laws,
            known,
            curves,
            written.appearance,
            declared.item.head,
        )

    @staticmethod
    def _said(written: _Written) -> set[str]:
        """Return the quantities that rules do not conclude because of written entries."""
        said = set(written.numbers)
        if STRETCHED & written.laws.keys():
            said.add(STIFFENING)
        for key, one in written.numbers.items():
            said |= set(replaced_by(key, is_none=one.value == one.quantity.none))
        return said

    def _check_words(
        self,
        declared: Declared,
        written: _Written,
        facts: tuple[PropertyFact, ...],
        answers: Answers,
    ) -> None:
        """Report words that have no effect."""
        assert written.rules is not None and isinstance(declared.item, s.Block)
        inherited = written.inherited or _Written()
        own = {key for key, at in written.facts.items() if at is not inherited.facts.get(key)}
        phrases = {
            key: at.phrase.span
            for key, at in written.facts.items()
            if isinstance(at, s.Sentence) and at.phrase is not None
        }
        words = TissueWords(
            written.rules, self.vocabulary, facts, phrases, answers, self.findings
        )
        words.warn_of_unasked_properties(own)
        words.warn_of_idle_hedges(own)
        changed = {key for key in own if self._is_set(written.facts[key])}
        words.refuse_outdone_ones(changed, declared.name.text, written.numbers, written.left)
        if inherited.numbers:
            before = [self.facts.read(item) for item in inherited.facts.values()]
            words.warn_of_outdone_ones(
                own - changed, before, written.numbers, inherited.numbers
            )

    def _news(self, written: _Written) -> list[KnownQuantity]:
        """Return evidence that accompanies a number for the first time.

        Words that change beside an inherited number are reported in another way, and those that
        are set from outside are compared with numbers.
        """
        inherited = written.inherited or _Written()
        if any(self._is_set(item) for item in written.facts.values()):
            return []
        return [
            one
            for key, several in written.known.items()
            for one in several
            if written.numbers.get(key) is not inherited.numbers.get(key)
            or one not in inherited.known.get(key, ())
        ]

    def _is_set(self, item: s.Sentence | s.Assign) -> bool:
        """Return whether a word is set from outside: by ``--set``, a study or Python."""
        return item.span.source.name == SET or self.scope.is_set(item)

    def _warn_of_unusual_numbers(
        self, name: str, written: _Written, given: Mapping[str, AssignedQuantity]
    ) -> None:
        """W504: a number, written or concluded, that no living tissue has."""
        inherited = written.inherited.numbers if written.inherited else {}
        for key, one in given.items():
            if one is inherited.get(key):
                continue  # reported of the parent
            found = unusual(key, one.value, f"the {one.quantity.name} of {name} is", one.span)
            if found is not None:
                self.findings.extend([found])

    def _scale_stress(self, written: _Written, given: dict[str, AssignedQuantity]) -> None:
        """Set the Young's modulus of a stress where none is written: its slope at rest.

        It replaces the one that rules conclude, unless the stress refers to that.
        """
        law = written.laws.get("spring law")
        stress = None if law is None else stress_in(law.formula)
        if law is None or stress is None or YOUNGS_MODULUS in written.numbers:
            return
        if "spring constant" in given:
            self.findings.reject(
                "TIS306",
                f'"{law.name}" and "spring constant" exclude each other in a tissue',
                law.span,
                hint=leaving_out("remove one of them", law.span, given["spring constant"].span),
                notes=(Note("the other entry", given["spring constant"].span),),
            )
        at_rest = {E.name: 0.0, REST.name: 1.0, MODULUS.name: np.nan}
        slope = float(stress.slope(E.name).at(at_rest))
        if not 0.0 < slope < np.inf:
            if YOUNGS_MODULUS in given:
                return
            self.findings.reject(
                "TIS304",
                "the stiffness of the tissue at rest is missing",
                law.span,
                hint="write a Young's modulus, on which damping and Poisson's ratio depend",
            )
        quantity = QUANTITIES[YOUNGS_MODULUS]
        given[YOUNGS_MODULUS] = AssignedQuantity(
            quantity, slope, quantity.spreads[0], None, "slope of its stress at rest", law.span
        )

    # --- entries ------------------------------------------------------------------------------

    def _collect(self, declared: Declared, chain: tuple[str, ...]) -> _Written:
        """Return the entries of a tissue over those of its parent."""
        block = declared.item
        assert isinstance(block, s.Block)
        if len(chain) > MOST_PARENTS:
            self.findings.reject(
                "TIS116",
                f"more than {MOST_PARENTS} tissues are like one another in a row",
                block.head,
            )
        if declared.name.key in chain:
            circle = " -> ".join([*chain, declared.name.key])
            if self.circles & set(chain):
                self.findings.stop()  # reported at another tissue of the circle
            self.circles |= set(chain)
            self.findings.reject(
                "TIS506", f"circular inheritance of tissues: {circle}", block.head
            )
        written = _Written()
        said: TissueHead = SentenceReader("tissue", _TISSUE, block, self.scope).get()
        if said.like is not None:
            parent = self.declarations.find("tissue", said.like, self.findings)
            written = self._collect(parent, (*chain, declared.name.key)).heir()
        entries: dict[str, Span] = {}
        for item in block.items:
            if isinstance(item, s.Sentence) and item.name.key == "described":
                # First, because every property depends on it; a mistake here ends the tissue.
                written.rules = self._described(item)
        with self.findings.together():
            for item in block.items:
                with self.findings.item():
                    self._entry(item, written, entries, declared)
        return written

    def _entry(
        self, item: s.Item, written: _Written, entries: dict[str, Span], declared: Declared
    ) -> None:
        if isinstance(item, _NAMED) and is_curve(item.name):
            self._curve(item, written, entries)
            return
        law = BY_ENTRY.get(item.name.key) if isinstance(item, _NAMED) else None
        if not isinstance(item, s.Sentence | s.Assign) and law is None:
            hint = f"write {item.name.text} = …" if isinstance(item, s.Function) else ""
            if isinstance(item, s.Rule):
                hint = "rules belong in a block of their own: rules NAME { if … then … }"
            self.findings.reject(
                "TIS303", "this is not allowed in a tissue", item.span, hint=hint
            )
        assert isinstance(item, _NAMED)
        if is_evidence(item.name) and isinstance(item, s.Sentence | s.Assign):
            self._evidence(item, written, entries)
            return
        key = "about" if item.name.words.lower() == "about" else item.name.key
        key = key if law is None else law.word
        if key in entries:
            self.findings.refuse_second(f'"{key}"', item.span, entries[key])
        entries[key] = item.span
        if law is not None:
            written.laws[key] = read = read_law(law, item, self.scope)
            if key in STRETCHED:
                self._refuse_stiffening(item, key, written, entries)
            if stress_in(read.formula) is not None:  # an inherited spring constant is outdone
                for rival in set(rivals(YOUNGS_MODULUS)) - set(entries):
                    written.numbers.pop(rival, None)
            return
        assert isinstance(item, s.Sentence | s.Assign)
        if key == "about" and isinstance(item, s.Sentence):
            written.about = read_text(item, self.scope)
        elif key in APPEARANCE:
            written.appearance = read_appearance(item, written.appearance, self.scope)
        elif key == "described":
            pass  # read before all others
        elif key in QUANTITIES:
            self._replace_rivals(item, key, written, entries)
            if key == STIFFENING:
                self._replace_laws(item, written, entries)
            self._number(item, key, written)
        elif written.rules is not None and key in self.vocabulary.properties:
            written.facts[key] = item
        else:
            self._unknown(item, written.rules, declared)

    def _evidence(
        self, item: s.Sentence | s.Assign, written: _Written, entries: dict[str, Span]
    ) -> None:
        """Add evidence; what the parent has on the same quantity is left out."""
        known = read_known(item, self.scope)
        key, entry = s.key_of(known.quantity.name), f"{KNOWN} {known.quantity.name}"
        if entry not in entries:
            written.known[key] = []
        entries[entry] = item.span
        refuse_contradiction(known, written.known[key], self.findings)
        written.known[key].append(known)

    def _curve(self, item: _NAMED, written: _Written, entries: dict[str, Span]) -> None:
        """Add evidence on a curve; what the parent has on the same curve is left out."""
        known = read_curve(item, self.scope)
        entry = f"{KNOWN} {known.name}"
        if entry not in entries:
            written.curves[known.name] = []
        entries[entry] = item.span
        refuse_crossing(known, written.curves[known.name], self.findings)
        written.curves[known.name].append(known)

    def _replace_rivals(
        self, item: s.Sentence | s.Assign, key: str, written: _Written, entries: dict[str, Span]
    ) -> None:
        """Leave out inherited numbers that say the same; reject one beside the other."""
        is_none = isinstance(item, s.Sentence) and is_word(item, "none")
        for rival in rivals(key):
            if rival in entries and exclude(key, rival):
                self._exclude(
                    item.span, QUANTITIES[rival].name, QUANTITIES[key].name, entries[rival]
                )
            if rival not in entries and rival in replaced_by(key, is_none=is_none):
                written.numbers.pop(rival, None)

    def _refuse_stiffening(
        self, item: _NAMED, law: str, written: _Written, entries: Mapping[str, Span]
    ) -> None:
        """Leave out an inherited stiffening beside a law; reject one of the same tissue."""
        if STIFFENING in entries:
            self._exclude(item.span, STIFFENING, law, entries[STIFFENING])
        written.numbers.pop(STIFFENING, None)

    def _replace_laws(
        self, item: s.Item, written: _Written, entries: Mapping[str, Span]
    ) -> None:
        """Leave out inherited laws beside a stiffening; reject one of the same tissue."""
        for law in STRETCHED:
            if law in entries:
                self._exclude(item.span, law, STIFFENING, entries[law])
            written.laws.pop(law, None)

    def _exclude(self, span: Span, first: str, second: str, other: Span) -> NoReturn:
        self.findings.reject(
            "TIS306",
            f'"{second}" and "{first}" exclude each other in a tissue',
            span,
            hint=leaving_out("remove one of them", span, other),
            notes=(Note("the other entry", other),),
        )

    def _unknown(
        self, item: s.Sentence | s.Assign, rules: RulesBlock | None, declared: Declared
    ) -> NoReturn:
        """Reject an entry that is neither a property of the rules nor a quantity."""
        name = item.name
        self.findings.pass_over_doubtful(name.key)
        known = (
            *self.vocabulary.properties, *LISTED, *BY_ENTRY, KNOWN, "described", "about",
            *APPEARANCE,
        )  # fmt: skip
        hint = alternatives(name.key, known, what="entries")
        if meant := quantity_meant(item):
            hint = alternatives("", known, what="entries")
            hint = Hint(f'did you mean "{meant}"?  {hint}', Edit(meant))
        if rules is not None:
            message = f'"{name.text}" is neither a property of vocabulary {rules.name} '
            self.findings.reject("TIS202", f"{message}nor a quantity", name.span, hint=hint)
        is_worded = isinstance(item, s.Sentence) and item.phrase is not None
        if is_worded and not self.vocabulary.rules and not hint.edits:
            hint = Hint(f"words need rules: {_RULES}")
        if name.key in self.vocabulary.properties:
            names = " or ".join(one.name for one in self.vocabulary.rules.values()) or "…"
            hint = f"it is a property of a vocabulary; insert before it: described in {names}"
        self.findings.refuse_entry(name, f"tissue {declared.name.text}", hint=hint)

    def _described(self, item: s.Sentence) -> RulesBlock:
        said: DescribedWords = SentenceReader("described", _DESCRIBED, item, self.scope).get()
        self.declarations.find("rules", said.rules, self.findings)
        if said.rules.key not in self.vocabulary.rules:
            self.findings.stop()  # the rules themselves were found wrong
        return self.vocabulary.rules[said.rules.key]

    def _number(self, item: s.Sentence | s.Assign, key: str, written: _Written) -> None:
        quantity = QUANTITIES[key]
        if is_word(item, CONCLUDED):
            self._leave_to_rules(item, key, written)
            return
        written.left.discard(key)
        if is_word(item, "none") and quantity.none is not None:
            spread = quantity.spreads[0]
            written.numbers[key] = AssignedQuantity(
                quantity, quantity.none, spread, None, "written", item.span
            )
            return
        if not isinstance(item, s.Assign):
            kind = Real(quantity.dimension)
            name = left_side(item)
            forms = [schema.Entry(name, key, kind, None, "").example]
            if quantity.none is not None:
                forms.append(f"{name} is none")
            hint = f"write {', or '.join(forms)}, or describe the tissue in words"
            self.findings.reject(
                "TIS312",
                f"{key} is a number, not a word",
                item.span,
                hint=Hint(f"{hint} and use rules", *map(Edit, forms)),
            )
        written.numbers[key] = read_given(key, item, self.scope)

    def _leave_to_rules(self, item: s.Sentence | s.Assign, key: str, written: _Written) -> None:
        """Leave out an inherited number, so that words count."""
        rules = written.rules
        if rules is None or key not in rules.concluded:
            message = (
                f"no rule of {rules.name} concludes {QUANTITIES[key].name}"
                if rules is not None
                else "nothing is concluded without words: described in … is missing"
            )
            name, kind = left_side(item), Real(QUANTITIES[key].dimension)
            hint = f"write {schema.Entry(name, key, kind, None, '').example}"
            self.findings.reject("TIS312", message, item.span, hint=hint)
        written.numbers.pop(key, None)
        written.left.add(key)


def is_word(item: s.Sentence | s.Assign, word: str) -> bool:
    """Return whether an entry consists of a certain word: ``breaking force is none``."""
    if not isinstance(item, s.Sentence) or item.phrase is None or item.clauses:
        return False
    return item.phrase.kind == "word" and item.phrase.words[0].key == word
