"""The datasets of a result file, each declared once.

Writing takes paths, types, units and descriptions from here, reading the paths, the predicted
size the bytes of rows, and the manual its tables.
"""

from collections.abc import Mapping
from typing import Any

from tissuec.results.datasets import CHUNK, FEW, FLOAT, TEXT, DatasetSpec, GroupSpec

ROOT = "/VTKHDF"
_TURN = "just before and just after each event, in turn"
_ENDS = "and the one after the last"


def _array(axes: str, text: str, unit: str = "", kind: str = "f8", **more: Any) -> DatasetSpec:
    """Return a dataset whose axes are given by names and lengths."""
    counted = (int(axis) if axis.isdecimal() else axis for axis in axes.split())
    return DatasetSpec(tuple(counted), text, unit, kind, **more)


def _integers(axes: str, text: str, **more: Any) -> DatasetSpec:
    return _array(axes, text, kind="i8", **more)


def _texts(axes: str, text: str, **more: Any) -> DatasetSpec:
    return _array(axes, text, kind=TEXT, **more)


# --- the run --------------------------------------------------------------------------------

SCENE = GroupSpec(
    "/tissuec/scene", "the text of the scene", {"": _texts("", "the scene as it was run")}
)
MANIFEST = GroupSpec(
    "/tissuec/manifest",
    "as JSON and as attributes: what the scene says "
    "[about itself](language/text.md#authors-and-licence) (`about`, `author`, `laboratory`, "
    "`licence`, `cite`), inputs and `--set` values, the texts and tables that the scene uses, "
    "start time, versions, digest of the text, the method and the reason for its choice, "
    "outcome, and the result of each expectation with the measured value",
    {"": _texts("", "origin of this result, as JSON")},
)
SUMS = GroupSpec(
    "/tissuec/checksums",
    "type, shape and CRC-32 of each dataset, as JSON preceded by its own CRC-32. Frame data "
    "has no entry here (`null`); each of its chunks has a Fletcher-32 checksum",
    {"": _texts("", "kind, shape and CRC-32 of all datasets")},
)
CHECKPOINT = GroupSpec(
    "/tissuec/checkpoint",
    "the state from which an interrupted run can be resumed",
    {
        "state/{name}": _array("", "part of the state for resuming", kind=""),
        "rows": _texts("", "rows of every growing dataset, as JSON"),
        "version": _texts("", "of this format and of tissuec"),
        "scene": _texts("", "SHA-256 of the scene and the network"),
        "alive": _array(
            "entity", "which springs, edges of elements and elements were alive", kind="bool"
        ),
        "wall_time": _array("", "how long it had taken", "s"),
    },
    when="runs that were interrupted, or took longer than five seconds",
)
RECORDING = GroupSpec(
    "/tissuec/recording",
    "which nodes, springs, edges of elements and further fields the frames contain",
    {
        "nodes": _integers("node", "network numbers of the nodes in the frames"),
        "lines": _integers(
            "line", "network numbers of the springs and edges of elements in the frames"
        ),
        "fields": _texts("field", "fields that frames contain, as JSON"),
    },
    packed="large",
)

# --- the network ----------------------------------------------------------------------------

