"""The script: timed sentences to a plan of actions, ``when`` conditions to triggers."""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct, field

from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.script.profiles import profiles_of, table_times
from tissuec.compiler.script.sentences import SentenceOrder
from tissuec.compiler.sets import Groups
from tissuec.core.hints import Edit, Hint, alternatives, proposal
from tissuec.core.source import Span
from tissuec.core.units import TIME, show, show_apart
from tissuec.lang import syntax as s
from tissuec.scene.model import Tool
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import synonyms
from tissuec.script.plan import ScheduledAction, Trigger
from tissuec.script.verbs import VERBS, Action

MOST_REPETITIONS = 100_000


class Script(Struct):
    """The events in order of time (at one time: as written) and the triggers.

    Attributes:
        is_whole: Whether nothing was left out because it is wrong.
    """

    events: list[ScheduledAction] = field(default_factory=list[ScheduledAction])
    triggers: list[Trigger] = field(default_factory=list[Trigger])
    is_whole: bool = True


class _Slot(Struct, frozen=True):
    """When the sentences of a block happen."""

    start: float  # [s], absolute or after the trigger
    duration: float | None
    is_outermost: bool = False


def _with_time_first(item: s.Sentence) -> str:
    """Return a sentence behind its time, which may be written at its end: "fix left at 1 s"."""
    text, times = item.span.text, ""
    for clause in reversed(item.clauses):
        if clause.word not in ("at", "from", "to") or not isinstance(clause.value, s.Quantity):
            break
        times = f"{clause.span.text} {times}".rstrip()
        text = text[: clause.span.start - item.span.start].rstrip()
    word = times.partition(" ")[0]
    is_time = word == "at" or (word == "from" and " to " in times)
    return f"{times}: {text}" if is_time else f"at 0 s: {item.span.text}"


