"""Texts and calls from Python as sentences of a scene, and scenes with more of them.

A call such as ``move("tip", by=(0, 0, 0.01))`` becomes a sentence of the script. Its numbers
are in SI units; their dimensions are those that the verb declares for its clauses.
"""

import warnings
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import cast

from tissuec.compiler.compile import Compiled
from tissuec.compiler.measures.conditions import Condition, Conditions
from tissuec.compiler.measures.quantities import ObservedExpression, QuantityReader
from tissuec.compiler.script.holds import check_holds
from tissuec.compiler.script.plan import ScriptReader
from tissuec.compiler.script.sentences import SentenceOrder
from tissuec.core import arguments
from tissuec.core.errors import TissueError, TissueWarning
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.core.units import TIME
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.scene.overrides.entries import read_override, written_place
from tissuec.scene.overrides.texts import Given, without_unit
from tissuec.scene.program.declarations import Declarations, collect
from tissuec.scene.program.imports import load
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.spellings import in_parentheses
from tissuec.scene.request import Request
from tissuec.script.forms import forms_of
from tissuec.script.parts import ProfileClause
from tissuec.script.plan import ScheduledAction
from tissuec.script.verbs import Demanding

ORDERED = "ordered from Python"  # what a text is called in messages
STEADY = "constant speed"  # of motions for which no profile is given


