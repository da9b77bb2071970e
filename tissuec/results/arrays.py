"""The network, its sets and regions, and the recording in a result file: written and read."""

from collections.abc import Iterator, Sequence
from itertools import islice, starmap
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import asdict
from numpy.typing import NDArray

from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.laws import Law
from tissuec.laws.code import parse
from tissuec.model.inelastic import Inelastic
from tissuec.model.network import (
    BodyPart,
    Grid,
    JointPart,
    Network,
    ThreadBody,
    ToolPart,
    ToolShape,
)
from tissuec.model.phantoms import Phantoms, Reserve
from tissuec.model.springs import COLUMNS, Springs
from tissuec.results import access, schema
from tissuec.results.access import Contents, ResultGroup
from tissuec.results.element_cells import ElementCells
from tissuec.results.fields import FieldChannel, always_recorded
from tissuec.results.frame_columns import column_of
from tissuec.results.recording import LogChannel, NamedGroup, Recording
from tissuec.results.schema import REGIONS, SETS
from tissuec.results.store import Store, member_name
from tissuec.results.surface_table import read_surfaces
from tissuec.results.tables import read_channel, read_channels
from tissuec.results.volume_cells import VolumeCells


def array_of(network: Network, name: str) -> NDArray[Any]:
    """Return one of the arrays of a network in its unit, shape (node, …) or (spring, …)."""
    return network.springs.ids if name == "spring_ids" else network.array(name)


def write_network(store: Store, network: Network) -> None:
    """Write the arrays of ``network`` and the parts of its bodies."""
    store.arrays(schema.NETWORK, **{name: array_of(network, name) for name in schema.NETWORK})
    bodies, springs = network.bodies, network.springs
    store.arrays(
        schema.BODIES,
        nodes=_pairs([_range(b.nodes) for b in bodies]),
        springs=_pairs(_springs_of(bodies)),
        grid=np.array([b.grid or (0, 0, 0) for b in bodies]).reshape(-1, 3),
    )
    if network.element_count:
        names = ("elements", "edges")
        parts = {name: [_range(getattr(body, name)) for body in bodies] for name in names}
        store.arrays(schema.BODIES, **parts)
        store.array(schema.EDGES[""], network.edges)
    if network.skin_elements is not None:
        store.array(schema.SKIN_ELEMENTS[""], network.skin_elements)
    if len(solids := ElementCells.of(network)):
        store.arrays(schema.SOLIDS, **asdict(solids))
        for name in ("region_names", "tissue_names"):
            store.array(schema.SOLIDS[name], getattr(network, name))
    if network.phantoms:
        store.arrays(
            schema.PHANTOMS,
            body=[part.body for part in network.phantoms],
            nodes=[_range(part.nodes) for part in network.phantoms],
            elements=[_range(part.elements) for part in network.phantoms],
            riders=[_range(part.riders) for part in network.phantoms],
            parents=np.concatenate([part.parents for part in network.phantoms]),
        )
    _write_threads(store, network)
    _write_tools(store, network)
    if network.joints:
        names = [part.name for part in network.joints]
        store.arrays(schema.JOINTS, springs=_springs_of(network.joints), name=names)
    if springs.inelastic is not None:
        numbers = {name: getattr(springs.inelastic, name) for name in schema.INELASTIC}
        store.arrays(schema.INELASTIC, **numbers)
    store.arrays(
        schema.LAWS,
        name=[law.name for law in springs.laws],
        elastic=[law.elastic.code() for law in springs.laws],
        viscous=[law.viscous.code() for law in springs.laws],
    )
    store.arrays(schema.BODIES, name=[body.name for body in bodies])


def _write_threads(store: Store, network: Network) -> None:
    """Write which bodies are threads, if any are."""
    if not network.threads:
        return
    none = ThreadBody(slice(0, 0), 0, 0, 0.0, closed=False)
    threads = [body.thread or none for body in network.bodies]
    rows = [(*_range(one.pieces), one.hold, one.slip, one.closed) for one in threads]
    radii = [one.radius for one in threads]
    store.arrays(schema.BODIES, thread=rows, thread_radius=radii)


def _write_tools(store: Store, network: Network) -> None:
    """Write what the nodes of tools carry, if there are any."""
    if not network.tools:
        return
    shapes = [shape for tool in network.tools for shape in tool.shapes]
    store.arrays(
        schema.TOOLS,
        nodes=[_range(tool.nodes) for tool in network.tools],
        name=[tool.name for tool in network.tools],
        kind=[tool.kind for tool in network.tools],
        shape=[shape.kind for shape in shapes],
        radius=[shape.radius for shape in shapes],
    )


