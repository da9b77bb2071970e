"""The sentences of a script: what in them needs a network, tools or tables."""

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn, TypeGuard

import numpy as np

from tissuec.compiler.script.profiles import read_profiles
from tissuec.compiler.sets import Groups
from tissuec.core.errors import enumerated
from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.lang.walk import is_number
from tissuec.model.profiles import TimeProfile
from tissuec.scene.members import HOLDING
from tissuec.scene.model import Tool
from tissuec.scene.reading.clauses import ClauseReader
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import PATH, VerbSentence, forms_of, text_of
from tissuec.script.parts import (
    ClausePart,
    DirectedClause,
    Part,
    ProfileClause,
    SubjectPart,
    ToolClause,
    VectorClause,
)
from tissuec.script.tools import kinds_in
from tissuec.script.verbs import Action, Group, Mover

#: Words for directions, as signs of z.
_DIRECTIONS = {
    "up": 1, "upward": 1, "upwards": 1, "down": -1, "downward": -1, "downwards": -1,
}  # fmt: skip


class SentenceOrder(ClauseReader):
    """An ``Order`` (see ``tissuec.script.verbs``) over a syntax node.

    Args:
        sentence: The syntax node.
        verb: Its verb.
        duration: Time from its beginning to its end [s]; None without an interval.
        groups: Sets and bodies by name.
        tools: Tools by name.
        scope: Names and findings of the scene.
    """

    def __init__(
        self, sentence: s.Sentence, verb: str, duration: float | None,
        groups: Groups, tools: Mapping[str, Tool], scope: Scope,
    ):  # fmt: skip
        super().__init__(sentence, verb, forms_of(verb), scope, duration)
        self.groups = groups
        self.tools = tools

    def action(self) -> Action:
        """Return the action of the sentence."""
        self._refuse_direction()
        said = self.read()
        action = said.action(self)
        self.finish()
        self._doubt_zeros(said)
        return action

    def names_springs(self) -> bool:
        return self.groups.is_springs(self.object)

    def read_other(self, part: Part, *, is_optional: bool) -> Any:
        if isinstance(part, ProfileClause):
            return self._profile(part)
        if not isinstance(part, SubjectPart | ToolClause):
            return super().read_other(part, is_optional=is_optional)
        if is_optional and not (self.has(part.word) if part.word else self.object.text):
            return None
        name = self.names_in(part.word) if part.word else self.object
        if isinstance(part, ToolClause) or part.alone:
            self.one(name, part.word or self.verb)
        if isinstance(part, ToolClause):
            return self._tool(name, part)
        match part.kind:
            case "nodes":
                return self._nodes(name, is_object=not part.word)
            case "springs":
                return self.groups.springs(name)
            case "moved":
                return self._mover(name)

    def _refuse_direction(self) -> None:
        """Reject ``move tip down by 3 mm`` and ``pull tip up with 1 N``, with a vector."""
        name, _, word = self.object.text.rpartition(" ")
        axis = _DIRECTIONS.get(word.lower())
        is_name = self.groups.is_known(self.object) or self.object.key in self.tools
        if axis is None or not name or self.object.quoted is not None or is_name:
            return
        parts = [part for form in self.forms for part in form.parts.values()]
        part = next((p for p in parts if self._is_amount(p)), None)
        if part is None:
            return
        clause, sign = self.clauses[part.word], "-" if axis < 0 else ""
        place = Span(self.span.source, self.object.span.end - len(word), clause.span.end)
        amount = clause.value.span.text
        if sign and isinstance(clause.value, s.Sum | s.Signed):
            amount = f"({amount})"
        if isinstance(part, DirectedClause):
            text = f"{part.word} {amount} {part.along} (0, 0, {sign}1)"
        else:
            text = f"{part.word} (0, 0, {sign}{amount})"
            has_profile = any(isinstance(one, ProfileClause) for one in parts)
            if has_profile and not self.clauses.keys() - {part.word}:
                text += " using smooth profile"
        hint = Hint(f'write "{text}"', Edit(text, place))
        message = f'a direction is a vector, not "{word}"'
        self.scope.findings.reject("TIS312", message, place, hint=hint)

    def _is_amount(self, part: Part) -> TypeGuard[VectorClause | DirectedClause]:
        """Return whether a number is written where a vector can be."""
        if not isinstance(part, VectorClause | DirectedClause) or part.word not in self.clauses:
            return False
        has_direction = isinstance(part, DirectedClause) and part.along in self.clauses
        return not has_direction and not isinstance(self.clauses[part.word].value, s.Vector)

    def _doubt_zeros(self, said: VerbSentence) -> None:
        """Warn of amounts that are written as 0, so that nothing moves.

        Names, repetitions and what a program composes may be 0 for once.
        """
        for name, part in self.form.parts.items():
            amount = getattr(said, name) if part.moves else None
            if amount is None or np.any(amount) or not isinstance(part, ClausePart):
                continue
            clause = self.clauses[part.word]
            varies = clause.span.repetition or clause.span.source.is_composed
            if varies or not is_number(clause.value):
                continue
            example = part.example
            if isinstance(part, DirectedClause) and part.along in self.clauses:
                example = example.partition(f" {part.along} ")[0]
            self.scope.findings.add(
                "W417",
                f"the {part.what} is 0, so this moves nothing",
                clause.span,
                hint=Hint(
                    f"remove it, or write another one, for example: {example}",
                    Edit(example, clause.span),
                ),
            )

    # --- sets, bodies and tools ---------------------------------------------------------------

    def _nodes(self, name: s.Name, *, is_object: bool) -> Group:
        if is_object and name.key in self.tools and not self.groups.is_known(name):
            self.scope.findings.reject(
                "TIS301",
                f'"{name.text}" is a tool, and {self.verb} takes a set or a body',
                name.span,
                hint="a tool stays where it is until it is moved or turned",
            )
        return self.groups.nodes(name)

    def _mover(self, name: s.Name) -> Mover:
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
            self._reject_tool(name, f'there is no set or tool called "{name.text}"')
        group = self.groups.nodes(name)
        return Mover(group.name, group.indices)

    def _reject_tool(self, name: s.Name, message: str) -> NoReturn:
        self.scope.findings.pass_over_doubtful(name.key)
        names = [tool.name for tool in self.tools.values()]
        self.groups.refuse_parted(name, names)
        hint = alternatives(name.text, names, what="tools")
        self.scope.findings.reject("TIS301", message, name.span, hint=hint)

    def _tool(self, name: s.Name, part: ToolClause) -> Any:
        """Return the name of a tool, or its entries."""
        if name.key not in self.tools:
            self._reject_tool(name, f'there is no tool called "{name.text}"')
        tool = self.tools[name.key]
        kinds = kinds_in(part.kind)
        place = self.clauses[part.word].span if part.word else name.span
        self._check_kind(tool, kinds, part.word, place)
        if not part.entries:
            return tool.name
        if tool.entries is None:
            self.scope.findings.stop()
        return tool.entries

    def _check_kind(self, tool: Tool, kinds: Sequence[str], before: str, span: Span) -> None:
        """Reject a tool of other kinds; the hint names those that fit, after ``before``."""
        if any(map(tool.may_be, kinds)):
            return
        fitting = [f"{before} {t.name}".strip() for t in self.tools.values() if t.kind in kinds]
        kind = HOLDING if HOLDING in kinds else kinds[0]
        written = " or ".join(f'"{name}"' for name in fitting)
        either = enumerated(kinds, "or")
        self.scope.findings.reject(
            "TIS405",
            f'{self.verb} needs a tool of kind {either}; "{tool.name}" has kind {tool.kind}',
            span,
            hint=Hint(f"write {written}", *map(Edit, fitting))
            if fitting
            else f"declare one: tool {kind} {{ kind is {kind} }}",
        )

    # --- profiles -----------------------------------------------------------------------------

    def _profile(self, part: ProfileClause) -> Any:
        default = part.at_once if self.duration is None else part.over
        if default is None:
            return None
        if not part.path:
            return self._profiles(default, 1)[0]
        is_shift = part.path in self.clauses
        if is_shift and "in" in self.clauses:
            shift = text_of(self.verb, self.form)
            path = shift.replace(f"{part.path} VECTOR using PROFILE", f"along {PATH}")
            message = "a motion has a vector or a path in a table, not both"
            self.reject("TIS306", message, hint=f"write: {shift} or: {path}", word="in")
        profiles = self._profiles(default, 1 if is_shift else 3)
        if not is_shift and profiles[0].kind != "table":
            vector = self.form.of_word(part.path)
            assert vector is not None
            self.missing(vector)
        return profiles

    @property
    def _is_along_path(self) -> bool:
        """Return whether "along" precedes a table with a path instead of a direction."""
        along = self.clauses["along"].value if "along" in self.clauses else None
        return isinstance(along, s.Name) and along.words == "table"

    def has(self, word: str) -> bool:
        return super().has(word) and not (word == "along" and self._is_along_path)

    def _profiles(self, default: str, columns: int) -> tuple[TimeProfile, ...]:
        self._lasts = True
        is_path = self._is_along_path
        if is_path and "using" in self.clauses:
            hint = Hint('remove "using"', Edit(""))
            self.reject("TIS306", "a path in a table has no profile", hint=hint, word="using")
        word = "along" if is_path else "using"
        self.asked.add(word)
        profiles = read_profiles(self.clauses.get(word), default, columns, self)
        if not default:
            self._refuse_jump(profiles)
        return profiles

    def _refuse_jump(self, profiles: tuple[TimeProfile, ...]) -> None:
        """Reject a path that begins elsewhere than where the nodes are."""
        if all(profile.at(profile.start)[0] == 0.0 for profile in profiles):
            return
        hint: str = "change the first value to 0"
        if profiles[0].kind == "constant":
            smooth = [Edit(f"using {name}") for name in ("constant speed", "smooth profile")]
            hint = Hint("write using constant speed, or using smooth profile", *smooth)
        message = "this motion begins with a jump: its first value is not 0"
        word = "using" if "using" in self.clauses else None
        self.reject("TIS306", message, hint=hint, word=word)
