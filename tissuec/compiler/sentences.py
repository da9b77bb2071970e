"""The sentences of a script, as their verbs read them."""

from collections.abc import Mapping, Sequence
from typing import NoReturn

from tissuec.compiler.clauses import ClauseReader
from tissuec.compiler.profiles import read_profiles
from tissuec.compiler.sets import Groups
from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.model.profiles import TimeProfile
from tissuec.scene.expressions import Scope
from tissuec.scene.members import HOLDING
from tissuec.scene.model import Tool
from tissuec.script.tools import ToolKind
from tissuec.script.verbs import Group, Mover


class SentenceOrder(ClauseReader):
    """An ``Order`` (see ``tissuec.script.verbs``) over a syntax node."""

    def __init__(
        self, sentence: s.Sentence, verb: str, forms: tuple[str, ...], duration: float | None,
        groups: Groups, tools: Mapping[str, Tool], scope: Scope,
    ):  # fmt: skip
        super().__init__(sentence, verb, forms, duration, scope)
        self.groups = groups
        self.tools = tools

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
        self._reject_misspelt_tool(name)
        group = self.groups.nodes(name)
        return Mover(group.name, group.indices)

    def _reject_misspelt_tool(self, name: s.Name) -> None:
        """Reject a name that is no set and looks like that of a tool."""
        names = [tool.name for tool in self.tools.values()]
        if not self.groups.is_known(name) and did_you_mean(name.text, names):
            self._reject_tool(name, f'there is no set or tool called "{name.text}"')

    def _reject_tool(self, name: s.Name, message: str) -> NoReturn:
        self.scope.findings.pass_over_doubtful(name.key)
        names = [tool.name for tool in self.tools.values()]
        self.groups.refuse_parted(name, names)
        hint = alternatives(name.text, names, what="tools")
        self.scope.findings.reject("TIS301", message, name.span, hint=hint)

    def is_tool(self) -> bool:
        if self.object.key in self.tools:
            return True
        self._reject_misspelt_tool(self.object)
        return False

    def tool(self, word: str, *, kinds: Sequence[str] = ()) -> str | None:
        if not self.has(word):
            return None
        name = self._name(word)
        if name.key not in self.tools:
            self._reject_tool(name, f'there is no tool called "{name.text}"')
        tool = self.tools[name.key]
        if kinds:
            self._check_kind(tool, kinds, word, self.clauses[word].span)
        return tool.name

    def entries_of_tool(self, word: str, kind: str) -> ToolKind:
        if self.tool(word, kinds=(kind,)) is None:
            self.reject("TIS304", f'{self.verb} needs "{word}"')
        entries = self.tools[self._name(word).key].entries
        if entries is None:
            self.scope.findings.stop()
        return entries

    def _check_kind(self, tool: Tool, kinds: Sequence[str], before: str, span: Span) -> None:
        """Reject a tool of other kinds; the hint names those that fit, behind ``before``."""
        if any(map(tool.may_be, kinds)):
            return
        fitting = [f"{before} {t.name}" for t in self.tools.values() if t.kind in kinds]
        kind = HOLDING if HOLDING in kinds else kinds[0]
        written = " or ".join(f'"{name}"' for name in fitting)
        self.scope.findings.reject(
            "TIS405",
            f"{self.verb} needs a tool of kind {' or '.join(kinds)}; "
            f'"{tool.name}" has kind {tool.kind}',
            span,
            hint=Hint(f"write {written}", *map(Edit, fitting))
            if fitting
            else f"declare one: tool {kind} {{ kind is {kind} }}",
        )

    def profiles(self, *, default: str, columns: int = 1) -> tuple[TimeProfile, ...]:
        # "along" a direction belongs to a force, "along table" to a path.
        along = self.clauses["along"].value if "along" in self.clauses else None
        is_path = isinstance(along, s.Name) and along.words == "table"
        if is_path and "using" in self.clauses:
            hint = Hint('remove "using"', Edit(""))
            self.reject("TIS306", "a path in a table has no profile", hint=hint, word="using")
        word = "along" if is_path else "using"
        self.asked.add(word)
        return read_profiles(self.clauses.get(word), default, columns, self)
