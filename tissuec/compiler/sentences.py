"""The sentences of a script, as their verbs read them."""

from collections.abc import Container, Mapping
from typing import NoReturn

import numpy as np

from tissuec.compiler.profiles import read_profiles
from tissuec.compiler.sets import Groups
from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, Dimension
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile
from tissuec.scene.expressions import Scope
from tissuec.scene.model import Tool
from tissuec.scene.values import Value, unit_vector
from tissuec.script.tools import ToolKind
from tissuec.script.verbs import Group, Mover


class SentenceOrder:
    """An ``Order`` (see ``tissuec.script.verbs``) over a syntax node."""

    def __init__(
        self, sentence: s.Sentence, verb: str, forms: tuple[str, ...], duration: float | None,
        groups: Groups, tools: Mapping[str, Tool], scope: Scope,
    ):  # fmt: skip
        self.sentence = sentence
        self.verb = verb
        self.forms = forms
        self.duration = duration
        self.groups = groups
        self.tools = tools
        self.scope = scope
        self.span: Span = sentence.span
        self.object = _behind(sentence.name, verb)
        self.words = self.object.text
        self.clauses: dict[str, s.Clause] = {}
        self.asked: set[str] = set()
        for clause in sentence.clauses:
            if clause.word in self.clauses:
                scope.findings.reject("TIS307", f'"{clause.word}" is given twice', clause.span)
            self.clauses[clause.word] = clause

    def finish(self) -> None:
        """Reject clauses that the verb did not ask for."""
        for word, clause in self.clauses.items():
            if word not in self.asked:
                form = Hint(f"write: {self._nearest_form()}", Edit(""))
                message = f'{self.verb} does not take "{word}"'
                self.reject("TIS303", message, hint=form, word=clause.word)

    def reject(
        self, code: str, message: str, *, hint: str = "", word: str | None = None
    ) -> NoReturn:
        span = self.clauses[word].span if word in self.clauses else self.span
        self.scope.findings.reject(
            code,
            message,
            span,
            hint=hint or f"write: {self._nearest_form()}",
        )

    def _nearest_form(self) -> str:
        """Return the form of the verb that shares most words with the sentence."""
        written = set(self.span.text.split())
        return max(self.forms, key=lambda form: len(written & set(form.split())))

    def has(self, word: str) -> bool:
        self.asked.add(word)
        return word in self.clauses

    def nodes(self, *, after: str = "") -> Group:
        name = self._object(after)
        if name.key in self.tools and not self.groups.is_known(name):
            self.scope.findings.reject(
                "TIS301",
                f'"{name.text}" is a tool, and {self.verb} takes a set or a body',
                name.span,
                hint="a tool stays where it is until it is moved or turned",
            )
        return self.groups.nodes(name)

    def nodes_of(self, word: str) -> Group:
        return self.groups.nodes(self._name(word))

    def springs(self) -> Group:
        return self.groups.springs(self._object(""))

    def springs_of(self, word: str) -> Group:
        return self.groups.springs(self._name(word))

    def names_springs(self) -> bool:
        return self.groups.is_springs(self._object(""))

    def mover(self, *, after: str = "") -> Mover:
        name = self._object(after)
        if name.key in self.tools:
            tool = self.tools[name.key]
            if not tool.holds_nodes:
                self.scope.findings.reject(
                    "TIS405",
                    f'"{tool.name}" ({tool.kind}) has no shape and holds '
                    f"nothing, so there is nothing to {self.verb}",
                    name.span,
                    hint="name a tool with a shape, forceps that have grasped something, or "
                    "a set",
                )
            return Mover(tool.name, None)
        names = [tool.name for tool in self.tools.values()]
        if not self.groups.is_known(name) and did_you_mean(name.text, names):
            self.scope.findings.pass_over_doubtful(name.key)
            self.scope.findings.reject(
                "TIS301",
                f'there is no set or tool called "{name.text}"',
                name.span,
                hint=alternatives(name.text, names, what="tools"),
            )
        group = self.groups.nodes(name)
        return Mover(group.name, group.indices)

    def is_tool(self) -> bool:
        return self.object.key in self.tools

    def tool(self, word: str, *, kind: str | None = None) -> str | None:
        if not self.has(word):
            return None
        name = self._name(word)
        if name.key not in self.tools:
            self.scope.findings.pass_over_doubtful(name.key)
            names = [tool.name for tool in self.tools.values()]
            self.scope.findings.reject(
                "TIS301",
                f'there is no tool called "{name.text}"',
                name.span,
                hint=alternatives(name.text, names, what="tools"),
            )
        tool = self.tools[name.key]
        if kind is not None:
            self._check_kind(tool, kind, word, self.clauses[word].span)
        return tool.name

    def entries_of_tool(self, word: str, kind: str) -> ToolKind:
        if self.tool(word, kind=kind) is None:
            self.reject("TIS304", f'{self.verb} needs "{word}"')
        entries = self.tools[self._name(word).key].entries
        if entries is None:
            self.scope.findings.stop()
        return entries

    def _check_kind(self, tool: Tool, kind: str, before: str, span: Span) -> None:
        """Reject a tool of another kind; the hint names those that fit, behind ``before``."""
        if tool.may_be(kind):
            return
        fitting = [f"{before} {t.name}" for t in self.tools.values() if t.kind == kind]
        written = " or ".join(f'"{name}"' for name in fitting)
        self.scope.findings.reject(
            "TIS405",
            f'{self.verb} needs a tool of kind {kind}; "{tool.name}" has kind {tool.kind}',
            span,
            hint=Hint(f"write {written}", *map(Edit, fitting))
            if fitting
            else f"declare one: tool {kind} {{ kind is {kind} }}",
        )

    def vector(self, word: str, dimension: Dimension) -> Floats:
        value = self._value(word)
        if not value.is_vector:
            self.reject("TIS312", f"{word} needs a vector (x, y, z)", word=word)
        if np.any(value.amount) or not value.is_literal:
            self.scope.expect(
                value,
                dimension,
                self.clauses[word].value.span,
                what=f"the value after {word}",
            )
        return value.amount

    def number(self, word: str, dimension: Dimension) -> float:
        value = self._value(word)
        if value.is_vector:
            self.reject("TIS312", f"{word} needs a number, not a vector", word=word)
        self.scope.expect(
            value, dimension, self.clauses[word].value.span, what=f"the value after {word}"
        )
        return float(value.amount)

    def direction(self, word: str) -> Floats:
        value = self._value(word)
        if not value.is_vector or value.dimension != NUMBER:
            self.reject(
                "TIS312",
                f"{word} needs a direction without a unit, such as (0, 0, 1)",
                word=word,
            )
        direction = unit_vector(value.amount)
        if direction is None:
            self.reject("TIS308", "a direction cannot be (0, 0, 0)", word=word)
        return direction

    def is_vector(self, word: str) -> bool:
        return self._value(word).is_vector

    def word(self, word: str, choices: Container[str]) -> str | None:
        value = self.clauses[word].value if word in self.clauses else None
        if not isinstance(value, s.Name) or value.key not in choices:
            return None
        self.asked.add(word)
        return value.key

    def text(self, word: str) -> str:
        return self._name(word).text

    def profiles(self, *, default: str, columns: int = 1) -> tuple[TimeProfile, ...]:
        # "along" a direction belongs to a force, "along table" to a path.
        along = self.clauses["along"].value if "along" in self.clauses else None
        is_path = isinstance(along, s.Name) and along.words == "table"
        word = "along" if is_path and "using" not in self.clauses else "using"
        self.asked.add(word)
        return read_profiles(self.clauses.get(word), default, columns, self)

    def _object(self, after: str) -> s.Name:
        name = _behind(self.object, after) if after else self.object
        if not name.text:
            self.reject("TIS304", f"the object of {self.verb} is missing")
        return name

    def _clause(self, word: str) -> s.Clause:
        if not self.has(word):
            self.reject("TIS304", f'{self.verb} needs "{word}"')
        return self.clauses[word]

    def _name(self, word: str) -> s.Name:
        value = self._clause(word).value
        if not isinstance(value, s.Name):
            self.reject("TIS312", f"{word} needs a name", word=word)
        return value

    def _value(self, word: str) -> Value:
        return self.scope.evaluate(self._clause(word).value)


def _behind(name: s.Name, prefix: str) -> s.Name:
    """Return the name without its leading words; the prefix is known to be there."""
    count = len(prefix.split())
    rest = " ".join(name.words.split(" ")[count:])
    if not rest and name.quoted is None:
        return s.Name("", None, name.span)
    marker = rest or f'"{name.quoted}"'
    start = name.span.text.find(marker, len(prefix))
    span = Span(name.span.source, name.span.start + max(start, 0), name.span.end)
    return s.Name(rest, name.quoted, span)