NETWORK = GroupSpec(
    "/tissuec/network",
    "the net before the run. Joints follow the bodies, in the order of the scene; the nodes of "
    "bodies are followed by those of tools that have a shape",
    {
        "position": _array("node 3", "drawn position of each node", "m"),
        "velocity": _array("node 3", "initial velocity of each node", "m/s"),
        "mass": _array("node", "mass of each node", "kg"),
        "ends": _array("spring 2", "node pair of each spring, numbered from 0", kind="i4"),
        "stiffness": _array("spring", "spring constant of each spring", "N/m"),
        "damping": _array("spring", "viscosity of each spring", "N*s/m"),
        "rest": _array("spring", "rest length of each spring", "m"),
        "strength": _array(
            "spring", "breaking force of each spring; infinite: it never ruptures", "N"
        ),
        "crush": _array(
            "spring", "crushing force of each spring; infinite: pressure does not break it", "N"
        ),
        "law": _array("spring", "law of each spring, as a number among the laws", kind="i4"),
        "skin": _array("triangle 3", "triangles of the bodies' surfaces, as nodes", kind="i4"),
        "node_ids": _integers("node", "id of each node, as the scene numbers them"),
        "spring_ids": _integers("spring", "id of each spring, as the scene numbers them"),
    },
    packed="large",
)
SOLIDS = GroupSpec(
    "/tissuec/network/solids",
    "solid elements, body after body",
    {
        "types": _array(
            "element", "VTK's number of the shape of each solid element", kind="u1"
        ),
        "nodes": _array("row", "nodes of each, one after another", kind="i4"),
        "entities": _array(
            "element", "number of each, behind those of springs and edges", kind="i4"
        ),
        "region": _array("element", "region of each among region_names, from 0", kind="i4"),
        "tissue": _array("element", "tissue of each among tissue_names, from 0", kind="i4"),
        "fibres": _array(
            "element family 3", "directions of families of fibres as drawn; 0 without fibres"
        ),
        "region_names": _texts("region", "names of regions; the first stands for none"),
        "tissue_names": _texts("tissue", "names of tissues"),
    },
    packed="large",
    when="scenes with solid elements",
)
LAWS = GroupSpec(
    "/tissuec/network/laws",
    "the laws of springs",
    {
        "name": _texts("law", "name of each law"),
        "elastic": _texts("law", "force by e, c and rest"),
        "viscous": _texts("law", "force by e, w, d and rest"),
    },
)
BODIES = GroupSpec(
    "/tissuec/network/bodies",
    "the bodies of the network",
    {
        "nodes": _integers("body 2", f"first node {_ENDS} of each body"),
        "springs": _integers("body 2", f"first spring {_ENDS} of each body"),
        "grid": _integers(
            "body 3",
            "rows, columns, and 1 if the last column is joined to the first; 0 without a grid",
        ),
        "edges": _integers(
            "body 2",
            f"first edge of elements {_ENDS} of each body; they follow springs in number",
        ),
        "elements": _integers(
            "body 2",
            f"first finite element {_ENDS} of each body; their numbers follow those of edges",
        ),
        "thread": _integers(
            "body 5",
            "of each body that is a thread: its first piece and the spring after its last one, "
            "the springs that its knot holds and slips by, and 1 if it is a loop",
        ),
        "thread_radius": _array(
            "body", "radius of each body that is a thread; 0 of the others", "m"
        ),
        "name": _texts("body", "name of each body"),
    },
)
JOINTS = GroupSpec(
    "/tissuec/network/joints",
    "the joints of the network",
    {
        "springs": _integers("joint 2", f"first spring {_ENDS} of each joint"),
        "name": _texts("joint", "name of each joint"),
    },
    when="scenes with joints",
)
SKIN_ELEMENTS = GroupSpec(
    "/tissuec/network/skin_elements",
    "the element of each triangle of the skin, as numbers that follow those of edges, or -1",
    {"": _integers("triangle", "element of each triangle of the skin")},
    when="scenes with elements that can break",
)
PHANTOMS = GroupSpec(
    "/tissuec/network/phantoms",
    "phantom nodes of bodies of elements that are cut or can tear, which follow those of the "
    "bodies, and numbers for the parts of their elements, which follow those of the elements",
    {
        "body": _texts("body", "name of each body"),
        "nodes": _integers("body 2", f"first phantom node {_ENDS} of each body"),
        "elements": _integers("body 2", f"first number of parts {_ENDS} of each body"),
        "parents": _array("phantom", "the node that each phantom node is a copy of", kind="i4"),
        "riders": _integers("body 2", f"first riding node {_ENDS} of each body"),
    },
    packed="large",
    when="scenes that cut bodies of elements, or in which solids can tear",
)
EDGES = GroupSpec(
    "/tissuec/network/edges",
    "edges of elements, body after body",
    {"": _array("edge 2", "node pair of each edge", kind="i4")},
    packed="large",
    when="scenes with elements",
)
INELASTIC = GroupSpec(
    "/tissuec/network/inelastic",
    "springs that relax or yield",
    {
        "constant": _array("branch spring", "constant of each branch of each spring", "N/m"),
        "time": _array(
            "branch spring",
            "relaxation time of each branch of each spring; infinite: it has none",
            "s",
        ),
        "limit": _array("spring", "yield force of each spring; infinite: it never yields", "N"),
        "viscosity": _array(
            "spring", "yield viscosity of each spring; infinite: it never yields", "N*s/m"
        ),
        "slot": _integers(
            "variable spring",
            "indices of internal variables of springs in the array of all velocity components",
        ),
        "rate": _array("variable spring", "factor of these components", "1/s"),
    },
    when="scenes with springs that relax or yield",
)
TOOLS = GroupSpec(
    "/tissuec/network/tools",
    "the nodes of tools that have a shape, which follow those of the bodies",
    {
        "nodes": _integers("tool 2", f"first node {_ENDS} of each tool"),
        "name": _texts("tool", "name of each tool"),
        "kind": _texts("tool", "kind of each tool"),
        "shape": _texts("shape", "what each pair of their nodes carries"),
        "radius": _array("shape", "radius of each shape; 0 of planes", "m"),
    },
    when="scenes whose tools have shapes",
)
ORIGINS = GroupSpec(
    "/tissuec/network/origins",
    "the sources of the values of the network: places in texts",
    {
        "text": _texts("origin", "name of the text of each origin"),
        "how": _texts("origin", "how the value is given: written, rules, table, …"),
        "span": _integers("origin 2", "its first character and the one after its last"),
    },
)
ORIGINS_OF = GroupSpec(
    "/tissuec/network/origins/of",
    "for each entry of an array of the network, the row of its source in the table above",
    {"{array}": _array("entry", "row of the origin of each entry of {array}", kind="i4")},
    packed="most",
)
SETS = GroupSpec(
    "/tissuec/sets",
    "the nodes or springs of each set, and the nodes of tools that have a shape",
    {"{name}": _integers("member", "network numbers of the {what} of: {title}")},
    packed="most",
    when="scenes with sets",
)
REGIONS = GroupSpec(
    "/tissuec/regions",
    "the nodes of each region of a body",
    {"{body}/{name}": _integers("member", "network numbers of the {what} of: {title}")},
    packed="most",
    when="scenes with regions",
)

