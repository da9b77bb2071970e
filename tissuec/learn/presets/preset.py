"""The preset that a learning writes: a text of the language, and files beside it.

Numbers of single springs and nodes are written as tables beside the preset, with all digits: a
text can give single springs numbers of their own only if it lists their whole net. These tables
are for people and other programs.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import CompileError, Diagnostic, TissueError
from tissuec.core.files import write_file
from tissuec.core.names import key_of
from tissuec.core.source import Source, Span
from tissuec.core.units import si_unit
from tissuec.lang.printer import format_source
from tissuec.lang.words import written_name
from tissuec.learn.fit.outcome import Estimates, Learnt
from tissuec.learn.presets.files import (
    ONE_BY_ONE,
    WrittenVocabularies,
    is_ours,
    mark,
    mistakes,
    of_nodes_and_springs,
    origin,
    vocabularies,
)
from tissuec.learn.presets.tissues import (
    IN_NUMBERS,
    IN_WORDS,
    LEARNED,
    LIKE,
    Draft,
    LearntNumber,
    TissueWriter,
    drafts_of,
    number_of,
    remark,
)
from tissuec.learn.presets.tissues import PRESET_FORMS as FORMS
from tissuec.learn.presets.tissues import learnt as numeral
from tissuec.learn.vocabulary.used import warnings_of
from tissuec.model.network import Network
from tissuec.scene.model import Scene
from tissuec.scene.program.library import SUFFIX, Library
from tissuec.scene.request import Request


class Preset(Struct, frozen=True):
    """Texts to be written.

    Attributes:
        target: Where the preset itself goes.
        text: The preset.
        beside: Texts of further files in the same folder, by their names.
    """

    target: Path
    text: str
    beside: Mapping[str, str]

    @property
    def files(self) -> dict[Path, str]:
        """Return every text by its path; the preset, which needs the others, last."""
        others = {self.target.parent / name: text for name, text in self.beside.items()}
        return {**others, self.target: self.text}


def compose(learnt: Learnt, compiled: Compiled, request: Request, target: Path) -> Preset:
    """Return the preset of learnt results, which is valid by itself at its place.

    The same learning gives the same bytes.

    Raises:
        TissueError: What was learnt makes no valid text, such as words that another file needs
            which is not found from there.
    """
    fit_problem = learnt.fit_problem
    head = mark(Path(request.source.name).name, fit_problem.name, fit_problem.seed)
    words = vocabularies(learnt.words, compiled.scene, target, head)
    listed = tables(learnt, compiled.network, target, head)
    comments = [head, *origin(learnt, request), *of_nodes_and_springs(learnt, listed.names)]
    composer = _Composer(learnt, compiled.scene, target, words, comments)
    return Preset(target, composer.text(), {**words.texts, **listed.texts})


class _Composer:
    """Finds the shortest form of each tissue in which the whole is right."""

    def __init__(
        self,
        learnt: Learnt,
        scene: Scene,
        target: Path,
        words: WrittenVocabularies,
        comments: Sequence[str],
    ):
        self.scene, self.target, self.words, self.comments = scene, target, words, comments
        self.drafts = drafts_of(learnt, scene)
        self.params, self.param_lines = force_params(learnt), param_lines(learnt)
        self.about = _about(learnt)
        self.writer = TissueWriter(scene, self.about)
        self.known = {one.code for one in warnings_of(scene, {})}
        self.problem: tuple[Diagnostic, ...] | str = ""

    def text(self) -> str:
        """Return the preset; one that only brings new warnings, where there is no other."""
        warned: str | None = None
        forms = {draft.name: self._best(draft) for draft in self.drafts}
        tries = (forms, dict.fromkeys(forms, IN_NUMBERS))
        for chosen in tries:
            text = self._composed(self.drafts, chosen)
            if text is not None and self._is_right(text, self.drafts):
                return text
            if text is not None and self._only_warns:
                warned = warned or text
        if warned is not None:
            return warned
        problem = self.problem
        if isinstance(problem, tuple):
            problem = CompileError(problem)
        raise TissueError(f"the result cannot be written as {self.target}:\n{problem}")

    def _best(self, draft: Draft) -> str:
        """Return the first form of a tissue that is right by itself."""
        for form in FORMS[:-1]:
            text = self._composed([draft], {draft.name: form})
            if text is not None and self._is_right(text, [draft]):
                return form
        return IN_NUMBERS

    def _is_right(self, text: str, drafts: Sequence[Draft]) -> bool:
        moved = bool(self.words.texts)
        self.problem = mistakes(
            text, self.target, self.words.texts, drafts,
            params=self.params, moved=moved, known=self.known,
        )  # fmt: skip
        return not self.problem

    @property
    def _only_warns(self) -> bool:
        """Return whether nothing but warnings was found in the last text."""
        found = self.problem
        return isinstance(found, tuple) and all(one.code.startswith("W") for one in found)

    def _composed(self, drafts: Sequence[Draft], forms: Mapping[str, str]) -> str | None:
        """Return the text with tissues in some forms; None where a file cannot be used."""
        uses = dict.fromkeys(self.words.uses)
        for draft in drafts:
            needed = self._needed(draft, forms[draft.name])
            if needed is None:
                return None
            uses |= dict.fromkeys(needed)
        lines = ["language 1", f'about "{self.about}"', *uses, "", *self.comments]
        lines += self.param_lines
        for draft in drafts:
            lines += ["", *self.writer.block(draft, forms[draft.name])]
        source = Source(self.target.name, "\n".join([*lines, ""]), self.target)
        try:
            return format_source(source)
        except CompileError as error:
            self.problem = error.diagnostics
            return None

    def _needed(self, draft: Draft, form: str) -> list[str] | None:
        """Return the lines that a tissue needs above; None where they cannot be written."""
        rules = self.scene.vocabulary.rules.get(draft.original.vocabulary.lower())
        is_new = rules is not None and bool(self.words.texts)
        if form == LIKE:
            if is_new:
                return None  # its original knows the old words
            return _as_list(self._use(draft.original.span))
        if form == IN_WORDS and rules is not None:
            if rules.span.source.name in self.words.files:
                return []
            return _as_list(self._use(rules.span))
        return []

    def _use(self, span: Span) -> str | None:
        """Return the line that uses the file of something, from where the preset goes."""
        path, name = span.source.path, span.source.name
        if path is None or span.source is self.scene.source:
            return None
        library = Library.of(Source(self.target.name, "", self.target))
        for wanted in self._names(path, name):
            places = library.places(wanted)
            hit = next(
                (p for p in (f / f"{wanted}{SUFFIX}" for f in places) if p.is_file()), None
            )
            if hit is not None and hit.resolve() == path.resolve():
                return f'use "{wanted}"'
        return None

    def _names(self, path: Path, name: str) -> Iterator[str]:
        """Yield by which names a file may be found, without its suffix."""
        yield name.removesuffix(SUFFIX)
        folder = self.target.parent.resolve()
        if path.resolve().is_relative_to(folder):
            yield f"./{path.resolve().relative_to(folder).as_posix().removesuffix(SUFFIX)}"


def _as_list(line: str | None) -> list[str] | None:
    return None if line is None else [line]


def _about(learnt: Learnt) -> str:
    """Return the description of a preset, without quotes, which a text cannot contain."""
    files = list(dict.fromkeys(f.file for f in learnt.fitted if not f.held_out))
    text = f"{learnt.fit_problem.name}, learned from {' and '.join(files) or 'nothing'}"
    return text.replace('"', "'")


def force_params(learnt: Learnt) -> dict[str, LearntNumber]:
    """Return the numbers of forces, by the names of their params: "learned bed stiffness"."""
    return {_name(one): number_of(one, 0) for one in _of_forces(learnt)}


def param_lines(learnt: Learnt) -> list[str]:
    """Return the lines of a preset that declare these params."""
    lines: list[str] = []
    for one in _of_forces(learnt):
        number = number_of(one, 0)
        value = numeral(number.value, number.low, number.high, number.dimension)
        lines.append(f"param {written_name(_name(one))} = {value}  # {remark(number)}")
    return ["", *lines] if lines else []


def _of_forces(learnt: Learnt) -> Iterator[Estimates]:
    return (one for one in learnt.estimates if one.adjust.per == "force")


def _name(estimates: Estimates) -> str:
    adjust = estimates.adjust
    return f"{LEARNED} {key_of(adjust.of)} {adjust.what}"


_AXES = "xyz"


class LearntTables(Struct, frozen=True):
    """Tables of numbers that were learnt one by one.

    Attributes:
        texts: By the names of files.
        names: These names by the places of the estimates in what was learnt.
    """

    texts: Mapping[str, str]
    names: dict[int, str]


def tables(learnt: Learnt, network: Network, target: Path, mark: str) -> LearntTables:
    """Return the tables of everything that was learnt per spring or per node.

    ``fat_springs.csv`` beside ``fat.tis``, or with numbers where there are several.
    """
    places = [k for k, one in enumerate(learnt.estimates) if one.adjust.per in ONE_BY_ONE]
    kinds = [learnt.estimates[place].adjust.per for place in places]
    texts: dict[str, str] = {}
    names: dict[int, str] = {}
    for number, (place, kind) in enumerate(zip(places, kinds, strict=True)):
        which = f"_{kinds[: number + 1].count(kind)}" if kinds.count(kind) > 1 else ""
        names[place] = f"{target.stem}_{kind}s{which}.csv"
        texts[names[place]] = _text(learnt.estimates[place], network, mark)
    return LearntTables(texts, names)


def _text(estimates: Estimates, network: Network, mark: str) -> str:
    adjust = estimates.adjust
    unit = si_unit(adjust.dimension)
    what = f"# {adjust.what} per {adjust.per} of {adjust.of}{f', in {unit}' if unit else ''}"
    rows = _spring_rows if adjust.per == "spring" else _node_rows
    lines = [mark, f"{what}; low and high: 95 %", *rows(estimates, network)]
    return "\n".join([*lines, ""])


def _spring_rows(estimates: Estimates, network: Network) -> Iterator[str]:
    members = estimates.adjust.members
    ends = network.node_ids[network.springs.ends[members]]
    yield "id,a,b,value,low,high,identified"
    for spring, (a, b), rest in zip(
        network.springs.ids[members].tolist(), ends.tolist(), _values(estimates), strict=True
    ):
        yield f"{spring},{a},{b},{rest}"


def _node_rows(estimates: Estimates, network: Network) -> Iterator[str]:
    """Yield the header and the rows; places and velocities may have one for each axis."""
    members, count = estimates.adjust.members, len(estimates.value)
    has_axes = count == 3 * len(members)
    ids = network.node_ids[np.repeat(members, 3) if has_axes else members]
    yield f"id,{'axis,' if has_axes else ''}value,low,high,identified"
    for number, (node, rest) in enumerate(zip(ids.tolist(), _values(estimates), strict=True)):
        yield f"{node},{f'{_AXES[number % 3]},' if has_axes else ''}{rest}"


def _values(estimates: Estimates) -> Iterator[str]:
    """Yield value, low and high as the shortest numbers that are exactly these."""
    for value, low, high, known in zip(
        estimates.value.tolist(),
        estimates.low.tolist(),
        estimates.high.tolist(),
        estimates.identified.tolist(),
        strict=True,
    ):
        yield f"{value!r},{low!r},{high!r},{'yes' if known else 'no'}"


def refuse_others(paths: Iterable[Path]) -> None:
    """Check that only files of an earlier learning would be overwritten.

    Raises:
        TissueError: A file is there that was not written by learning.
    """
    for path in paths:
        if path.is_dir():
            raise TissueError(f'"{path}" is a folder; give the name of a file')
        if path.exists() and not is_ours(path):
            raise TissueError(
                f'"{path}" was not written by learning and would be overwritten; '
                "name another file with -o, or use --force"
            )


def place(preset: Preset, *, force: bool) -> list[Path]:
    """Write a preset with what lies beside it; returns the files, the preset first.

    Raises:
        TissueError: A file is there that was not written by learning, and not ``force``.
        OSError: The files cannot be written.
    """
    files = preset.files
    if not force:
        refuse_others(files)
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, text)
    return list(reversed(files))