class TextReader:
    """Reads texts with the names of a scene; each text is read once.

    What is doubtful is warned of once; what is wrong raises a ``CompileError``.

    Args:
        compiled: The scene.
    """

    def __init__(self, compiled: Compiled):
        scene = compiled.scene
        self._compiled, self._scope = compiled, scene.constants
        self._duration, self._findings = scene.simulation.duration, scene.constants.findings
        self._conditions = Conditions(compiled.groups, scene)
        self._warned: set[str] = set()
        self._times: dict[str, float] = {}  # [s]
        self._quantities: dict[str, ObservedExpression] = {}
        self._read_conditions: dict[str, Condition] = {}
        self._units: dict[tuple[str, ...], dict[str, str]] = {}

    def seconds(self, span: str | float) -> float:
        """Return a time such as "25 ms" in s.

        Raises:
            CompileError: The text is no time.
            TypeError: It is neither a text nor a number.
            ValueError: The number is NaN.
        """
        if not isinstance(span, str):
            return arguments.number(span, "a time in seconds", finite=False)
        if span not in self._times:
            node = _value(span).value
            with self._reporting():
                value = self._scope.number(node)
                self._scope.expect(value, TIME, node.span, what="the time")
                self._times[span] = float(value.amount)
        return self._times[span]

    def condition(self, what: str) -> Condition:
        """Return a condition of the script.

        Raises:
            CompileError: The text is no condition.
        """
        if arguments.text(what, "a condition") not in self._read_conditions:
            items = parse(Source(ORDERED, f"expect {what}"), has_heading=False).items
            with self._reporting():
                node = cast(s.Expect, items[0]).condition
                self._read_conditions[what] = self._conditions.condition(node)
        return self._read_conditions[what]

    def quantity(self, what: str) -> ObservedExpression:
        """Return a quantity of the present.

        Raises:
            CompileError: The text measures nothing, or not the present.
        """
        if arguments.text(what, "a measure") not in self._quantities:
            item = _value(what)
            with self._reporting():
                self._quantities[what] = self._read_quantity(item)
        return self._quantities[what]

    def _read_quantity(self, item: s.Assign) -> ObservedExpression:
        self._conditions.needs_ledger = False
        if item.clauses:
            self._findings.reject(
                "TIS303", f'"{item.clauses[0].word}" is not allowed here', item.clauses[0].span,
                hint="for example: force(A), or force(A along (1, 0, 0))",
            )  # fmt: skip
        found = QuantityReader(self._conditions).read(item.value)
        if any(reading.time is not None for reading in found.readings.values()):
            message = "what is measured now cannot name a time"
            self._findings.reject("TIS702", message, item.value.span)
        if self._conditions.needs_ledger and not self._compiled.plan.needs_ledger:
            self._findings.reject(
                "TIS702", "this run does not keep the energies of its motion", item.value.span,
                hint='add "energy every 10 ms" to the output block of the scene',
            )  # fmt: skip
        return found

    def events(self, text: str, ordered: Sequence[ScheduledAction]) -> list[ScheduledAction]:
        """Return the actions of a sentence with its time, checked with the rest of the script.

        Args:
            text: The sentence.
            ordered: What was ordered before.

        Raises:
            CompileError: The sentence is wrong.
        """
        compiled, scene = self._compiled, self._compiled.scene
        items = parse(Source(ORDERED, text, is_composed=True), has_heading=False).items
        with self._reporting():
            if len(items) > 1:  # of which the others would have times of their own
                self._findings.reject(
                    "TIS100", "only one sentence can be ordered at once", items[1].span,
                    hint="order each sentence by itself, without a time",
                )  # fmt: skip
            # A new reader: one knows sentences by where they are in memory.
            script = ScriptReader(
                compiled.groups, scene.tools, self._conditions, self._scope,
                duration=self._duration,
            ).read(items)  # fmt: skip
        self._check(script.events, ordered)
        return script.events

    def _check(
        self, events: Sequence[ScheduledAction], ordered: Sequence[ScheduledAction]
    ) -> None:
        """Report what is checked of a whole script."""
        tools, plan = self._compiled.scene.tools, self._compiled.plan
        network = self._compiled.network
        flaws = [
            (event.action.span, flaw)
            for event in events
            if isinstance(event.action, Demanding) and (flaw := event.action.flaw(network))
        ]
        every = sorted([*plan.events, *ordered, *events], key=lambda one: one.time)
        shaped = all(tool.entries is not None for tool in tools.values())
        with self._reporting():
            for span, flaw in flaws:
                self._findings.add("TIS309", flaw, span, hint=getattr(flaw, "hint", ""))
            self._findings.extend(
                check_holds(every, plan.triggers, network.tools, shaped=shaped)
            )

    def sentence(
        self, verb: str, words: Sequence[str], clauses: dict[str, Given], duration: float | None
    ) -> str:
        """Return a sentence in which numbers of clauses have the units that the verb requires.

        Args:
            verb: The verb.
            words: What follows the verb.
            clauses: Values by joining word, numbers in SI units.
            duration: How long it takes [s]; None for at once.

        Raises:
            CompileError: The sentence is wrong.
            ValueError: A value is no text, number or vector.
        """
        bare = tuple(
            word.rstrip("_") for word, value in clauses.items() if not isinstance(value, str)
        )
        text = joined(verb, words, clauses)
        if not bare:
            return text
        sentence = parse(Source(ORDERED, text), has_heading=False).items[0]
        assert isinstance(sentence, s.Sentence)
        key = (verb, *words, "", *bare)
        if key not in self._units:
            self._units[key] = self._units_of(verb, bare, sentence, duration)
        return with_units(sentence, bare, self._units[key])

    def _units_of(
        self, verb: str, bare: Sequence[str], sentence: s.Sentence, duration: float | None
    ) -> dict[str, str]:
        """Return the SI units of clauses with numbers."""
        order = SentenceOrder(
            sentence, verb, duration, self._compiled.groups, self._compiled.scene.tools,
            self._scope,
        )  # fmt: skip
        with self._reporting():
            form = order.choose()
        return {word: form.unit_of(word) for word in bare}

    @contextmanager
    def _reporting(self) -> Generator[None]:
        """Raise what is found wrong in the block, and warn of what is doubtful.

        Raises:
            CompileError: Something is wrong.
        """
        try:
            with self._findings.item():
                yield
            self._findings.raise_errors()
            for finding in map(str, self._findings.warnings):
                if finding not in self._warned:
                    self._warned.add(finding)
                    warnings.warn(finding, TissueWarning, stacklevel=5)
        finally:
            self._findings.clear()


def _value(text: str) -> s.Assign:
    """Return the text of the value of an entry."""
    items = parse(Source(ORDERED, f"value = {text}"), has_heading=False).items
    if len(items) != 1:
        raise ValueError(f'"{text}" is not one value but {len(items)}')
    return cast(s.Assign, in_parentheses(items[0]))