# --- rows that come in time -----------------------------------------------------------------

EVENTS = GroupSpec(
    "/tissuec/events",
    "all events with the affected springs, edges of elements and elements, which are "
    "`spring_count` rows of `springs` from `first_spring`. With elements that break, the edges "
    "are named that are lost with them",
    {
        "time": _array("event", "time of each event", "s"),
        "kind": _texts("event", "what happened: cut, rupture, grasp, …"),
        "cause": _texts("event", "why it happened"),
        "place": _texts("event", "file:line of the sentence that caused it"),
        "first_spring": _integers("event", "where its springs begin in springs"),
        "spring_count": _integers("event", "how many springs it concerns"),
        "springs": _integers(
            "row", "network numbers of the springs of all events", chunk=CHUNK
        ),
    },
    chunk=FEW,
)
HOLDS = GroupSpec(
    "/tissuec/holds",
    "which nodes are held from a time on, and by what: `node_count` rows of `nodes` from "
    "`first_node`, until the next row of the same holder",
    {
        "time": _array("hold", "start time of each hold", "s"),
        "holder": _texts("hold", 'who holds: "fix", a tool or a set'),
        "first_node": _integers("hold", "where its nodes begin in nodes"),
        "node_count": _integers("hold", "how many nodes are held; 0: none"),
        "nodes": _integers("row", "network numbers of the nodes held", chunk=CHUNK),
    },
    chunk=FEW,
)


def _log(path: str, about: str, *, jumps: bool = True, when: str = "") -> GroupSpec:
    """Return the datasets of a log; ``columns`` are texts, or the ids of nodes or springs."""
    datasets = {
        "time": _array("moment", "times of: {what}", "s", chunk=CHUNK),
        "value": _array("moment column", "{what}", "{unit}", chunk=CHUNK),
        "columns": _array("column", "what the columns of value are: {what}", kind=""),
        "jumps/time": _array(
            "jump", "times of ruptures and of events that changed: {what}", "s", chunk=FEW
        ),
    }
    for side in ("before", "after"):
        text = f"just {side} each event: {{what}}"
        datasets[f"jumps/{side}"] = _array("jump column", text, "{unit}", chunk=FEW)
    if not jumps:
        datasets = {name: datasets[name] for name in ("time", "value", "columns")}
    return GroupSpec(path, about, datasets, when=when)


LOGS = _log(
    "/tissuec/logs/{log}",
    "one group per log. `jumps` are the values on both sides of each event that changed it "
    "abruptly; logs with more than 1024 columns have none",
    when="scenes with logs",
)
ENERGIES = _log(
    "/tissuec/energies",
    "a log of the energies; the columns are kinetic, elastic, gravity, work, dissipated, "
    "switched",
    when="scenes that record energies",
)
ERRORS = _log(
    "/tissuec/errors",
    "the error of the positions at each frame: the sum of the error estimates of all steps so "
    "far",
    jumps=False,
)
COMPANION = _log(
    "/tissuec/companion",
    "the largest distance between this run and its companion run up to each time",
    jumps=False,
    when="runs with a companion run",
)

