"""Tissues that a scene uses, and scenes read again with other words."""

from collections.abc import Mapping
from pathlib import Path

from msgspec import Struct

from tissuec.core.errors import Diagnostic
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.pipeline import check_request
from tissuec.scene.model import Scene, Tissue
from tissuec.scene.program.imports import DISK, Files, StoredTexts, load
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request
from tissuec.scene.resolve import resolve
from tissuec.scene.words.phrases import read_word
from tissuec.scene.words.vocabulary import Vocabulary


class Use(Struct, frozen=True):
    """A tissue that is described in words.

    Attributes:
        key: Its lower-case name.
        rules: Of the rules that know its words, in small letters.
        quantities: What these rules give, also by their ``otherwise``.
        words: Properties that are described with words, with these.
        numbers: Properties that are written as numbers.
    """

    key: str
    tissue: Tissue
    rules: str
    quantities: tuple[str, ...]
    words: Mapping[str, tuple[s.Name, ...]]
    numbers: Mapping[str, float]

    def facts(self, vocabulary: Vocabulary, scope: Scope) -> dict[str, float]:
        """Return the number of each property, with the words of a vocabulary."""
        facts = dict(self.numbers)
        for key, names in self.words.items():
            scale = vocabulary.properties[key]
            shapes = [read_word(name, scale, vocabulary.hedges, scope).shape for name in names]
            axis = scale.scale.axis
            facts[key] = axis.value_of(shapes[0]) if len(names) == 1 else axis.halfway(*shapes)
        return facts


def used_tissues(scene: Scene) -> list[Use]:
    """Return the tissues of bodies, regions and joints to which rules give something."""
    tissues = [
        *(tissue for body in scene.bodies.values() for tissue in body.tissues),
        *(joint.tissue for joint in scene.joints.values()),
    ]
    named = {s.key_of(tissue.name): tissue for tissue in tissues}
    uses = [_use(key, tissue, scene) for key, tissue in named.items() if tissue.vocabulary]
    return [use for use in uses if use.quantities]


def _use(key: str, tissue: Tissue, scene: Scene) -> Use:
    quantities = tuple(
        name for name, given in tissue.given.items() if given.how in ("rules", "otherwise")
    )
    return use_of(key, tissue, quantities, scene)


def use_of(
    key: str, tissue: Tissue, quantities: tuple[str, ...], program: Scene | ResolvedProgram
) -> Use:
    """Return the description of a tissue.

    Args:
        key: Its lower-case name.
        tissue: The tissue, which has words.
        quantities: Quantities that the rules are to conclude.
        program: The program that declares it.
    """
    written = {
        item.span: item
        for declared in program.declarations.of("tissue").values()
        if isinstance(declared.item, s.Block)
        for item in declared.item.items
    }
    words: dict[str, tuple[s.Name, ...]] = {}
    numbers: dict[str, float] = {}
    for fact in tissue.facts:
        item = written[fact.span]
        if isinstance(item, s.Sentence) and item.phrase is not None:
            words[fact.property] = item.phrase.words
        else:
            numbers[fact.property] = fact.number
    return Use(key, tissue, s.key_of(tissue.vocabulary), quantities, words, numbers)


class Replaced(Files):
    """Files of which some have other texts than on disk, by the names that messages print."""

    def __init__(self, texts: Mapping[str, str], others: Files = DISK):
        self._texts = texts
        self._others = others

    def read(self, path: Path, name: str) -> Source:
        if name in self._texts:
            return Source(name, self._texts[name], path)
        return self._others.read(path, name)


def request_of(scene: Scene, texts: Mapping[str, str]) -> Request:
    """Return the request that compiles a scene with new texts of some of its files."""
    source, library = scene.source, scene.declarations.library
    main = Source(source.name, texts.get(source.name, source.text), source.path)
    kept = library.kept
    files = Replaced(texts) if kept is None else StoredTexts({**kept, **texts})
    # The first and last folders are there for every text.
    return Request(main, scene.overrides, library.folders[1:-1], files=files)


def reread(scene: Scene, texts: Mapping[str, str]) -> Scene:
    """Return a scene with new texts of some of its files.

    Raises:
        CompileError: It is none any more.
    """
    findings = Findings()
    request = request_of(scene, texts)
    program = load(request.source, request.libraries, findings, request.files)
    again = resolve(program, findings, request.overrides)
    findings.raise_errors()
    return again


def warnings_of(scene: Scene, texts: Mapping[str, str]) -> tuple[Diagnostic, ...]:
    """Return the warnings of ``check`` about a scene with new texts.

    Raises:
        CompileError: It finds an error.
    """
    return check_request(request_of(scene, texts), thorough=False, levels=False)[1]