class ScriptReader:
    """Reads the items of a script block."""

    def __init__(
        self,
        groups: Groups,
        tools: Mapping[str, Tool],
        conditions: Conditions,
        scope: Scope,
        *,
        duration: float,
    ):
        self.groups = groups
        self.tools = tools
        self.conditions = conditions
        self.scope = scope
        self.findings = scope.findings
        self.duration = duration
        self.repetitions = 0.0
        self.times: dict[int, float] = {}
        self.actions: dict[tuple[int, float | None], Action] = {}
        self.late: set[Span] = set()  # times of which it was said that the run ends before

    def read(self, items: Sequence[s.Item]) -> Script:
        """Return the orders of the items; each error rejects one sentence only."""
        script, failures = Script(), self.findings.failures
        outermost = _Slot(0.0, None, is_outermost=True)
        for item in items:
            with self.findings.item():
                if isinstance(item, s.Timed) and item.trigger is not None:
                    script.triggers.append(self._trigger(item, item.trigger))
                else:
                    self._item(item, outermost, script.events)
        script.events.sort(key=lambda event: event.time)
        script.is_whole = self.findings.failures == failures
        return script

    def _trigger(self, item: s.Timed, condition: s.Expression) -> Trigger:
        events: list[ScheduledAction] = []
        self._body(item.body, _Slot(0.0, None), events)
        events.sort(key=lambda event: event.time)
        return Trigger(self.conditions.condition(condition), tuple(events), item.head)

    def _item(self, item: s.Item, slot: _Slot, events: list[ScheduledAction]) -> None:
        match item:
            case s.Timed(trigger=None):
                failures = self.findings.failures
                for inner in self._slots(item, slot):
                    self._body(item.body, inner, events)
                    if self.findings.failures > failures:
                        break  # what is wrong once is wrong in each repetition
            case s.Timed():
                self.findings.reject(
                    "TIS303",
                    "when is not allowed inside a timed block",
                    item.head,
                    hint="write it at the top level of the script",
                )
            case s.RecordedCall(call=s.Call(arguments=(one,))):
                action = f"{item.name.text} {one.span.one_line}"
                hint = Hint(f'write "{action}"', Edit(action, item.call.span))
                message = "an action has no parentheses"
                self.findings.reject("TIS312", message, item.call.span, hint=hint)
            case s.RecordedCall(call=s.Call(arguments=arguments)):
                names = ", ".join(one.span.one_line for one in arguments)
                action = f"{item.name.text} [{names}]"
                hint = Hint(f'write "{action}"', Edit(action, item.call.span))
                message = "several sets are a list in brackets"
                self.findings.reject("TIS312", message, item.call.span, hint=hint)
            case s.Sentence() if not slot.is_outermost:
                # One action serves all repetitions: it knows how long it lasts, not when.
                key = (id(item), slot.duration)
                if key not in self.actions:
                    self.actions[key] = self._action(item, slot.duration)
                self._check_tables(item, self.actions[key], slot)
                events.append(ScheduledAction(slot.start, self.actions[key]))
            case s.Sentence():
                timed = _with_time_first(item)
                self.findings.reject(
                    "TIS304",
                    "the time is missing",
                    item.span,
                    hint=Hint(f"for example: {timed}", Edit(timed)),
                )
            case _:
                self.findings.reject(
                    "TIS303",
                    "this is not allowed in a script",
                    item.span,
                    hint="a script contains times with actions, for example: at 0 s: fix …",
                )

    def _body(
        self, items: Sequence[s.Item], slot: _Slot, events: list[ScheduledAction]
    ) -> None:
        for item in items:
            with self.findings.item():
                self._item(item, slot, events)

    # --- times --------------------------------------------------------------------------------

    def _slots(self, item: s.Timed, outer: _Slot) -> list[_Slot]:
        words = [clause.word for clause in item.times]
        self._refuse_other_intervals(item, words)
        times = [self._time(clause.value) for clause in item.times]
        if outer.is_outermost and words == ["at"]:
            return [self._checked(item, _Slot(times[0], None))]
        if not outer.is_outermost and words == ["after"]:
            return [self._checked(item, _Slot(outer.start + times[0], None))]
        if words[:2] == ["from", "to"] and (len(words) == 2 or words[2:] == ["every"]):
            start, stop = outer.start + times[0], outer.start + times[1]
            if stop <= start:
                first, last = (clause.value.span.text for clause in item.times[:2])
                what, hint = "ends before it begins", proposal(f"from {last} to {first}")
                if stop == start:
                    what = "has no length"
                    text = f'write "at {first}" for an instantaneous action'
                    hint = Hint(text, Edit(f"at {first}"))
                self.findings.reject(
                    "TIS403",
                    f"the interval from {first} to {last} {what}",
                    item.times[0].span.to(item.times[1].span),
                    hint=hint,
                )
            if len(words) == 2:
                return [self._checked(item, _Slot(start, times[1] - times[0]))]
            return [
                self._checked(item, slot)
                for slot in self._repetitions(item, start, stop, times[2])
            ]
        allowed = (
            '"at T:", "from T to T:"' if outer.is_outermost else '"after T:", "from T to T:"'
        )
        self.findings.reject(
            "TIS403",
            "this form of time is not allowed here",
            item.head,
            hint=self._time_meant(item, outer.is_outermost)
            or f'allowed: {allowed} or "from T to T every T:"',
        )

    def _time_meant(self, item: s.Timed, is_outermost: bool) -> Hint | str:
        """Return a hint with the time that can be meant, or an empty one."""
        texts = {clause.word: clause.value.span.text for clause in item.times}
        place = item.times[0].span.to(item.times[-1].span)
        begin = "at" if is_outermost else "after"
        end = show(self.duration, TIME) if np.isfinite(self.duration) else "1 s"
        match sorted(texts):
            case ["after"] | ["at"]:
                moment = f"{begin} {texts.popitem()[1]}"
                block = "of the run" if is_outermost else "of the block around it"
                return Hint(f'write "{moment}": times are from the start {block}',
                            Edit(moment, place))  # fmt: skip
            case ["every"]:
                return proposal(f"from 0 s to {end} every {texts['every']}", place)
            case ["from"]:
                moment, interval = f"{begin} {texts['from']}", f"from {texts['from']} to {end}"
                return Hint(f'write "{moment}", or "{interval}"', Edit(moment, place),
                            Edit(interval, place))  # fmt: skip
            case ["until"]:
                return proposal(f"from 0 s to {texts['until']}", place)
            case ["at" | "after" as word, "every"]:
                return proposal(f"from {texts[word]} to {end} every {texts['every']}", place)
            case ["every", "from"]:
                return proposal(f"from {texts['from']} to {end} every {texts['every']}", place)
            case ["every", "from", "to"]:
                interval = f"from {texts['from']} to {texts['to']}"
                return proposal(f"{interval} every {texts['every']}", place)
            case _:
                return ""

    def _refuse_other_intervals(self, item: s.Timed, words: list[str]) -> None:
        """Reject ``from 0.1 s until 0.3 s`` and ``from 0.1 s - 0.3 s``."""
        values = [clause.value for clause in item.times]
        if words == ["from", "until"]:
            first, last = (value.span.text for value in values)
        elif words == ["from"] and isinstance(values[0], s.Sum) and len(values[0].rest) == 1:
            first, last = values[0].first.span.text, values[0].rest[0][1].span.text
        else:
            return
        place = item.times[0].span.to(item.times[-1].span)
        message = 'an interval has the form "from … to …:"'
        self.findings.reject(
            "TIS403", message, place, hint=proposal(f"from {first} to {last}", place)
        )

    def _repetitions(
        self, item: s.Timed, start: float, stop: float, every: float
    ) -> list[_Slot]:
        """Return a slot for each beginning in [start, stop)."""
        if every <= 0.0:
            message = "the time between repetitions must be above 0 s"
            self.findings.reject("TIS403", message, item.times[2].span)
        self.repetitions += (stop - start) / every
        if self.repetitions > MOST_REPETITIONS:
            limit = f"{MOST_REPETITIONS:,}".replace(",", " ")
            self.findings.reject(
                "TIS403",
                f"this makes more than {limit} repetitions in the script",
                item.head,
                hint="write a longer time after every; for a steady force: push … with …",
            )
        count = int(np.ceil((stop - start) / every * (1 - 1e-12)))
        return [_Slot(start + k * every, None) for k in range(count)]

    def _time(self, node: s.Expression) -> float:
        """Return a time [s]; it is the same in all repetitions."""
        if id(node) not in self.times:
            self.times[id(node)] = self._evaluated_time(node)
        return self.times[id(node)]

    def _evaluated_time(self, node: s.Expression) -> float:
        value = self.scope.number(node)
        self.scope.expect(value, TIME, node.span, what="the moment")
        if value.amount < 0.0:
            self.findings.reject("TIS403", "times must not be before 0 s", node.span)
        return float(value.amount)

    def _checked(self, item: s.Timed, slot: _Slot) -> _Slot:
        end = slot.start + (slot.duration or 0.0)
        if end > self.duration * (1 + 1e-12) and item.head not in self.late:
            self.late.add(item.head)
            what, time = "lasts until" if slot.duration else "happens at", end
            if slot.duration and slot.start > self.duration * (1 + 1e-12):
                what, time = "begins only at", slot.start
            shown, duration = show_apart(time, self.duration, TIME)
            self.findings.add(
                "W402",
                f"this {what} {shown}, but the run ends at {duration}",
                item.head,
                hint="write an earlier time, or a longer duration in simulate",
            )
        return slot

    def _check_tables(self, item: s.Sentence, action: Action, slot: _Slot) -> None:
        """Report tables of profiles that say nothing of the time in which they are used."""
        clause = next(
            (
                one
                for one in item.clauses
                if isinstance(one.value, s.Name) and one.value.quoted is not None
            ),
            None,
        )
        columns = [one for one in profiles_of(action) if one.kind == "table"]
        if clause is None or not columns or clause.span in self.late:
            return
        room = self.duration - slot.start
        what = f"the run ends at {show(self.duration, TIME)}"
        if slot.duration is not None and slot.duration < room:
            room = slot.duration
            what = f"the action ends after {show(room, TIME)}"
        if (found := table_times(columns, room)) is not None:
            self.late.add(clause.span)
            said, hint = found
            self.findings.add("W402", f"the table {said}, but {what}", clause.span, hint=hint)

    # --- verbs --------------------------------------------------------------------------------

    def _action(self, sentence: s.Sentence, duration: float | None) -> Action:
        verb = sentence.name.key.split(" ")[0]
        if verb not in VERBS:
            self.findings.reject(
                "TIS404",
                f'"{verb}" is not a verb of the script',
                Span(
                    sentence.span.source, sentence.span.start, sentence.span.start + len(verb)
                ),
                hint=_verb_meant(verb) or alternatives(verb, VERBS, what="verbs"),
            )
        if sentence.phrase is not None:
            self.findings.reject(
                "TIS303", '"is" is not allowed in an action', sentence.phrase.span
            )
        return SentenceOrder(
            sentence, verb, duration, self.groups, self.tools, self.scope
        ).action()


#: What is no action: springs of a joint are there from the beginning.
_JOINING = ("sew", "suture", "stitch", "glue", "join", "connect", "bond", "weld", "staple")


def _verb_meant(word: str) -> Hint | str:
    """Return a hint with the verb for what another word does, or an empty one."""
    if word in _JOINING:
        return "bodies are joined by a block: joint NAME { springs from A to B; tissue is … }"
    meant = next((name for name, verb in VERBS.items() if word in synonyms(verb)), "")
    return Hint(f'did you mean "{meant}"?', Edit(meant)) if meant else ""