def joined(verb: str, words: Sequence[str], clauses: Mapping[str, Given]) -> str:
    """Return a sentence whose numbers have no units yet.

    Args:
        verb: The verb.
        words: What follows the verb.
        clauses: Values by joining word; an underscore after a word of Python is left out.

    Raises:
        ValueError: A value is no text, number or vector.
    """
    parts = [verb, *words]
    for word, value in clauses.items():
        parts += [word.rstrip("_"), without_unit(value, word)]
    if "using" not in clauses and _needs_profile(verb, clauses):
        parts.append(f"using {STEADY}")
    return " ".join(parts)


def with_units(sentence: s.Sentence, bare: Sequence[str], units: Mapping[str, str]) -> str:
    """Return the text of a sentence whose bare numbers have the units of its clauses.

    Args:
        sentence: The sentence.
        bare: Joining words of clauses with numbers in SI units.
        units: Of the clauses.
    """
    span = sentence.span
    text, begun = "", span.start
    for clause in sentence.clauses:
        if clause.word in bare:
            text += f"{span.source.text[begun : clause.span.end]} {units[clause.word]}".rstrip()
            begun = clause.span.end
    return text + span.source.text[begun : span.end]


def _needs_profile(verb: str, clauses: Mapping[str, Given]) -> bool:
    """Return whether a sentence with some clauses, and without ``using``, lacks a profile."""
    profiles = (
        part
        for form in forms_of(verb)
        for part in form.parts.values()
        if isinstance(part, ProfileClause) and not part.over
    )
    return any(part.path in ("", *clauses) for part in profiles)


def recorded(request: Request, sentences: Sequence[str]) -> str:
    """Return the text of a scene with sentences at the end of its script.

    Values that were given from outside are written into params and entries of the text. A
    comment at the end names those that belong into files that it uses, as options of ``tissuec
    run``.

    Args:
        request: What the scene was compiled from.
        sentences: With their times.

    Raises:
        TissueError: The script is in another file.
    """
    left: list[str] = []
    for given in request.overrides:
        text = _with_value(request, given)
        if text is None:
            left.append(given)
        else:
            request = _with_text(request, text)
    if sentences:
        request = _with_text(request, _with_sentences(request, sentences))
    return "\n".join(
        [request.source.text, *(f'# Run with: --set "{given}"\n' for given in left)]
    )


def _with_text(request: Request, text: str) -> Request:
    return replace(request, source=replace(request.source, text=text))


def _declared(request: Request) -> Declarations:
    findings = Findings()
    return collect(load(request.source, request.libraries, findings, request.files), findings)


def _with_value(request: Request, given: str) -> str | None:
    """Return the text with a value in it; None if it belongs into another file."""
    declarations, findings = _declared(request), Findings()
    override = read_override(given, findings)
    item, key = override.item, override.item.name.key
    param = declarations.of("param").get(key)
    if param is not None and isinstance(param.item, s.Assign) and not override.owners:
        assert isinstance(item, s.Assign)
        return _replaced(request.source, param.item.value.span, item.value.span.text)
    place = written_place(override, declarations, findings)
    entry = override.entry if place.start < place.end else f"\n  {override.entry}\n"
    return _replaced(request.source, place, entry)


def _replaced(source: Source, place: Span, text: str) -> str | None:
    """Return the text of a source with other text at a place; None if that is elsewhere."""
    if place.source.text != source.text:
        return None
    before, after = source.text[: place.start], source.text[place.end :]
    return (before if place.start < place.end else before.rstrip()) + text + after


def _with_sentences(request: Request, sentences: Sequence[str]) -> str:
    """Return the text with sentences at the end of its script."""
    source, block = request.source, _declared(request).single.get("script")
    lines = "".join(f"  {sentence}\n" for sentence in sentences)
    if block is None:
        return f"{source.text.rstrip()}\n\nscript {{\n{lines}}}\n"
    close = block.span.end - 1
    text = _replaced(source, Span(block.span.source, close, close), f"\n{lines}")
    if text is None:
        raise TissueError(
            f"the script is in {block.span.source.name}, which the scene uses; move it "
            f"into {source.name} to record what is ordered"
        )
    return text
