"""The data of a learn block: which files there are, and how the scene was set for each."""

import os.path
from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import Edit, Hint, alternatives, nearby_file
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.scene.learning.sentences import OF_ALL, DataWords
from tissuec.scene.program.library import LINK, LINKED, SUFFIX, Library
from tissuec.scene.program.parameters import Constants
from tissuec.script.fit_problem import Data

OF_BLOCK = ("zero", "free zero", "fit", "adjust")


class Held(Struct, frozen=True):
    """A file that is held out, and where that is written."""

    name: str
    span: Span


class DataReader:
    """Collects the data of one learn block.

    Attributes:
        files: The data, by the name as written.
    """

    def __init__(self, block: s.Block, scope: Constants):
        self.block, self.scope, self.findings = block, scope, scope.findings
        self.files: dict[str, Data] = {}
        self.held: list[Held] = []
        self.is_complete = True  # whether every file that is named is among them

    @property
    def names(self) -> dict[str, str]:
        """Return the names as written by those of the files."""
        return {data.path.name: name for name, data in self.files.items()}

    def read(self, item: s.Item, said: DataWords) -> None:
        """Take in the files that a sentence names, with what was different for them."""
        overrides = self._overrides(item) if isinstance(item, s.Block) else ()
        with self.findings.together():
            for name in said.files:
                with self.findings.item():
                    self._enter(name, overrides, said.start or 0.0)

    def _enter(self, node: s.Name, overrides: tuple[str, ...], start: float) -> None:
        assert node.quoted is not None
        for name, data in self.files.items():
            if name == node.quoted:
                notes = (Note("first here", data.span),)
                message = f'"{name}" is given twice'
                self.findings.reject("TIS307", message, node.span, notes=notes)
            if data.path.name == PurePosixPath(node.quoted).name:
                self.findings.reject(
                    "TIS307", f'"{name}" and "{node.quoted}" have the same file '
                    'name', node.span,
                    hint="the report names data by file; rename one of the files",
                )  # fmt: skip
        self.files[node.quoted] = Data(self.find(node), overrides, False, node.span, start)

    def _inside(self, name: str, span: Span) -> Path:
        """Return the place of a file beside the text, which need not be there."""
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or set("\\:\0") & set(name):
            self.findings.reject(
                "TIS603", f'"{name}" is outside the folder of the scene', span,
                hint="use a file in the folder of the scene, or in a folder below it",
            )  # fmt: skip
        library, source = self.scope.library, span.source
        if library is not None and library.kept is not None:
            return Path(path)  # the text of a result, which is not learnt from again
        if source.path is None:
            self.findings.reject(
                "TIS604", f'"{name}": a scene that is not saved in a file cannot read '
                'data', span,
                hint="save the scene to a file",
            )  # fmt: skip
        return source.path.parent / path

    def find(self, node: s.Name) -> Path:
        """Return the place of a file beside the text, or reject it."""
        name, source = node.quoted or "", node.span.source
        place, library = self._inside(name, node.span), self.scope.library
        if library is not None and library.kept is not None:
            return place
        if os.path.isfile(place):
            if (library or Library.of(source)).leads_out(place):
                self.findings.reject("TIS603", LINK.format(name), node.span, hint=LINKED)
            return place
        folder = source.path.parent if source.path else Path()
        hint = nearby_file(place, place.suffix, Path(folder))
        self.findings.reject(
            "TIS604", f'there is no file "{name}"', node.span, hint=hint,
            notes=(Note(f"searched {place.parent}"),),
        )  # fmt: skip

    def _overrides(self, item: s.Block) -> tuple[str, ...]:
        """Return what was different for one file, as texts of ``--set``."""
        found: dict[str, str] = {}
        with self.findings.together():
            for inner in item.items:
                with self.findings.item():
                    if self._is_of_block(inner) or not _is_plain(inner):
                        self.findings.reject(
                            "TIS303", "only params of the scene are allowed here", inner.span,
                            hint=OF_ALL,
                        )  # fmt: skip
                    assert isinstance(inner, s.Assign)
                    if inner.name.key in found:
                        message = f'"{inner.name.text}" is given twice'
                        self.findings.reject("TIS307", message, inner.name.span)
                    self.scope.try_override(inner)
                    name, value = inner.name.span.one_line, inner.value.span.one_line
                    found[inner.name.key] = f"{name} = {value}"
        return tuple(found.values())

    def _is_of_block(self, item: s.Item) -> bool:
        """Return whether an item belongs in the block, and is no param that is called so."""
        if not isinstance(item, s.Assign) or item.name.key not in OF_BLOCK:
            return False
        return item.name.key not in self.scope.declared

    # --- what is held out ---------------------------------------------------------------------

    def hold_out(self, names: Sequence[s.Name]) -> None:
        """Remember that files are held out; whether there are such is known in the end."""
        self.held += [Held(name.quoted or "", name.span) for name in names]

    def all(self, last_part: float) -> tuple[Data, ...]:
        """Return the data, of which some may be held out; reports what cannot be."""
        for held in self.held:
            with self.findings.item():
                self._hold(held)
        data = tuple(self.files.values())
        if data and self.is_complete and all(one.held_out for one in data):
            self.findings.add(
                "TIS306", "all data is held out, so no data is left for learning",
                self.held[-1].span, hint="add data, or write: hold out = 20 %",
            )  # fmt: skip
        return data

    def _hold(self, held: Held) -> None:
        if held.name not in self.files:
            if not self.is_complete:
                self.findings.stop()
            self.findings.reject(
                "TIS301", f'"{held.name}" is not in the data of the block', held.span,
                hint=alternatives(held.name, self.files, what="data"),
            )  # fmt: skip
        if self.files[held.name].held_out:
            self.findings.reject("TIS307", f'"{held.name}" is held out twice', held.span)
        self.files[held.name] = replace(self.files[held.name], held_out=True)

    # --- what is written ----------------------------------------------------------------------

    def place_to_write(self, file: s.Name, sources: Sequence[Source]) -> Path:
        """Return where a preset goes; rejects a text of the scene itself."""
        name = file.quoted or ""
        if not name.endswith(SUFFIX):
            preset = f'"{name.partition(".")[0]}{SUFFIX}"'
            self.findings.reject(
                "TIS312", "the name of a preset must end in .tis", file.span,
                hint=Hint(f"write {preset}", Edit(preset)),
            )  # fmt: skip
        place = self._inside(name, file.span)
        same = os.path.abspath(place)
        if any(one.path is not None and os.path.abspath(one.path) == same for one in sources):
            self.findings.reject(
                "TIS306", f'"{name}" is a file of this scene and would be '
                'overwritten', file.span,
                hint="write to another file",
            )  # fmt: skip
        return place


def _is_plain(item: s.Item) -> bool:
    """Return whether an item sets something, and no more."""
    if not isinstance(item, s.Assign):
        return False
    return not (item.keyword or item.bounds or item.clauses)
