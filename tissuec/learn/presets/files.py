"""Files that learning writes: their comments, vocabularies beside a preset, and checks."""

import textwrap
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import isclose
from pathlib import Path, PurePosixPath

from msgspec import Struct

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.names import key_of
from tissuec.core.source import Source
from tissuec.core.version import __version__
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.lang.printer import format_source
from tissuec.learn.fit.outcome import Estimates, Learnt, interval, judged, percent, shown
from tissuec.learn.presets.tissues import WHOLE, Draft, LearntNumber, changed_constants
from tissuec.pipeline import check_request, read_words
from tissuec.scene.model import AssignedQuantity, Scene, Tissue
from tissuec.scene.program.declarations import VOCABULARY
from tissuec.scene.program.imports import Files, read_source
from tissuec.scene.program.library import SUFFIX, belongs_to_scenes
from tissuec.scene.request import Request

WIDTH = 96
_LABEL = 13
#: Of these, each number is in a table beside the preset.
ONE_BY_ONE = ("spring", "node")


def origin(learnt: Learnt, request: Request) -> list[str]:
    """Return the comments below the mark: data, noise, method, errors, expectations.

    They name files without their folders, and no time of day, so that the same learning gives
    the same text.
    """
    lines: list[str] = []
    for fitted in learnt.fitted:
        seen = ", held out" if fitted.held_out else ""
        lines += entry("data", f"{fitted.file}{seen}: error {percent(fitted.error)}")
        lines += entry("", f"sha256 {fitted.digest}")
    for text in request.overrides:
        lines += entry("set", text)
    lines += entry("fit", "; ".join(dict.fromkeys(f.text for f in learnt.fit_problem.fits)))
    for text, noise in learnt.noise.items():
        lines += entry("noise", f"{text}: {_of_fit(learnt, text, noise)}")
    for text, zero in learnt.zeros.items():
        lines += entry("zero", f"{text}: {_of_fit(learnt, text, zero)}")
    lines += entry("method", "; ".join(filter(None, (learnt.method, learnt.stepping))))
    lines += entry("error", f"{learnt.first_error:.6g} before, {learnt.error:.6g} after")
    ended = "" if learnt.converged else "NOT CONVERGED: "
    lines += entry("end", f"{ended}{learnt.reason}")
    if learnt.failure:
        lines += entry("", f"FAILED: {learnt.failure}")
    for verdict in judged(learnt):
        holds = "holds" if verdict.holds else "FAILS"
        lines += entry("expected", f"{holds}: {verdict.measured}")
    for blind in learnt.blind:
        lines += entry("not known", f"{blind.sentence} ({blind.advice})")
    for note in learnt.notes:
        lines += entry("note", note)
    return ["#", *lines]


def of_nodes_and_springs(learnt: Learnt, tables: dict[int, str]) -> list[str]:
    """Return comments on what the language says of no tissue.

    Args:
        tables: Names of the tables beside the preset, by the places of estimates.
    """
    lines: list[str] = []
    for place, estimates in enumerate(learnt.estimates):
        adjust = estimates.adjust
        if place in tables:
            text = f"{adjust.what} per {adjust.per} of {adjust.of}: {tables[place]}"
            lines += entry("numbers", text)
        elif adjust.per == "set":
            for number in range(len(estimates.names)):
                lines += entry("number", _of_set(estimates, number))
    return ["#", *lines] if lines else []


def _of_set(estimates: Estimates, number: int) -> str:
    """Return a number that a set has as a whole, with the factor by which it changed."""
    adjust = estimates.adjust
    value, start = float(estimates.value[number]), float(estimates.start[number])
    dimension = adjust.dimension
    known = interval(float(estimates.low[number]), float(estimates.high[number]), dimension)
    if not estimates.identified[number]:
        known = "not identified by the data"
    text = f"{estimates.names[number]}: {shown(value, dimension, digits=6)} (95 %: {known})"
    if start > 0.0 and not adjust.what.startswith("start"):
        text += f", {value / start:.6g} times what it was"
    return f"{text}; before: {shown(start, dimension)}"


def _of_fit(learnt: Learnt, text: str, value: float) -> str:
    dimensions = {fit.text: fit.dimension for fit in learnt.fit_problem.fits}
    return shown(value, dimensions[text]) if text in dimensions else f"{value:.4g}"


def entry(label: str, text: str) -> Iterator[str]:
    """Yield the lines of a comment with a label, all but the first one indented."""
    lines = textwrap.wrap(text, WIDTH - _LABEL, break_long_words=False, break_on_hyphens=False)
    for number, line in enumerate(lines or [""]):
        head = label if number == 0 else ""
        yield f"# {head:<{_LABEL - 3}} {line}".rstrip()


_BEGIN = "# Learned by tissuec"
_LOOKED_AT = 4096  # bytes


def mark(scene: str, fit_problem: str, seed: int) -> str:
    """Return the first comment: by what, of which scene and fit problem, with which seed."""
    return f"{_BEGIN} {__version__} from {scene}, learn {fit_problem}, seed {seed}"


