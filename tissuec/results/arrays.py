"""The network and the recording in a result file: written once, read to resume and to show."""

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.source import Source, Span
from tissuec.laws import Law
from tissuec.laws.code import parse
from tissuec.model.inelastic import Inelastic
from tissuec.model.network import (
    BodyPart,
    Grid,
    JointPart,
    MarkPart,
    MemoryPart,
    Network,
    ThreadBody,
    ToolPart,
    ToolShape,
)
from tissuec.model.springs import COLUMNS, Springs
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.field_table import (
    read_channels_of_frames,
    read_volume_cells,
    write_channels_of_frames,
    write_volume_cells,
)
from tissuec.results.recording import LogChannel, Recording
from tissuec.results.store import LARGE, Store
from tissuec.results.surface_table import read_surfaces
from tissuec.results.tables import ENERGY_PATH, read_channel, read_channels

NETWORK = "/tissuec/network"
RECORDING = "/tissuec/recording"
ARRAYS = {
    "position": ("m", "drawn position of each node"),
    "velocity": ("m/s", "initial velocity of each node"),
    "mass": ("kg", "mass of each node"),
    "ends": ("", "node pair of each spring, numbered from 0"),
    "stiffness": ("N/m", "spring constant of each spring"),
    "damping": ("N*s/m", "viscosity of each spring"),
    "rest": ("m", "rest length of each spring"),
    "strength": ("N", "breaking force of each spring; infinite: it never ruptures"),
    "crush": ("N", "crushing force of each spring; infinite: pressure does not break it"),
    "law": ("", "law of each spring, as a number among the laws"),
    "skin": ("", "triangles of the bodies' surfaces, as nodes"),
    "node_ids": ("", "id of each node, as the scene numbers them"),
    "spring_ids": ("", "id of each spring, as the scene numbers them"),
}
INELASTIC = {
    "constant": ("N/m", "constant of each branch of each spring"),
    "time": ("s", "relaxation time of each branch of each spring; infinite: it has none"),
    "limit": ("N", "yield force of each spring; infinite: it never yields"),
    "viscosity": ("N*s/m", "yield viscosity of each spring; infinite: it never yields"),
    "slot": (
        "",
        "indices of internal variables of springs in the array of all velocity components",
    ),
    "rate": ("1/s", "factor of these components"),
}


def array_of(network: Network, name: str) -> NDArray[Any]:
    """Return one of ``ARRAYS`` of a network in its unit, shape (node, …) or (spring, …)."""
    return network.springs.ids if name == "spring_ids" else network.array(name)


def write_network(store: Store, network: Network) -> None:
    """Write the arrays of ``network`` and the parts of its bodies."""
    for name, (unit, description) in ARRAYS.items():
        value = array_of(network, name)
        compress = len(value) >= LARGE
        store.array(f"{NETWORK}/{name}", value, description, unit=unit, compress=compress)
    bodies = network.bodies
    table = {
        "nodes": ("first node and the one after the last", [_range(b.nodes) for b in bodies]),
        "springs": (
            "first spring and the one after the last",
            [_range(b.springs) for b in bodies],
        ),
    }
    for name, (description, rows) in table.items():
        data = np.array(rows, dtype=np.int64).reshape(-1, 2)
        store.array(f"{NETWORK}/bodies/{name}", data, f"{description} of each body")
    grids = np.array([b.grid or (0, 0, 0) for b in bodies], dtype=np.int64).reshape(-1, 3)
    text = "rows, columns, and 1 if the last column is joined to the first; 0 without a grid"
    store.array(f"{NETWORK}/bodies/grid", grids, text)
    if any(b.elements for b in bodies):
        text = "number of finite elements of each body"
        elements = np.array([b.elements for b in bodies], dtype=np.int64)
        store.array(f"{NETWORK}/bodies/elements", elements, text)
    _write_threads(store, network)
    _write_tools(store, network)
    if network.joints:
        rows = np.array([_range(joint.springs) for joint in network.joints], dtype=np.int64)
        text = f"{table['springs'][0]} of each joint"
        store.array(f"{NETWORK}/joints/springs", rows, text)
        _write_names(store, f"{NETWORK}/joints", "joint", network.joints)
    if network.marks:
        rows = np.array([_range(part.springs) for part in network.marks], dtype=np.int64)
        text = (
            "of each body whose elements can break: the first spring that represents one of "
            "them, without any force, and the one after the last"
        )
        store.array(f"{NETWORK}/marks/springs", rows, text)
        _write_names(store, f"{NETWORK}/marks", "such body", network.marks)
    if network.skin_marks is not None:
        text = "of each triangle of the skin: the spring that represents its element, or -1"
        store.array(f"{NETWORK}/marks/skin", network.skin_marks, text)
    shown = np.array([network.shown_nodes, network.node_count])
    text = "first internal node, which only stores state, and the one after the last"
    store.array(f"{NETWORK}/hidden", shown, text)
    springs = network.springs
    if springs.inelastic is not None:
        for name, (unit, description) in INELASTIC.items():
            value = getattr(springs.inelastic, name)
            store.array(f"{NETWORK}/inelastic/{name}", value, description, unit=unit)
    for name, (description, texts) in {
        "name": ("name of each law", [law.name for law in springs.laws]),
        "elastic": ("force by e, c and rest", [law.elastic.code() for law in springs.laws]),
        "viscous": ("force by e, w, d and rest", [law.viscous.code() for law in springs.laws]),
    }.items():
        store.texts(f"{NETWORK}/laws/{name}", texts, description)
    _write_names(store, f"{NETWORK}/bodies", "body", bodies)


