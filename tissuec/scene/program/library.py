"""The files that ``use`` finds: where they are looked for, and which of them was meant."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from msgspec import Struct

from tissuec.core import resources
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.files import leads_out, read_bytes
from tissuec.core.hints import Edit, Hint, did_you_mean, nearby_file
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.scene.learning.errors import errors_in
from tissuec.scene.reading.parts import REPEAT

MATTER = "matter/"  # where presets of matter are
SPRINGS = "tissues/"  # where those of single springs are
MOST_LISTED = 40
SCENES = "scenes/"  # where whole scenes are, which no other text can use
SUFFIX = ".tis"
LARGEST_FILE = 256 << 20  # bytes; beyond, a text is a mistake rather than a scene
LINK = '"{}" is a link to a file outside the permitted folders'
LINKED = "copy the file, or permit its folder with --library DIR"
SCENE_BLOCKS = ("body", "joint", "environment", "script", "simulate", "output")


class Library(Struct, frozen=True):
    """The folders in which a text finds the files that it uses; the first hit counts.

    Attributes:
        kept: Texts by the names under which they were found once; no file counts beside them.
            None where nothing was kept.
    """

    beside: Path
    folders: tuple[Path, ...] = ()
    kept: Mapping[str, str] | None = None

    @classmethod
    def of(
        cls,
        source: Source,
        given: Sequence[Path] = (),
        kept: Mapping[str, str] | None = None,
    ) -> "Library":
        """Return the library of a text.

        Args:
            given: The folders of ``--library``.
            kept: Texts that replace files.
        """
        beside = source.path.parent if source.path else Path()
        return cls(beside, (beside / "library", *given, resources.library()), kept)

    def kept_text(self, name: str) -> str | None:
        """Return a text that was kept under a name; None if there is none."""
        return None if self.kept is None else self.kept.get(name)

    def places(self, wanted: str) -> tuple[Path, ...]:
        """Return the folders in which a file is looked for."""
        return (self.beside,) if wanted.startswith("./") else self.folders

    def leads_out(self, path: Path) -> bool:
        """Return whether a file is a link to somewhere else than these folders.

        The library that is shipped may be installed as links.
        """
        own = (self.beside, *self.folders)
        return not path.is_relative_to(resources.library()) and leads_out(path, own)

    def files(self) -> Iterator[tuple[str, Path]]:
        """Yield every file with its name after ``use``; the first hit of a name counts."""
        seen: set[str] = set()
        for name, path in files_of(self.folders):
            if name not in seen:
                seen.add(name)
                yield name, path

    def near(self, wanted: str, used: Sequence[str] = ()) -> Hint:
        """Return a hint with the file that was meant by one that is not there, or with all.

        Args:
            wanted: The name after ``use``.
            used: What else the scene uses: tissues of one scene come from one folder.
        """
        bare = wanted.removesuffix(SUFFIX)
        # Not of Path, which fails at names that are too long to exist.
        if not wanted.startswith("./") and os.path.isfile(self.beside / f"{bare}{SUFFIX}"):
            return Hint(
                f'did you mean "./{bare}", the file beside this one?',
                Edit(f"./{bare}", old=wanted),
            )
        start = "./" if wanted.startswith("./") else ""
        found = (name for name, _ in files_of(self.places(wanted)))
        found = dict.fromkeys(name for name in found if not name.startswith(SCENES))
        names = [f"{start}{name}" for name in found]
        parts = bare.split("/")
        tails = ["/".join(parts[first:]) for first in range(len(parts))]
        matches = ([name for name in names if f"/{name}".endswith(f"/{t}")] for t in tails)
        same = next(filter(None, matches), None)  # those with the longest common end
        if same is None:
            return _listed(wanted, start, names)
        folder = _folder_of(used)
        same = [name for name in same if name.startswith(folder)] if folder else same
        # Matter requires more of a body, so that only a preset of springs can replace it.
        same.sort(key=lambda name: name.startswith(MATTER))
        meant = " or ".join(f'"{name}"' for name in same[:2])
        return Hint(f"did you mean {meant}?", Edit(same[0], old=wanted))

    def declaring(self, kind: str, key: str) -> str:
        """Return the file that declares a thing under this name, or an empty string."""
        found = list(self._declaring(kind, key))
        return _of_springs(found) if found else ""

    def tissues_in(self, wanted: str) -> list[str]:
        """Return the names of the tissues in a file; none if there is no such file."""
        path = next((path for name, path in self.files() if name == wanted), None)
        if path is None:
            return []
        with suppress(OSError, CompileError):
            source = normalise(read_bytes(path, LARGEST_FILE), wanted, path)
            blocks = [item for item in parsed(source).items if isinstance(item, s.Block)]
            names = (block.name.words.partition(" ") for block in blocks)
            return [name for kind, _, name in names if kind == "tissue" and name]
        return []

    def _declaring(self, kind: str, key: str) -> Iterator[str]:
        for name, path in files_of(self.folders):
            with suppress(OSError, CompileError):
                text = read_bytes(path, LARGEST_FILE)
                if key.split(" ")[0].encode() not in text.lower():
                    continue
                items = parsed(normalise(text, name, path)).items
                heads = [item.name.key for item in items if isinstance(item, s.Block)]
                if f"{kind} {key}" in heads and not any(map(belongs_to_scenes, items)):
                    yield name


def _folder_of(used: Sequence[str]) -> str:
    """Return the folder of presets that a scene uses, empty for both or none."""
    folders = {f"{name.split('/')[0]}/" for name in used if "/" in name}
    found = folders & {MATTER, SPRINGS}
    return found.pop() if len(found) == 1 else ""


def _listed(wanted: str, start: str, names: Sequence[str]) -> Hint:
    """Return a hint with a file whose own name is alike, or with those of the same folder."""
    folder, _, last = wanted.removesuffix(SUFFIX).rpartition("/")
    inside = [name for name in names if name.rpartition("/")[0] == folder]
    tails = {name.rpartition("/")[2]: name for name in reversed([*inside, *names])}
    tails |= {name.rpartition("/")[2]: name for name in inside}
    if near := did_you_mean(last, tails):
        meant = tails[near.edits[0].text]
        return Hint(f'did you mean "{meant}"?', Edit(meant, old=wanted))
    if folder and not inside and (near := did_you_mean(wanted, names)):
        return near
    listed = inside or [name for name in names if not start or name.startswith(start)]
    short = ", ".join(listed[:MOST_LISTED]) or "none"
    more = ", …; tissuec library lists all" if len(listed) > MOST_LISTED else ""
    return Hint(f"there are: {short}{more}")


def _of_springs(names: Sequence[str]) -> str:
    """Return the first preset, of springs if possible: matter requires more of a body."""
    return next((name for name in names if not name.startswith(MATTER)), names[0])


def parsed(source: Source) -> s.Module:
    """Return the syntax nodes of a text as ``parse`` does; shipped ones are parsed once."""
    if source.path is None or not source.path.absolute().is_relative_to(resources.library()):
        return parse(source)
    return _shipped(source.name, source.text, source.path)


@lru_cache(maxsize=128)  # the shipped texts, by two names, and some that replace them
def _shipped(name: str, text: str, path: Path) -> s.Module:
    return parse(Source(name, text, path))


def files_of(places: Sequence[Path]) -> Iterator[tuple[str, Path]]:
    """Yield the files of folders and of those in them, with their names after ``use``."""
    for place in places:
        for pattern in (f"*{SUFFIX}", f"*/*{SUFFIX}"):
            for path in sorted(place.glob(pattern)):
                yield path.relative_to(place).with_suffix("").as_posix(), path


def belongs_to_scenes(item: s.Item) -> bool:
    """Return whether an item is a body, or something else that only scenes have."""
    match item:
        case s.Block(phrase=None) if item.name.key.split(" ")[0] == REPEAT:
            return any(map(belongs_to_scenes, item.items))
        case s.Block():
            return item.name.key.split(" ")[0] in SCENE_BLOCKS
        case s.Assign(keyword="set") | s.Table():
            return True
        case s.Expect():  # that of a learn block can be of words alone
            return not errors_in(item.condition)
        case _:
            return False


def find_words(name: str, folders: Sequence[Path] = ()) -> Path:
    """Return the file of a vocabulary, with or without its suffix.

    It is looked for here, in folders, and in the library.

    Raises:
        TissueError: There is none.
    """
    return _find(name, ("",), folders, "vocabulary")


def find_tissues(name: str, folders: Sequence[Path] = ()) -> Path:
    """Return a file with tissues as ``find_words`` does; "liver" is short for "matter/liver".

    Raises:
        TissueError: There is none.
    """
    return _find(name, ("", "matter/", "tissues/"), folders, "file or shipped tissue")


def _find(name: str, inside: Sequence[str], folders: Sequence[Path], what: str) -> Path:
    """Return the file of a name, which is looked for in these folders of each library."""
    bare, shipped = name.removesuffix(SUFFIX), resources.library()
    further = [
        folder / f"{part}{bare}{SUFFIX}" for folder in (*folders, shipped) for part in inside
    ]
    places = (Path(name), Path(bare + SUFFIX), *further)
    found = next((place for place in places if place.is_file()), None)
    if found is not None:
        return found
    names = [one.relative_to(shipped).with_suffix("") for one in shipped.glob(f"*/*{SUFFIX}")]
    hint = nearby_file(Path(name), SUFFIX) or did_you_mean(
        bare, [one.as_posix() for one in names]
    )
    raise TissueError(
        f'there is no {what} "{name}"; '
        + (hint or 'name a file, or one of those that "tissuec library" lists')
    )
