"""Items that are no part of a scene, and what was meant by them."""

from typing import NoReturn

from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean, proposal
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.lang.unopened import begins_block
from tissuec.scene.program.metadata import MEANT, TEXTS
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import LIKE, PARTS, example_of, parts

_USES = ("import", "include", "load", "require", "from")


def _reject_assigned(item: s.Assign, findings: Findings) -> NoReturn:
    word = MEANT.get(item.name.key, item.name.key)
    if word in TEXTS:
        text = item.span.text.partition("=")[2].strip().strip('"')
        hint = Hint(f'write: {word} "{text}"', Edit(f'{word} "{text}"'))
        message = f'{word} is followed by a text in quotes, without "="'
        findings.reject("TIS312", message, item.span, hint=hint)
    text, span = item.name.text, item.name.span
    if begins_block(text.split()[0]) and " " in text:
        message = "a block is enclosed in braces"
        hint = 'put "{" after the name of the block, and "}" after its last entry'
        findings.reject("TIS312", message, span, hint=hint)
    first = text.split()[0]
    if " " in text and (near := did_you_mean(first.lower(), ("set", "param", "let"))):
        place = Span(span.source, span.start, span.start + len(first))
        hint = Hint(near, Edit(near.edits[0].text, place))
        message = f'"{first}" does not begin any part of a scene'
        findings.reject("TIS303", message, place, hint=hint)
    findings.reject(
        "TIS303",
        f'"{text}" cannot be set here',
        span,
        hint=Hint(
            f'write "param {text} = …" or "let {text} = …", '
            "or move it into the block where it belongs",
            Edit(f"param {text}"),
            Edit(f"let {text}"),
        ),
    )


def reject_unknown(item: s.Item, findings: Findings) -> None:
    """Reject an item that is no part of a scene, with what may have been meant."""
    match item:
        case s.Rule():
            findings.reject(
                "TIS303",
                "a rule belongs in a rules block",
                item.span,
                hint="rules soft tissue { if … then … }",
            )
        case s.Timed():
            findings.reject(
                "TIS303",
                "times belong in the script block",
                item.head,
                hint="script { at 0 s: … }",
            )
        case s.Assign():
            _reject_assigned(item, findings)
        case s.RecordedCall():
            _reject_call(item, findings)
        case s.Function():
            reject_function(item, findings)
        case s.Sentence() | s.Block():
            first = item.name.words.split(" ")[0] if item.name.words else item.name.text
            if first in PARTS:
                _reject_form(first, item, findings)
            if first.lower() in _USES and item.name.quoted:
                findings.doubt_all()
                place = Span(item.span.source, item.span.start, item.span.start + len(first))
                hint = proposal("use", place)
                findings.reject("TIS312", 'other files are used with "use"', place, hint=hint)
            findings.reject(
                "TIS303",
                f'"{first}" does not begin any part of a scene',
                item.name.span,
                hint=alternatives(
                    first.lower(),
                    parts(),
                    what="parts",
                    meant=[MEANT[first.lower()]] if first.lower() in MEANT else (),
                ),
            )
        case _:
            raise AssertionError(item)


def _reject_call(item: s.RecordedCall, findings: Findings) -> NoReturn:
    """Reject ``tool shears (kind is scissors)``, or an output outside of its block."""
    place = item.call.span
    if begins_block(item.name.words.split(" ")[0]) and not item.clauses:
        inside = place.text[place.text.index("(") + 1 : place.text.rindex(")")].strip()
        written = f"{item.name.text} {{ {inside} }}"
        findings.doubt(item.name)
        hint = Hint(f"write: {written}", Edit(written, place))
        findings.reject("TIS312", "a block is enclosed in braces", place, hint=hint)
    message = f'"{place.one_line}" does not begin any part of a scene'
    hint = "what is recorded belongs in the output block"
    findings.reject("TIS303", message, item.span, hint=hint)


def _reject_form(first: str, item: s.Sentence | s.Block, findings: Findings) -> NoReturn:
    """Reject a statement that begins like a part of a scene, and has another form."""
    example, message, edits = example_of(first), f"wrong form of {first}", list[Edit]()
    if first in ("use", *TEXTS):
        message, example = f"{first} needs a text in quotes", _quoted(first, item)
        edits = [Edit(example)]
    if LIKE in PARTS[first].clauses and item.phrase and item.phrase.kind == "word":
        example = f"{item.name.text} {LIKE} {item.phrase.span.text}"
        edits = [Edit(example, item.name.span.to(item.phrase.span))]
    hint = Hint(f"write: {example}", *edits)
    findings.reject("TIS312", message, item.span, hint=hint)


def _quoted(word: str, item: s.Sentence | s.Block) -> str:
    """Return a sentence with all that follows its first word in quotes."""
    rest = item.span.text.removeprefix(word).replace('"', "").split()
    if word in TEXTS and rest[:1] == ["is"]:
        del rest[0]
    return f'{word} "{("/" if word == "use" else " ").join(rest)}"'


def reject_function(item: s.Function, findings: Findings) -> NoReturn:
    """Reject a formula where none is allowed; a name of several words may have been meant."""
    argument = item.arguments[0].span.to(item.arguments[-1].span)
    whole = item.name.span.to(argument)
    findings.reject(
        "TIS115",
        f'a name cannot contain the reserved word "{item.arguments[0].word}"',
        argument,
        hint=Hint(
            f'write the name in quotes: "{whole.text}"; formulas of springs '
            "and dashpots belong in a tissue",
            Edit(f'"{whole.text}"', whole),
        ),
    )
