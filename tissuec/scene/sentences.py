"""Sentences outside of blocks that are about meshes: sets, tables and expectations."""

from typing import Annotated, NoReturn, TypeAlias

from msgspec import Struct

from tissuec.core.errors import enumerated
from tissuec.core.hints import did_you_mean, proposal
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, TIME
from tissuec.lang import syntax as s
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import SCENE, block, declare
from tissuec.script.forms import VerbForm, VerbSentence, brief_texts
from tissuec.script.parts import (
    BODY,
    SPRINGS,
    ChoiceClause,
    ConditionClause,
    NameClause,
    Placeholder,
    UnionClause,
    UnitClause,
    ValueClause,
    new_name,
)

#: What sets are chosen from, and what tables contain.
KINDS = ("nodes", "springs")

Name = Annotated[s.Name, new_name("set", "set")]
Ids = Annotated[s.Expression | None, ValueClause("in", place="LIST")]
Where = Annotated[s.Expression | None, ConditionClause("where", place="CONDITION")]


class ChosenNodes(VerbSentence, frozen=True):
    """A set of nodes of bodies."""

    name: Name
    kind: Annotated[str, ChoiceClause("=", {"nodes": "Nodes of a body."})]
    of: Annotated[tuple[s.Name, ...], NameClause("of", places=(BODY,), listed=True)]
    ids: Ids
    where: Where


class ChosenSprings(VerbSentence, frozen=True):
    """A set of springs of bodies and joints."""

    name: Name
    kind: Annotated[str, ChoiceClause("=", {"springs": "Springs of a body or joint."})]
    of: Annotated[
        tuple[s.Name, ...],
        NameClause("of", places=(Placeholder("BODY", ("body", "joint")),), listed=True),
    ]
    ids: Ids
    where: Where


class UnionWords(VerbSentence, frozen=True):
    """A set of all that is in others."""

    name: Name
    union: Annotated[s.Name, UnionClause("=", places=(SPRINGS,))]


SetWords: TypeAlias = ChosenNodes | ChosenSprings | UnionWords
SET_KIND = SentenceKind((ChosenNodes, ChosenSprings, UnionWords), wrong="wrong form of a set")
declare(
    "set", "A named set of nodes or springs, selected on the mesh as drawn.", 52, "sentence",
    sentences=SET_KIND.forms, names=SCENE,
)  # fmt: skip


class _SetReader(SentenceReader):
    """Reads one set."""

    def choose(self) -> VerbForm:
        fitting = next((form for form in self.forms if self.has_all(form)), None)
        return fitting or self.reject_form()

    def refuse(self, clause: s.Clause) -> NoReturn:
        self.reject_form()

    def reject_form(self) -> NoReturn:
        assert isinstance(self.sentence, s.Assign)
        value = self.sentence.value
        kind = value.key if isinstance(value, s.Name) else ""
        texts = (text.partition(" = ")[2] for text in brief_texts("set", SET_KIND.forms))
        hint: str = f"forms: {', '.join(texts)}"
        near = did_you_mean(kind.split(" ")[-1], KINDS)
        meant = near.edits[0].text if near else kind.split(" ")[-1]
        if meant in KINDS and kind != meant:
            hint = proposal(meant)
        elif {"from", "to"} <= self.clauses.keys():
            hint = "for example: nodes of BODY where x between 1 mm and 2 mm"
        self.scope.findings.reject("TIS312", self.kind.wrong, value.span, hint=hint)


def read_set(item: s.Assign, scope: Scope) -> SetWords:
    """Read the sentence of a set, or reject it."""
    return _SetReader("set", SET_KIND, item, scope).get()


_KIND = Placeholder("nodes", words=KINDS)
_COLUMNS = Placeholder(
    "columns", words=("columns",), about='The columns of the table: with columns "id x y z".'
)


class TableWords(VerbSentence, frozen=True):
    """The head of a table."""

    kind: Annotated[s.Name, NameClause("", what="kind of table", places=(_KIND,))]
    body: Annotated[
        s.Name,
        NameClause("of", what="body of the table", places=(BODY,), example="of net"),
    ]
    unit: Annotated[Span | None, UnitClause("in", LENGTH, place="UNIT")]
    columns: Annotated[
        s.Name,
        NameClause(
            "with", what="list of columns", places=(_COLUMNS,),
            example='with columns "id x y z"',
        ),
    ]  # fmt: skip


TABLE_KIND = SentenceKind((TableWords,))
declare(
    "table", "Nodes or springs of an explicit mesh, one per row.", 53, "sentence",
    sentences=TABLE_KIND.forms,
)  # fmt: skip


class WrittenTable(Struct, frozen=True):
    """The head and the rows of a table in a text.

    Attributes:
        said: Its head.
        rows: With the text of the rows.
        header: The clause with its columns.
    """

    said: TableWords
    rows: s.Table
    header: Span


Condition = Annotated[s.Expression, ConditionClause("", place="CONDITION")]


class ExpectedAt(VerbSentence, frozen=True):
    """What is expected at a time."""

    condition: Condition
    time: Annotated[s.Expression, ValueClause("at", dimension=TIME, place="TIME")]


class ExpectedWithin(VerbSentence, frozen=True):
    """What is expected in an interval."""

    condition: Condition
    start: Annotated[s.Expression, ValueClause("from", dimension=TIME, place="TIME")]
    stop: Annotated[s.Expression, ValueClause("to", dimension=TIME, place="TIME")]


class ExpectedUntil(VerbSentence, frozen=True):
    """What is expected from the beginning to a time."""

    condition: Condition
    stop: Annotated[s.Expression, ValueClause("until", dimension=TIME, place="TIME")]


class ExpectedOver(VerbSentence, frozen=True):
    """What is expected all the time."""

    condition: Condition
    over: Annotated[str, ChoiceClause("over", {"run": "The whole run."}, what="interval")]


ExpectWords: TypeAlias = ExpectedAt | ExpectedWithin | ExpectedUntil | ExpectedOver
EXPECT_KIND = SentenceKind((ExpectedAt, ExpectedWithin, ExpectedUntil, ExpectedOver))
declare(
    "expect",
    "An expected result; a failed expectation is reported after the run.", 54, "sentence",
    sentences=EXPECT_KIND.forms,
)  # fmt: skip


class _ExpectReader(SentenceReader):
    """Reads one expectation of a run."""

    def choose(self) -> VerbForm:
        for form in self.forms:
            if self.clauses.keys() == {word for word, *_ in form.clauses if word}:
                return form
        ends = (text.partition("CONDITION ")[2] for text in self.texts)
        hint = f"end with: {enumerated(ends, 'or')}"
        self.reject("TIS304", "the time of the expectation is missing", hint=hint)


def read_expect(item: s.Expect, scope: Scope) -> ExpectWords:
    """Return the condition and the time of an expectation, or reject it."""
    return _ExpectReader("expect", EXPECT_KIND, item, scope).get()


declare(
    "script", "Actions at given times or conditions.", 41, "single",
    block=block({}),
)  # fmt: skip
