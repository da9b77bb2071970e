"""Wavefront OBJ: vertices and faces as lines of text, with names of groups between them.

Faces may count vertices backwards from the end (-1 is the last one so far), and belong to the
groups (``g``), the object (``o``) and the material (``usemtl``) named last.
"""

from pathlib import Path

import numpy as np

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, faces, gather, known_by


@FORMATS.member(".obj")
@known_by(holds=b"\nv ")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices, faces, and the nodes of every group, object and material."""
    reader = _ObjReader()
    text = data.decode("utf-8", "replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].split()
        if words:
            reader.take(words, number)
    return reader.mesh()


class _ObjReader:
    """Collects vertices, faces and groups, line by line."""

    def __init__(self) -> None:
        self.points: list[list[float]] = []
        self.corners: list[int] = []
        self.sizes: list[int] = []
        self.lines: list[int] = []  # of the text, for messages; one for each face
        self.names: dict[str, tuple[str, ...]] = {}
        self.parts: list[tuple[str, ...]] = []
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
        except ValueError:
            raise FormatError(
                f'line {number} cannot be read: "{" ".join(words)[:40]}"'
            ) from None

    def _face(self, words: list[str], number: int) -> None:
        here = len(self.points)
        found = [int(word.split("/")[0]) for word in words]
        if len(found) < 3 or 0 in found:
            raise ValueError
        self.corners += [here + n if n < 0 else n - 1 for n in found]
        self.sizes.append(len(found))
        self.lines.append(number)
        self.parts.append(tuple(name for names in self.names.values() for name in names))

    def mesh(self) -> RawMesh:
        position = np.array(self.points, dtype=float).reshape(-1, 3)
        flat, sizes = np.array(self.corners, np.int64), np.array(self.sizes, np.int64)
        wrong = np.flatnonzero((flat < 0) | (flat >= len(position)))
        if len(wrong):
            face = int(np.searchsorted(np.cumsum(sizes), int(wrong[0]), side="right"))
            raise FormatError(
                f"line {self.lines[face]} uses vertex {flat[wrong[0]] + 1}, "
                f"but there are {len(position)}"
            )
        cells, polygons = faces(flat, sizes)
        ends = np.cumsum(sizes)
        members: dict[str, list[int]] = {}
        for face, names in enumerate(self.parts):
            for name in names:
                members.setdefault(name, []).append(face)
        groups = {
            name: gather([flat[ends[f] - sizes[f] : ends[f]] for f in found])
            for name, found in members.items()
        }
        ignored = {"line": self.ignored} if self.ignored else {}
        return RawMesh(position, cells, groups, ignored, polygons=polygons)
