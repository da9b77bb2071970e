"""Wavefront OBJ: vertices and faces as lines of text, with names of groups between them.

Faces may count vertices backwards from the end (-1 is the last one so far), and belong to the
groups (``g``), the object (``o``) and the material (``usemtl``) named last.
"""

from pathlib import Path

import numpy as np

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, faces, known_by
from tissuec.meshes.formats.numbers import LARGEST


@FORMATS.member(".obj")
@known_by(holds=b"\nv ")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices, faces, and the parts: every group, object and material."""
    reader = _ObjReader()
    words: list[str] = []
    first = 0  # line of a statement that is continued on the next one
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        line = line.split("#")[0].rstrip()
        is_continued = line.endswith("\\")
        words += line.removesuffix("\\").split()
        first = first or number
        if is_continued:
            continue
        if words:
            reader.take(words, first)
        words, first = [], 0
    if words:  # the last line is continued
        reader.take(words, first)
    return reader.mesh()


class _ObjReader:
    """Collects vertices, faces and parts, line by line."""

    def __init__(self) -> None:
        self.points: list[list[float]] = []
        self.corners: list[int] = []
        self.sizes: list[int] = []
        self.lines: list[int] = []  # of the text, for messages; one for each face
        self.names: dict[str, tuple[str, ...]] = {}
        self.parts: dict[str, list[int]] = {}
        self.ignored = 0

    def take(self, words: list[str], number: int) -> None:
        kind = words[0]
        try:
            if kind == "v":
                self.points.append([float(word) for word in words[1:4]])
                if len(words) < 4:
                    raise ValueError
            elif kind == "f":
                self._face(words[1:], number)
            elif kind in ("g", "o", "usemtl"):
                whole = (" ".join(words[1:]),) if kind != "g" else tuple(words[1:])
                self.names[kind] = tuple(name for name in whole if name)
            elif kind in ("l", "p"):
                self.ignored += 1
        except FormatError:
            raise
        except ValueError:
            hint = "write decimals with a point" if any("," in word for word in words) else ""
            written = " ".join(words)[:40]
            raise FormatError(f'line {number} cannot be read: "{written}"', hint) from None

    def _face(self, words: list[str], number: int) -> None:
        here = len(self.points)
        found = [int(word.split("/")[0]) for word in words]
        if 0 in found:
            raise ValueError
        if len(found) < 3:
            raise FormatError(f"line {number}: a face needs three corners or more")
        lost = [n for n in found if n < -here or n > LARGEST]
        if lost:
            raise FormatError(
                f"line {number} uses vertex {lost[0]}, but there are {here} before it"
            )
        for name in {name: None for names in self.names.values() for name in names}:
            self.parts.setdefault(name, []).append(len(self.sizes))
        self.corners += [here + n if n < 0 else n - 1 for n in found]
        self.sizes.append(len(found))
        self.lines.append(number)

    def mesh(self) -> RawMesh:
        position = np.array(self.points, dtype=float).reshape(-1, 3)
        flat, sizes = np.array(self.corners, np.int64), np.array(self.sizes, np.int64)
        wrong = np.flatnonzero(flat >= len(position))
        if len(wrong):
            face = int(np.searchsorted(np.cumsum(sizes), int(wrong[0]), side="right"))
            raise FormatError(
                f"line {self.lines[face]} uses vertex {flat[wrong[0]] + 1}, "
                f"but there are {len(position)}"
            )
        parts = {name: np.array(found, np.int64) for name, found in self.parts.items()}
        ignored = {"line": self.ignored} if self.ignored else {}
        cells = faces(flat, sizes, np.arange(len(sizes)))
        return RawMesh(position, cells, parts, {}, ignored)