# --- frames ---------------------------------------------------------------------------------


STEPS = {
    "Values": _array("frame", "time of each frame", "s"),
    "PartOffsets": _integers("frame", "part of each frame"),
    "NumberOfParts": _integers("frame", "parts of each frame: one"),
    "PointOffsets": _integers("frame", "first point of each frame"),
    "CellOffsets": _integers("frame", "first cell of each frame"),
    "ConnectivityIdOffsets": _integers("frame", "first row of Connectivity of each frame"),
}


CELL_TABLE = {
    "NumberOfPoints": _integers("part", "points of each part", chunk=FEW),
    "NumberOfCells": _integers("part", "cells of each part", chunk=FEW),
    "NumberOfConnectivityIds": _integers("part", "point numbers of each part", chunk=FEW),
    "Types": _array(
        "cell",
        "VTK's number of the type of each cell: 1 vertex, 3 line, 5 triangle, 12 hexahedron, "
        "13 wedge, 24 tetrahedron with ten nodes, 29 hexahedron with 27 nodes",
        kind="u1",
        packed="large",
    ),
    "Offsets": _integers(
        "cell",
        "where each cell begins in Connectivity; one entry more than cells",
        packed="large",
    ),
    "Connectivity": _integers("row", "points of the cells", packed="large", in_parts=True),
}


def _grid(path: str, about: str, more: Mapping[str, DatasetSpec], when: str = "") -> GroupSpec:
    """Return a group of an unstructured grid with steps: one part for each set of cells."""
    steps = {f"Steps/{name}": one for name, one in STEPS.items()}
    return GroupSpec(path, about, {**CELL_TABLE, **steps, **more}, when=when, chunk=CHUNK)


def _numbers(axes: str, text: str, unit: str = "{unit}", chunk: int = CHUNK) -> DatasetSpec:
    """Return numbers of frames, which are read in parts."""
    return _array(axes, text, unit, FLOAT, chunk=chunk, in_parts=True)


def _fibres(what: str) -> DatasetSpec:
    text = f"direction of {what} of each solid element as drawn; 0 at other cells"
    return _array("cell 3", text, packed="large")


FRAMES = _grid(
    ROOT,
    "frames as a VTK UnstructuredGrid with steps: springs as lines, triangles of walls and of "
    "skins, and solid elements as volume cells, in this order behind single nodes. Parts of "
    "cut elements follow as tetrahedra, VTK's type 10. Frames are concatenated: `Points` has "
    "frames × nodes rows; after a cut, the nodes of each frame are followed by riding points. "
    "Topologies are written once, as parts",
    {
        "CellData/spring_id": _integers(
            "cell", "id of each line's spring; -1 at other cells", packed="large"
        ),
        "CellData/region": _integers(
            "cell",
            "region of each solid element, as in `/tissuec/network/solids`; -1 at other cells",
            packed="large",
        ),
        "CellData/tissue": _integers(
            "cell",
            "tissue of each solid element, as in `/tissuec/network/solids`; -1 at other cells",
            packed="large",
        ),
        "CellData/fibres": _fibres("the fibres"),
        "CellData/second_fibres": _fibres("the second fibres"),
        "Points": _numbers("node 3", "position of each node, frame after frame", "m"),
        "PointData/{field}": _numbers("node …", "{what}, frame after frame{elsewhere}"),
        "CellData/{field}": _numbers("cell", "{what}, frame after frame; 0 at other cells"),
        "PointData/node_id": _integers("node", "id of each node, the same in all frames"),
        "Steps/PointDataOffsets/{field}": _integers(
            "frame", "where each frame begins in PointData/{field}"
        ),
        "Steps/CellDataOffsets/{field}": _integers(
            "frame", "where each frame begins in CellData/{field}"
        ),
    },
)
PARTS = GroupSpec(
    "/tissuec/parts",
    "what exists in each part of the frames",
    {
        "alive": _array(
            "byte",
            "which springs, edges of elements and elements exist in each part, eight in a "
            "byte, part after part",
            kind="u1",
            in_parts=True,
        )
    },
    chunk=CHUNK,
)


def _numbered(axes: str, text: str) -> DatasetSpec:
    return _array(axes, text, kind="i4", packed="large")


