"""FEBio's XML, versions 2 to 4: nodes, elements, and the sets that are named there.

Parts are blocks of elements with a name, element sets, and the materials of older files as
"material 2"; surfaces and node sets are groups of nodes. Node and element numbers may have
gaps. Beams and trusses are left out.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar
from xml.etree.ElementTree import Element

import numpy as np

from tissuec.core.errors import counted
from tissuec.meshes.formats import (
    CORNERS,
    FORMATS,
    FormatError,
    MeshCells,
    RawMesh,
    known_by,
)
from tissuec.meshes.formats.xml import parse

N = TypeVar("N", int, float)
#: Beginnings of types of elements that are no surface and no solid.
_BEAMS = ("line", "truss", "beam")
#: Beginnings of element types -> kind; the number after them is that of all nodes.
_KINDS = {
    "tet": "tetra", "hex": "hexahedron", "penta": "wedge", "pyra": "pyramid",
    "tri": "triangle", "quad": "quad", "q4": "quad",
}  # fmt: skip


@FORMATS.member(".feb")
@known_by(holds=b"<febio_spec")
def read(data: bytes, path: Path) -> RawMesh:
    """Return the mesh of an FEBio model.

    Raises:
        FormatError: The file is no FEBio model, has no mesh, or refers to another file.
    """
    root = parse(data)
    if root.tag != "febio_spec":
        raise FormatError(f'its outermost element is "{root.tag}", not "febio_spec"')
    mesh = next((found for tag in ("Mesh", "Geometry") for found in root.iter(tag)), None)
    if mesh is None:
        raise FormatError("it contains neither Mesh nor Geometry")
    if "from" in mesh.attrib:
        raise FormatError(f'its mesh is in another file, "{mesh.get("from")}"')
    return _Model(mesh).result()


class _Model:
    """The mesh section of a model."""

    def __init__(self, mesh: Element):
        self.mesh = mesh
        self.points: list[list[float]] = []
        self.number: dict[int, int] = {}  # id of a node -> row
        self.elements: dict[int, int] = {}  # id of an element -> its number from 0
        self.cells: dict[str, list[list[int]]] = {kind: [] for kind in CORNERS}
        self.parts: dict[str, list[int]] = {}
        self.groups: dict[str, list[int]] = {}
        self.curved = self.beams = 0

    def result(self) -> RawMesh:
        for block in self.mesh.findall("Nodes"):
            self._nodes(block)
        for block in self.mesh.findall("Elements"):
            self._elements(block)
        for tag in ("NodeSet", "ElementSet", "Surface"):
            for block in self.mesh.findall(tag):
                self._set(block)
        cells: list[MeshCells] = []
        for kind, rows in self.cells.items():
            if rows:  # the number of the element, and its corners
                found = np.array(rows, dtype=np.int64)
                cells.append(MeshCells(kind, found[:, 1:], found[:, 0]))
        parts, groups = (
            {name: np.unique(np.array(found, np.int64)) for name, found in named.items()}
            for named in (self.parts, self.groups)
        )
        position = np.array(self.points, dtype=float).reshape(-1, 3)
        remarks = (f"{counted(self.beams, 'beam')} left out",) if self.beams else ()
        ignored = {"beam": self.beams} if self.beams else {}
        return RawMesh(position, tuple(cells), parts, groups, ignored, self.curved, remarks)

    def _nodes(self, block: Element) -> None:
        rows: list[int] = []
        for node in block.findall("node"):
            place = _numbers(node, float)
            if len(place) != 3:
                raise FormatError(f"node {node.get('id')} has {len(place)} coordinates")
            rows.append(self._enter(node, place))
        _join(self.groups, block.get("name"), rows)

    def _enter(self, node: Element, place: list[float]) -> int:
        key = _id(node)
        if key in self.number:
            raise FormatError(f"duplicate node {key}")
        self.number[key] = len(self.points)
        self.points.append(place)
        return self.number[key]

    def _elements(self, block: Element) -> None:
        inside: list[int] = []
        for element in block:
            # Version 1 and 2.0 name the type in the element, later ones in the block.
            name = block.get("type") or element.tag
            number = self.elements[_id(element)] = len(self.elements)
            if name.lower().startswith(_BEAMS):
                self.beams += 1
                continue
            kind = self._kind(name)
            nodes = [self._node(key, element) for key in _numbers(element, int)]
            if len(nodes) < CORNERS[kind]:
                raise FormatError(f"element {element.get('id')} has {len(nodes)} nodes")
            self.curved += len(nodes) > CORNERS[kind]
            self.cells[kind].append([number, *nodes[: CORNERS[kind]]])
            inside.append(number)
            if "mat" in element.attrib:
                _join(self.parts, f"material {element.get('mat')}", [number])
        _join(self.parts, block.get("name"), inside)
        if "mat" in block.attrib:
            _join(self.parts, f"material {block.get('mat')}", inside)

    def _kind(self, name: str) -> str:
        for beginning, kind in _KINDS.items():
            if name.lower().startswith(beginning):
                return kind
        raise FormatError(f'elements of type "{name}" are not supported')

    def _set(self, block: Element) -> None:
        rows: list[int] = []
        if block.tag == "Surface":
            for facet in block:
                rows += [self._node(key, facet) for key in _numbers(facet, int)]
        elif block.tag == "NodeSet":
            rows = [self._node(key, block) for key in _ids(block)]
        else:
            for key in _ids(block):
                if key not in self.elements:
                    name = block.get("name")
                    raise FormatError(
                        f'set "{name}" contains element {key}, which does not exist'
                    )
                rows.append(self.elements[key])
        named = self.parts if block.tag == "ElementSet" else self.groups
        _join(named, block.get("name"), rows)

    def _node(self, key: int, where: Element) -> int:
        if key not in self.number:
            name = where.get("id") or where.get("name")
            raise FormatError(f'{where.tag} "{name}" contains node {key}, which does not exist')
        return self.number[key]


def _join(named: dict[str, list[int]], name: str | None, rows: list[int]) -> None:
    if name and rows:
        named.setdefault(name, []).extend(rows)


def _id(element: Element) -> int:
    try:
        return int(element.attrib["id"])
    except (KeyError, ValueError):
        raise FormatError(f"a {element.tag} has an id that is not a number") from None


def _ids(block: Element) -> Iterator[int]:
    """Yield the numbers of a set: ids of its elements up to version 2.5, a list from 3 on."""
    if len(block):
        yield from map(_id, block)
    else:
        yield from _numbers(block, int)


def _numbers(element: Element, kind: type[N]) -> list[N]:
    try:
        return [kind(word) for word in (element.text or "").replace(",", " ").split()]
    except ValueError:
        name = element.get("id") or element.get("name")
        raise FormatError(f'the numbers of {element.tag} "{name}" cannot be read') from None