def _write_threads(store: Store, network: Network) -> None:
    """Write which bodies are threads, if any are."""
    if not network.threads:
        return
    none = ThreadBody(slice(0, 0), 0, 0, 0.0, closed=False)
    threads = [body.thread or none for body in network.bodies]
    rows = [(*_range(one.pieces), one.hold, one.slip, one.closed) for one in threads]
    text = (
        "of each body that is a thread: its first piece and the spring after its last one, "
        "the springs that its knot holds and slips by, and 1 if it is a loop"
    )
    store.array(f"{NETWORK}/bodies/thread", np.array(rows, dtype=np.int64), text)
    radii = np.array([one.radius for one in threads])
    text = "radius of each body that is a thread; 0 of the others"
    store.array(f"{NETWORK}/bodies/thread_radius", radii, text, unit="m")


def _write_tools(store: Store, network: Network) -> None:
    """Write what the nodes of tools carry, if there are any."""
    if not network.tools:
        return
    path = f"{NETWORK}/tools"
    rows = np.array([_range(tool.nodes) for tool in network.tools], dtype=np.int64)
    store.array(f"{path}/nodes", rows, "first node and the one after the last of each tool")
    _write_names(store, path, "tool", network.tools)
    shapes = [shape for tool in network.tools for shape in tool.shapes]
    for name, texts, description in (
        ("kind", [tool.kind for tool in network.tools], "kind of each tool"),
        ("shape", [shape.kind for shape in shapes], "what each pair of their nodes carries"),
    ):
        store.texts(f"{path}/{name}", texts, description)
    radii = np.array([shape.radius for shape in shapes], dtype=float)
    store.array(f"{path}/radius", radii, "radius of each shape; 0 of planes", unit="m")


def _write_names(
    store: Store,
    path: str,
    what: str,
    parts: Sequence[BodyPart | JointPart | MarkPart | ToolPart],
) -> None:
    store.texts(f"{path}/name", [part.name for part in parts], f"name of each {what}")


def read_network(file: ResultGroup, source: Source) -> Network:
    """Return the network in ``file``; its bodies come from the whole of ``source``."""
    arrays: dict[str, Any] = {name: access.array(file, f"{NETWORK}/{name}") for name in ARRAYS}
    group = access.group(file, f"{NETWORK}/bodies")
    span = Span(source, 0, len(source.text))
    names, nodes, springs = (
        access.texts(group, "name"),
        access.array(group, "nodes").tolist(),
        access.array(group, "springs").tolist(),
    )
    grids = access.array(group, "grid").tolist()
    bodies = tuple(
        BodyPart(
            name, slice(*n), slice(*s), span, _grid(*grid), thread=thread, elements=elements
        )
        for name, n, s, grid, thread, elements in zip(
            names,
            nodes,
            springs,
            grids,
            _read_threads(group, len(names)),
            _read_elements(group, len(names)),
            strict=True,
        )
    )
    laws = access.group(file, f"{NETWORK}/laws")
    texts = (access.texts(laws, name) for name in ("name", "elastic", "viscous"))
    hidden = slice(*access.array(file, f"{NETWORK}/hidden").tolist())
    memories = (MemoryPart("", hidden),) if hidden.start < hidden.stop else ()
    inelastic = None
    if _holds(file, "inelastic"):
        numbers = {
            name: access.array(file, f"{NETWORK}/inelastic/{name}") for name in INELASTIC
        }
        inelastic = Inelastic(**numbers)
    springs = Springs(
        **{name: arrays.pop(name) for name in COLUMNS},
        laws=tuple(Law(n, parse(e), parse(v)) for n, e, v in zip(*texts, strict=True)),
        ids=arrays.pop("spring_ids"),
        inelastic=inelastic,
    )
    return Network(
        **arrays,
        springs=springs,
        bodies=bodies,
        joints=tuple(
            JointPart(name, place, span) for name, place in _read_parts(file, "joints")
        ),
        tools=_read_tools(file, span),
        provenance={},
        memories=memories,
        marks=tuple(MarkPart(name, place, span) for name, place in _read_parts(file, "marks")),
        skin_marks=access.array(file, f"{NETWORK}/marks/skin")
        if _holds(file, "marks/skin")
        else None,
    )