CUT_CELLS = GroupSpec(
    "/tissuec/cut_cells",
    "the parts of all elements that were ever cut, as tetrahedra and triangles; a later cut "
    "adds rows. Those whose entity exists are drawn. Corners are numbers of nodes of the "
    "network or, from the number of nodes on, of riding points: weighted sums of nodes",
    {
        "host_count": _numbered("point", "number of nodes that each riding point is a sum of"),
        "hosts": _numbered("row", "these nodes, point after point"),
        "weights": _array("row", "their weights, which add up to 1", packed="large"),
        "parts": _numbered("part", "entity of each part"),
        "wholes": _numbered("part", "entity of the element that it is a part of"),
        "corners": _numbered("tetrahedron 4", "corners of each tetrahedron"),
        "owners": _numbered("tetrahedron", "entity of the part that it belongs to"),
        "triangles": _numbered("triangle 3", "corners, as seen from outside"),
        "borders": _numbered("triangle", "entity of the part that it bounds"),
        "cuts": _numbered(
            "triangle",
            "the cut of its body that it is a face of, a number from 1 on, above 0 in front of "
            "the cut and below 0 behind it; 0 on the surface as drawn",
        ),
    },
    when="runs that cut elements in parts",
    chunk=CHUNK,
)
SURFACES = _grid(
    "/tissuec/surfaces/{body}",
    "a smooth surface, in the layout of `/VTKHDF`. Each tear starts a new part, which has "
    "other triangles and can have fewer points. `Steps/PointOffsets` is the first point of a "
    "frame; `NumberOfPoints` at its `Steps/PartOffsets` is the number of points",
    {
        "Points": _numbers(
            "point 3", "position of each point of the surface, frame after frame", "m"
        )
    },
    when="scenes with smooth surfaces",
)
CELLS = GroupSpec(
    "/tissuec/cells",
    "the cells of preserved volumes and, for each field of cells, their numbers",
    {
        "body": _texts("body", "bodies whose volume may be preserved"),
        "count": _integers("body", "number of cells of each body"),
        "nodes": _integers("pair 2", "nodes, and the cells around them"),
        "{field}": _numbers("cell", "{what}, frame after frame"),
    },
    when="scenes that record a field of cells",
)
SIDES = GroupSpec(
    "/tissuec/sides",
    "the net just before and just after each event, in turn, with positions, velocities and "
    "all fields. At most 64 events are recorded, and of events within a thousandth of the time "
    "between frames only the first",
    {
        "time": _array("side", f"times {_TURN}", "s", chunk=FEW),
        "alive": _array(
            "byte",
            "which springs, edges of elements and elements of the network exist, eight in a "
            f"byte; {_TURN}",
            kind="u1",
            chunk=CHUNK,
            in_parts=True,
        ),
        "{field}": _numbers("item …", f"{{what}}; {_TURN}"),
    },
    when="scenes with a trajectory in which something happens after the start",
)
TOOL_FRAMES = GroupSpec(
    "/tissuec/tools",
    "positions of the nodes of tools in each frame, two for each shape; see `network/tools`",
    {
        "position": _numbers(
            "node 3",
            "position of each node of the shapes of tools, frame after frame",
            "m",
            1024,
        )
    },
    when="scenes whose tools have shapes",
)
PARTICLES = GroupSpec(
    "/particles/all",
    "positions, velocities and fields of nodes in the layout of H5MD 1.1. `value` and `time` "
    "are those of `/VTKHDF` under other names, need no disk space and are created when the run "
    "ends",
    {
        "mass": _array("node", "mass of each node", "kg"),
        "id": _integers("node", "id of each node"),
        "{field}/value": _array("frame node …", "{field} of each node [{unit}]", kind=FLOAT),
        "{field}/step": _integers("frame", "number of each frame"),
        "{field}/time": _array("frame", "time of each frame", "s"),
    },
)
GROUPS = (
    FRAMES, PARTS, CUT_CELLS, PARTICLES, SIDES, CELLS, TOOL_FRAMES, SURFACES, LOGS, ENERGIES,
    ERRORS, COMPANION, EVENTS, HOLDS, SCENE, MANIFEST, RECORDING, NETWORK, SOLIDS, LAWS,
    BODIES, JOINTS, TOOLS, EDGES, PHANTOMS, INELASTIC, SKIN_ELEMENTS, ORIGINS, ORIGINS_OF,
    SETS, REGIONS, CHECKPOINT, SUMS,
)  # fmt: skip
"""All groups, in the order of the manual."""
