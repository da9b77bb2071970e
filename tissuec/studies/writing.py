"""Studies from the command line and from Python: sentences of a study block without a file."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from tissuec.core.names import key_of
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.lang.words import written_name
from tissuec.scene.program.declarations import without
from tissuec.scene.program.imports import Program
from tissuec.scene.study.entries import OPTIONS

_REPEATED = ("vary", "measure")


def with_sentences(program: Program, name: str, sentences: Sequence[str]) -> Program:
    """Return a program whose study has more sentences, or that has one more study.

    A sentence replaces that of the study about the same factor, measure or setting.

    Args:
        program: Of the scene.
        name: Of the study.
        sentences: Such as "vary lift = 2 mm to 10 mm in 9 steps".

    Raises:
        CompileError: They cannot be parsed.
    """
    if not sentences:
        return program
    lines = "".join(f"  {sentence}\n" for sentence in sentences)
    text = f"study {written_name(name)} {{\n{lines}}}\n"
    # Files of rows are found from the current directory.
    source = normalise(text, OPTIONS, Path(OPTIONS).absolute())
    block = parse(source, has_heading=False).items[0]
    assert isinstance(block, s.Block)
    main, found = program.main, False
    items: list[s.Item] = []
    for item in main.items:
        if _is_named(item, name):
            assert isinstance(item, s.Block)
            new = {_subject(one): one for one in block.items}
            kept = [new.pop(_subject(one), one) for one in item.items]
            item, found = replace(item, items=(*kept, *new.values())), True
        items.append(item)
    items += [] if found else [block]
    whole = replace(main, items=tuple(items))
    return replace(program, modules=(*program.modules[:-1], whole))


def sentences_of(
    vary: str | Sequence[str] | Mapping[str, str] = (),
    measure: str | Sequence[str] | Mapping[str, str] = (),
    *,
    rows: str | None = None,
    design: str | None = None,
    runs: int | None = None,
    seed: int | None = None,
) -> list[str]:
    """Return the sentences of a study block for options.

    Args:
        vary: Texts such as "lift = 2 mm to 10 mm in 9 steps", or values by name.
        measure: Texts such as "pull = max(force(forceps A))", or measures by name.
        rows: Name of a file of rows.
        design: Of the study.
        runs: Number of runs of a random design.
        seed: Of a random design.
    """
    found = [f"vary {text}" for text in _texts(vary)]
    found += map(_measure, _texts(measure))
    found += [] if rows is None else [f'rows "{rows}"']
    found += [] if design is None else [f"design is {design}"]
    found += [] if runs is None else [f"runs = {runs}"]
    return found + ([] if seed is None else [f"seed = {seed}"])


def _texts(given: str | Sequence[str] | Mapping[str, str]) -> list[str]:
    """Return texts, of a mapping with its names."""
    if isinstance(given, str):
        return [given]
    if isinstance(given, Mapping):
        return [f"{name} = {text}" for name, text in given.items()]
    return list(given)


def _measure(text: str) -> str:
    """Return the sentence of a measure, with or without a name."""
    name, equal, _ = text.partition("=")
    is_named = equal and not set("(<>!") & set(name)
    return f"measure {text}" if is_named else f"measure = {text}"


def _is_named(item: s.Item, name: str) -> bool:
    """Return whether an item is the study block with a name."""
    if not isinstance(item, s.Block):
        return False
    own = without(item.name, "study")
    return own is not None and own.key == key_of(name)


def _subject(item: s.Item) -> str:
    """Return the subject of a sentence of a study, which one with the same subject replaces."""
    if not isinstance(item, s.Assign | s.Sentence | s.Function):
        return item.span.text
    words = item.name.key.split(" ")
    if words[0] not in _REPEATED:
        return " ".join(words)
    if words == ["measure"]:
        return item.span.text
    owner = item.arguments[0].span.text if isinstance(item, s.Function) else ""
    return key_of(f"{item.name.text} {owner}")
