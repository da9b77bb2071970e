"""The vocabulary that a fit to numbers of tissues writes, as a file that can be used."""

from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from tissuec.core.errors import CompileError, TissueError
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.learn.fit.outcome import percent
from tissuec.learn.presets.files import (
    Pending,
    entry,
    free_name,
    is_of_words,
    mark,
    marked,
    words_alone,
)
from tissuec.learn.presets.preset import Preset
from tissuec.learn.vocabulary.texts import TextEdit, apply
from tissuec.learn.words_fit import LearntVocabulary
from tissuec.pipeline import read_words
from tissuec.scene.learning.model import VocabularyFit
from tissuec.scene.program.library import SUFFIX
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.request import Request
from tissuec.scene.tissues.quantities import QUANTITIES


def compose_vocabulary(
    learnt: LearntVocabulary, words: ResolvedProgram, request: Request, target: Path
) -> Preset:
    """Return the file of the rules with its new words and weights; others lie beside it.

    Args:
        learnt: The finished fit.
        words: The program with the block.
        target: Path of the file.

    Raises:
        TissueError: The texts are not valid at their place.
    """
    head = mark(Path(request.source.name).name, learnt.fit.name, 0)
    return _composed(learnt.fit, words, learnt.texts, target, [head, *_origin(learnt)])


def rehearse_vocabulary(
    fit: VocabularyFit, words: ResolvedProgram, request: Request, target: Path
) -> Preset:
    """Return the file as it would be written without changes, to find errors of its place.

    Args:
        fit: The learn block.
        words: The program with the block.
        target: Path of the file.

    Raises:
        TissueError: It would not be valid there.
    """
    texts = {name: source.text for name, source in sources_of(fit, words).items()}
    head = mark(Path(request.source.name).name, fit.name, 0)
    return _composed(fit, words, texts, target, [head])


def _composed(
    fit: VocabularyFit,
    words: ResolvedProgram,
    texts: Mapping[str, str],
    target: Path,
    comments: list[str],
) -> Preset:
    main, *others = (
        Source(name, texts.get(name, source.text), source.path)
        for name, source in sources_of(fit, words).items()
        if name in texts or source is _source_of_rules(fit, words)
    )
    folder = target.parent.resolve()
    paths = (source.path for source in others if source.path is not None)
    taken = {path.name for path in paths if path.parent.resolve() == folder}
    beside: dict[str, str] = {}
    moved: dict[str, str] = {}
    for source in others:
        name = free_name(PurePosixPath(source.name).name, {target.name, *taken, *beside})
        beside[name] = marked(_only_words(source), comments[0])
        moved[source.name] = name
    text = marked(_only_words(_using(main, moved)), "\n".join(comments))
    try:
        files = Pending({target.parent / name: one for name, one in beside.items()})
        read_words(Request(Source(target.name, text, target), files=files))
    except CompileError as error:
        raise TissueError(
            f"the vocabulary cannot be written as {target}, where it is not valid; write it "
            f"where all files that it uses are found:\n{error}"
        ) from error
    return Preset(target, text, beside)


def _source_of_rules(fit: VocabularyFit, words: ResolvedProgram) -> Source:
    tissue = words.tissues[fit.targets[0].tissue]
    return words.vocabulary.rules[s.key_of(tissue.vocabulary)].span.source


def sources_of(fit: VocabularyFit, words: ResolvedProgram) -> dict[str, Source]:
    """Return the texts that a fit may change by their names, the one with the rules first."""
    declarations = words.declarations
    keys = [("rules", key) for key in fit.rules]
    keys += [(kind, key) for key in fit.scales for kind in ("quantity", "property")]
    sources = [_source_of_rules(fit, words)]
    for kind, key in keys:
        declared = declarations.of(kind).get(key)
        if declared is not None:
            sources.append(declared.item.span.source)
    return {source.name: source for source in sources}


def _using(source: Source, moved: Mapping[str, str]) -> Source:
    """Return a text that uses new files in place of those that they replace."""
    edits: list[TextEdit] = []
    for item in parse(source).items:
        if isinstance(item, s.Sentence) and item.name.words.lower() == "use":
            used = str(PurePosixPath(item.name.quoted or "")).removesuffix(SUFFIX) + SUFFIX
            if used in moved:
                new = moved[used].removesuffix(SUFFIX)
                edits.append(TextEdit(item.span, f'use "./{new}"'))
    text = apply(edits).get(source.name, source.text)
    return Source(source.name, text, source.path)


def _only_words(source: Source) -> str:
    """Return a text without items that are not of a vocabulary, such as tissues."""
    module = parse(source)
    about = (item for item in module.items if not is_of_words(item))
    if all(isinstance(item, s.Sentence) for item in about):
        return source.text
    return words_alone(module)


def _origin(learnt: LearntVocabulary) -> list[str]:
    """Return comments below the mark: what was fitted, how well, and what was held out."""
    lines: list[str] = []
    errors = learnt.errors
    quantities = dict.fromkeys(one.target.quantity for one in learnt.numbers)
    for key in quantities:
        names = [
            one.target.tissue
            for one in learnt.numbers
            if one.target.quantity == key and not one.target.held_out
        ]
        lines += entry("fit", f"{QUANTITIES[key].name} of {', '.join(names)}")
    held = dict.fromkeys(one.target.tissue for one in learnt.numbers if one.target.held_out)
    for name in held:
        lines += entry("held out", f"{name}: error {percent(errors[name])}")
    worst = max(learnt.numbers, key=lambda one: one.factor)
    lines += entry("largest", f"factor {worst.factor:.3g}, {worst.name}")
    lines += entry("error", f"{learnt.first_error:.6g} before, {learnt.error:.6g} after")
    lines += entry("end", f"{'' if learnt.converged else 'NOT CONVERGED: '}{learnt.reason}")
    for demand in learnt.fit.demands:
        holds = "holds" if demand.holds(errors) else "FAILS"
        lines += entry("expected", f"{holds}: {demand.describe(errors)}")
    for note in learnt.notes:
        lines += entry("note", note)
    return ["#", *lines]