def read_network(file: ResultGroup, source: Source) -> Network:
    """Return the network in ``file``; its bodies come from the whole of ``source``."""
    arrays = Contents(file, schema.NETWORK).whole
    span = Span(source, 0, len(source.text))
    laws = Contents(file, schema.LAWS).rows("name", "elastic", "viscous")
    inelastic = Contents(file, schema.INELASTIC)
    phantoms = {part.body: part for part in _read_phantoms(file)}
    skin, edges = (each[""].path for each in (schema.SKIN_ELEMENTS, schema.EDGES))
    springs = Springs(
        **{name: arrays.pop(name) for name in COLUMNS},
        laws=tuple(Law(name, parse(e), parse(v)) for name, e, v in laws),
        ids=arrays.pop("spring_ids"),
        inelastic=Inelastic(**inelastic.whole) if inelastic else None,
    )
    return Network(
        **arrays,
        springs=springs,
        bodies=tuple(
            _with_reserve(body, phantoms.get(body.name)) for body in _read_bodies(file, span)
        ),
        joints=tuple(JointPart(*part, span) for part in _read_joints(file)),
        tools=tuple(_read_tools(file, span)),
        provenance={},
        skin_elements=access.array(file, skin) if skin in file else None,
        edges=access.array(file, edges) if edges in file else np.zeros((0, 2), dtype=np.int32),
        phantoms=tuple(phantoms.values()),
    )


def _with_reserve(body: BodyPart, phantoms: Phantoms | None) -> BodyPart:
    """Return a body with what it has in reserve for cuts."""
    if phantoms is None:
        return body
    size = phantoms.elements.stop - phantoms.elements.start
    riders = int(phantoms.riders.stop - phantoms.riders.start)
    nodes = len(phantoms.parents) + riders
    return replace(body, reserve=Reserve(nodes, int(size), phantoms.cuts, riders))


def _read_phantoms(file: ResultGroup) -> Iterator[Phantoms]:
    found, first = Contents(file, schema.PHANTOMS), 0
    if not found:
        return
    for name, *ranges in found.rows("body", "nodes", "elements", "riders"):
        nodes, elements, riders = (slice(*map(int, each)) for each in ranges)
        count = nodes.stop - nodes.start
        parents = found["parents"][first : first + count].astype(np.int64)
        yield Phantoms(name, nodes, parents, elements, riders=riders)
        first += count


def read_solids(file: ResultGroup) -> ElementCells:
    """Return the solid elements of the network in ``file``."""
    names = ElementCells.__struct_fields__
    found = Contents(file, {name: schema.SOLIDS[name] for name in names})
    return ElementCells(**found.whole) if found else ElementCells.none()


def _read_bodies(file: ResultGroup, span: Span) -> Iterator[BodyPart]:
    found = Contents(file, schema.BODIES)
    count = len(found["name"])
    none = np.zeros((count, 2), dtype=int)
    elements, edges = (found.get(name, none).tolist() for name in ("elements", "edges"))
    threads = found.rows("thread", "thread_radius") if "thread" in found else [None] * count
    rows = found.rows("name", "nodes", "springs", "grid")
    for (name, nodes, springs, grid), thread, of_elements, of_edges in zip(
        rows, threads, elements, edges, strict=True
    ):
        yield BodyPart(
            name, slice(*nodes), slice(*springs), span, _grid(*grid),
            thread=None if thread is None else _thread(*thread), elements=slice(*of_elements),
            edges=slice(*of_edges),
        )  # fmt: skip


def _thread(row: Sequence[int], radius: float) -> ThreadBody | None:
    first, stop, hold, slip, closed = row
    if stop <= first:
        return None
    return ThreadBody(slice(first, stop), hold, slip, radius, bool(closed))


def _read_joints(file: ResultGroup) -> Iterator[tuple[str, slice]]:
    """Yield the names of joints with their springs."""
    found = Contents(file, schema.JOINTS)
    if "name" in found:
        for name, springs in found.rows("name", "springs"):
            yield name, slice(*springs)