def _read_parts(file: ResultGroup, what: str) -> Iterator[tuple[str, slice]]:
    """Yield names of parts, such as "joints", with their springs."""
    if not _holds(file, what):
        return
    group = access.group(file, f"{NETWORK}/{what}")
    springs = access.array(group, "springs").tolist()
    for name, place in zip(access.texts(group, "name"), springs, strict=True):
        yield name, slice(*place)


def _read_threads(bodies: ResultGroup, count: int) -> list[ThreadBody | None]:
    """Return which bodies are threads."""
    if "thread" not in bodies:
        return [None] * count
    rows = access.array(bodies, "thread").tolist()
    radii = access.array(bodies, "thread_radius").tolist()
    return [
        ThreadBody(slice(first, stop), hold, slip, radius, bool(closed))
        if stop > first
        else None
        for (first, stop, hold, slip, closed), radius in zip(rows, radii, strict=True)
    ]


def _read_elements(bodies: ResultGroup, count: int) -> list[int]:
    """Return how many finite elements each body has."""
    return access.array(bodies, "elements").tolist() if "elements" in bodies else [0] * count


def _read_tools(file: ResultGroup, span: Span) -> tuple[ToolPart, ...]:
    """Return the tools that have shapes."""
    if not _holds(file, "tools"):
        return ()
    group = access.group(file, f"{NETWORK}/tools")
    radii = access.array(group, "radius").tolist()
    shapes = iter(map(ToolShape, access.texts(group, "shape"), radii))
    return tuple(
        ToolPart(
            name, kind, slice(start, stop), span, tuple(islice(shapes, (stop - start) // 2))
        )
        for name, kind, (start, stop) in zip(
            access.texts(group, "name"),
            access.texts(group, "kind"),
            access.array(group, "nodes").tolist(),
            strict=True,
        )
    )


def _holds(file: ResultGroup, name: str) -> bool:
    """Return whether a result says something of its network."""
    return f"{NETWORK}/{name}" in file


def write_recording(store: Store, recording: Recording) -> None:
    """Write what is recorded, so that a resumed run records the same."""
    for name in ("nodes", "springs"):
        data = np.asarray(getattr(recording, name), dtype=np.int64)
        text = f"network numbers of the {name} in the frames"
        store.array(f"{RECORDING}/{name}", data, text, compress=len(data) >= LARGE)
    for name in ("single", "compress"):
        store.group(RECORDING).attrs[name] = getattr(recording, name)
    write_channels_of_frames(store, recording.fields)
    if recording.cells is not None:
        write_volume_cells(store, recording.cells)


def read_recording(file: ResultGroup) -> Recording:
    """Return the arrays recorded in ``file``."""
    group = access.group(file, RECORDING)
    logs: list[LogChannel] = [read_channel(file, path) for path in read_channels(file).values()]
    return Recording(
        nodes=access.array(group, "nodes"),
        springs=access.array(group, "springs"),
        single=access.attribute(group, "single", bool),
        compress=access.attribute_or(group, "compress", False),
        fields=read_channels_of_frames(file),
        cells=read_volume_cells(file),
        logs=tuple(logs),
        energies=ENERGY_PATH in file,
        surfaces=tuple(read_surfaces(file).values()),
    )


def _range(part: slice) -> tuple[int, int]:
    return part.start, part.stop


def _grid(rows: int, columns: int, closed: int) -> Grid | None:
    return Grid(rows, columns, bool(closed)) if rows else None