def is_ours(path: Path) -> bool:
    """Return whether learning wrote a file: whether its first comment says so.

    Raises:
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(_LOOKED_AT).decode("utf-8", errors="replace")
    comments = (line for line in head.splitlines() if line.startswith("#"))
    return next(comments, "").startswith(f"{_BEGIN} ")


ROUNDING = 1e-12  # of a number that is written in full
WRITTEN = 0.6e-5  # of a learnt one: half a unit of its sixth digit


class Pending(Files):
    """Files of which some are not written yet, by their paths."""

    def __init__(self, texts: Mapping[Path, str]):
        self._texts = {path.resolve(): text for path, text in texts.items()}

    def has(self, path: Path) -> bool:
        return path.resolve() in self._texts or super().has(path)

    def read(self, path: Path, name: str) -> Source:
        text = self._texts.get(path.resolve())
        return read_source(path, name) if text is None else Source(name, text, path)


def mistakes(
    text: str,
    target: Path,
    beside: Mapping[str, str],
    drafts: Sequence[Draft],
    *,
    params: Mapping[str, LearntNumber],
    moved: bool,
    known: Collection[str] = (),
) -> tuple[Diagnostic, ...] | str:
    """Return the errors of a preset; empty if there are none.

    Args:
        text: Text of the preset.
        target: Its file, at which it must be valid by itself.
        beside: Texts of files that are written with it, by their names.
        drafts: Tissues of the preset.
        params: Numbers of forces by the names of their params.
        moved: Whether words moved, so that rules give other numbers than before.
        known: Codes of warnings that the scene itself has.
    """
    files = Pending({target.parent / name: one for name, one in beside.items()})
    source = Source(target.name, text, target)
    request = Request(source, files=files)
    try:
        compiled, warnings = check_request(request)
        if compiled is not None:
            return f'"{target.name}" would be a scene'
        new = tuple(one for one in warnings if one.code not in known)
        words, _ = read_words(request)
    except CompileError as error:
        return error.diagnostics
    for draft in drafts:
        if (problem := _differs(words.tissues[key_of(draft.name)], draft, moved)) is not None:
            return f"{draft.name} would have another {problem}"
    values = {one.name: float(one.value.amount) for one in words.constants.parameters()}
    for name, number in params.items():
        if not isclose(values[name], number.value, rel_tol=WRITTEN):
            return f"{name} would have another value"
    return new or ""


def _differs(tissue: Tissue, draft: Draft, moved: bool) -> str | None:
    """Return the difference of a tissue from its draft; None if all is as learnt."""
    for name, old in draft.original.given.items():
        if old.spread == WHOLE and tissue.given.get(name) is None:
            continue  # which no tissue can say as a number
        if moved and old.how != "written" and name not in draft.numbers:
            continue
        if not _is_same(tissue.given.get(name), old, draft.numbers.get(name)):
            return name
    for word, law in draft.original.written_laws.items():
        new = tissue.written_laws.get(word)
        if new is None or (law.law is None) != (new.law is None):
            return word
        if not changed_constants(law, draft.constants) and new.formula != law.formula:
            return word
    return None


def _is_same(
    new: AssignedQuantity | None, old: AssignedQuantity, number: LearntNumber | None
) -> bool:
    if new is None or new.spread != old.spread or (new.length is None) != (old.length is None):
        return False
    if new.length is not None and old.length is not None and new.length != old.length:
        return False
    if number is None:
        return new.value == old.value or isclose(new.value, old.value, rel_tol=ROUNDING)
    return isclose(new.value, number.value, rel_tol=WRITTEN)


class WrittenVocabularies(Struct, frozen=True):
    """Texts of vocabularies.

    Attributes:
        texts: By the names of files beside the preset.
        files: These names by those that the scene has for the sources.
    """

    texts: Mapping[str, str]
    files: Mapping[str, str]

    @property
    def uses(self) -> list[str]:
        """Return the lines that use them."""
        return [f'use "./{name.removesuffix(SUFFIX)}"' for name in self.texts]


def vocabularies(
    texts: Mapping[str, str], scene: Scene, target: Path, mark: str
) -> WrittenVocabularies:
    """Return the files of new vocabularies.

    Args:
        texts: New texts of whole sources, by the names that the scene has for them.
        target: Where the preset goes, whose name none of them may have.
        mark: Their first comment.
    """
    found: dict[str, str] = {}
    files: dict[str, str] = {}
    for name, text in texts.items():
        file = free_name(PurePosixPath(name).name, {target.name, *found})
        whole = parse(Source(name, text))
        if any(map(belongs_to_scenes, whole.items)):
            file = free_name(f"{Path(file).stem}_words{SUFFIX}", {target.name, *found})
            text = words_alone(whole)
        found[file] = marked(text, mark)
        files[name] = file
    return WrittenVocabularies(found, files)


def free_name(name: str, taken: set[str]) -> str:
    """Return a name of a file that is not taken, like ``name``."""
    stem, free, number = Path(name).stem, name, 1
    while free in taken:
        number += 1
        free = f"{stem}_{number}{SUFFIX}"
    return free


def words_alone(module: s.Module) -> str:
    """Return the vocabulary of the file of a scene, without what only scenes have.

    Tissues stay behind: those that are learnt are written in full.
    """
    kept = [item.span.text for item in module.items if is_of_words(item)]
    text = "\n".join(["language 1", "", *kept, ""])
    return format_source(Source(module.source.name, text))


def is_of_words(item: s.Item) -> bool:
    """Return whether an item is a part of a vocabulary, or a number that it may need."""
    match item:
        case s.Assign(keyword=keyword) if keyword in ("param", "let"):
            return True
        case s.Sentence() | s.Assign() | s.Block():
            first = item.name.key.split(" ")[0] if item.name.words else ""
            return first in (*VOCABULARY, "use")
        case _:
            return False


def marked(text: str, mark: str) -> str:
    """Return a text with comments after its first line, which states the language.

    Args:
        mark: Lines of comments.
    """
    lines = text.split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("language"))
    return "\n".join([*lines[first : first + 1], mark, *lines[:first], *lines[first + 1 :]])