def _read_tools(file: ResultGroup, span: Span) -> Iterator[ToolPart]:
    """Yield the tools that have shapes."""
    found = Contents(file, schema.TOOLS)
    if not found:
        return
    shapes = starmap(ToolShape, found.rows("shape", "radius"))
    for name, kind, (start, stop) in found.rows("name", "kind", "nodes"):
        own = tuple(islice(shapes, (stop - start) // 2))
        yield ToolPart(name, kind, slice(start, stop), span, own)


def write_recording(store: Store, recording: Recording) -> None:
    """Write what is recorded, so that a resumed run records the same."""
    store.arrays(schema.RECORDING, nodes=recording.nodes, lines=recording.lines)
    for name in ("single", "compress"):
        store.group(schema.RECORDING.path).attrs[name] = getattr(recording, name)
    if recording.fields != always_recorded():  # which files have that say nothing else
        texts = [msgspec.json.encode(one).decode() for one in recording.fields]
        store.arrays(schema.RECORDING, fields=texts)
    if (cells := recording.cells) is not None:
        store.arrays(schema.CELLS, body=cells.bodies, count=cells.counts, nodes=cells.pairs)


def read_recording(file: ResultGroup) -> Recording:
    """Return the arrays recorded in ``file``."""
    group = access.group(file, schema.RECORDING.path)
    logs: list[LogChannel] = [read_channel(file, path) for path in read_channels(file).values()]
    return Recording(
        nodes=access.array(group, "nodes"),
        lines=access.array(group, "lines"),
        single=access.attribute(group, "single", bool),
        compress=access.attribute_or(group, "compress", False),
        fields=read_channels_of_frames(file),
        cells=read_volume_cells(file),
        logs=tuple(logs),
        energies=schema.ENERGIES.path in file,
        surfaces=tuple(read_surfaces(file).values()),
    )


def read_channels_of_frames(file: ResultGroup) -> tuple[FieldChannel, ...]:
    """Return the fields that frames contain."""
    path = schema.RECORDING["fields"].path
    if path not in file:  # a field that is always recorded may be newer than the file
        return tuple(
            one
            for one in always_recorded()
            if one.at == "spring" or column_of(one).path in file
        )
    texts = access.texts(file, path)
    with access.reading(file.file, path):
        return tuple(msgspec.json.decode(text, type=FieldChannel) for text in texts)


def read_volume_cells(file: ResultGroup) -> VolumeCells | None:
    """Return the cells that a file contains numbers of; None if there are none."""
    if schema.CELLS.path not in file:
        return None
    named = {name: schema.CELLS[name] for name in ("body", "count", "nodes")}
    found = Contents(file, named)
    return VolumeCells(tuple(found["body"]), found["count"], found["nodes"])


def _springs_of(parts: Sequence[BodyPart | JointPart]) -> list[tuple[int, int]]:
    return [_range(part.springs) for part in parts]


def _pairs(rows: Sequence[tuple[int, int]]) -> NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(-1, 2)


def _range(part: slice) -> tuple[int, int]:
    return part.start, part.stop


def _grid(rows: int, columns: int, closed: int) -> Grid | None:
    return Grid(rows, columns, bool(closed)) if rows else None


def write_groups(store: Store, groups: Sequence[NamedGroup]) -> None:
    """Write sets, and regions under the names of their bodies."""
    for number, group in enumerate(groups):
        title = f"{group.name} of {group.body}" if group.body else group.name
        name, body = member_name(group.name), member_name(group.body)
        dataset = REGIONS["{body}/{name}"] if group.body else SETS["{name}"]
        dataset = dataset.of(what=group.what, title=title, name=name, body=body)
        store.array(dataset, group.indices)
        attributes = {key: getattr(group, key) for key in ("name", "what", "body")}
        store.label(dataset.path, **attributes, number=number)  # the place in the scene's order


def read_groups(file: ResultGroup) -> tuple[NamedGroup, ...]:
    """Return all sets and regions, in the order of the scene."""
    found: dict[int, NamedGroup] = {}

    def visit(parent: ResultGroup) -> None:
        for member in map(parent.member, parent):
            if isinstance(member, ResultGroup):
                visit(member)
                continue
            name, what, body = (
                access.attribute(member, key, str) for key in ("name", "what", "body")
            )
            indices = member.whole()
            found[access.attribute(member, "number", int)] = NamedGroup(
                name, what, indices, body
            )

    for place in (SETS, REGIONS):
        if place.path in file:
            visit(access.group(file, place.path))
    return tuple(found[number] for number in sorted(found))
