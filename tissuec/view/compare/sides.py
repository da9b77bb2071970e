"""The two that are compared, scenes or results, and differences of their texts."""

from collections.abc import Iterator, Mapping, Sequence
from difflib import unified_diff
from pathlib import Path
from typing import Any, Literal

from msgspec import Struct

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.lang.printer import format_source
from tissuec.model.network import Network, Provenance
from tissuec.pipeline import compile_request
from tissuec.results.recording import Event, NamedGroup
from tissuec.results.trajectory import Trajectory
from tissuec.scene.force_numbers import ForceNumbers, numbers_in, numbers_of
from tissuec.scene.request import Request
from tissuec.script.plan import ScheduledAction as Scripted
from tissuec.script.procedures import stated

SIGNATURE = b"\x89HDF\r\n\x1a\n"  # with which every HDF5 file begins
RESULTS = (".vtkhdf", ".h5", ".hdf5")


class Side(Struct, frozen=True, eq=False):
    """One of the two.

    Attributes:
        name: Of the file.
        scene: What the scene is called in messages and places.
        text: The scene.
        imports: Texts that it uses, by name.
        files: Digests of the mesh files that it uses, by name.
        network: What it compiles to.
        provenance: Origins of the network's arrays, by their names.
        groups: Sets, regions and tools.
        settings: What is to be done: integrator, tolerance, duration, overrides, …
        events: What happens in it: of a scene what is scripted, of a result what happened.
        forces: What ``force`` blocks say; None of results that do not contain it.
        trajectory: Of a result.
    """

    name: str
    scene: str
    text: str
    imports: Mapping[str, str]
    files: Mapping[str, str]
    network: Network
    provenance: Mapping[str, Provenance]
    groups: tuple[NamedGroup, ...]
    settings: Mapping[str, Any]
    events: tuple[Event, ...]
    forces: Mapping[str, ForceNumbers] | None
    trajectory: Trajectory | None


def open_side(path: Path, libraries: Sequence[Path] = ()) -> Side:
    """Return a scene, compiled, or a result, opened.

    Raises:
        CompileError: It is a scene whose text is wrong.
        ResultError: It is a result that cannot be read.
    """
    if _is_result(path):
        return of_result(Trajectory.open(path))
    return of_scene(Request.file(path, libraries=libraries))


def of_result(trajectory: Trajectory) -> Side:
    """Return a result as a side; it stays open."""
    manifest = trajectory.manifest
    names = ("overrides", "integrator", "choices", "tolerance", "step", "duration")
    return Side(
        name=str(trajectory.path),
        scene=trajectory.scene,
        text=trajectory.text,
        imports=manifest.get("sources", {}),
        files=manifest.get("files", {}),
        network=trajectory.network,
        provenance=trajectory.provenance,
        groups=trajectory.groups,
        settings={name: manifest.get(name) for name in names},
        events=trajectory.events,
        forces=numbers_in(manifest),
        trajectory=trajectory,
    )


def of_scene(request: Request) -> Side:
    """Return the compiled scene as a side; CompileError if its text is wrong."""
    compiled, _ = compile_request(request)
    simulation, scene = compiled.plan.simulation, compiled.scene
    meshes = (placed.drawing.mesh for placed in compiled.groups.bodies.values())
    origins = [mesh.origin for mesh in meshes if mesh.origin is not None]
    return Side(
        name=request.source.name,
        scene=request.source.name,
        text=request.source.text,
        imports={source.name: source.text for source in scene.imports},
        files={origin.file.name: origin.digest for origin in origins},
        network=compiled.network,
        provenance=compiled.network.provenance,
        groups=tuple(compiled.named_groups()),
        settings={
            "overrides": list(request.overrides),
            "integrator": simulation.integrator,
            "choices": stated(simulation.choices, defaults=False) or None,
            "tolerance": simulation.tolerance,
            "step": simulation.step,
            "duration": simulation.duration,
        },
        events=tuple(map(_scripted, compiled.plan.events)),
        forces=numbers_of(scene.forces),
        trajectory=None,
    )


def _scripted(event: Scripted) -> Event:
    span = event.action.span
    verb = span.text.split()[0].lower()
    return Event(event.time, verb, (), span.one_line, span.place)


def _is_result(path: Path) -> bool:
    """Tell a result by how its file begins; by its name where there is none to read."""
    try:
        with path.open("rb") as file:
            return file.read(len(SIGNATURE)) == SIGNATURE or path.suffix in RESULTS
    except OSError:
        return path.suffix in RESULTS


class TextDifference(Struct, frozen=True):
    """A text that is not the same, or that only one of the two uses.

    Attributes:
        name: Of a file that is used; "scene" for the scene itself.
        kind: "changed", "only in a" or "only in b".
        lines: Of a changed one, a unified diff.
    """

    name: str
    kind: Literal["changed", "only in a", "only in b"]
    lines: tuple[str, ...] = ()


def compare_texts(a: Side, b: Side) -> Iterator[TextDifference]:
    """Yield the scene if it differs, and then the files that it uses; blanks do not count."""
    yield from _changed("scene", a.text, b.text, a.scene, b.scene)
    for name in {**a.imports, **b.imports}:
        if name not in b.imports:
            yield TextDifference(name, "only in a")
        elif name not in a.imports:
            yield TextDifference(name, "only in b")
        else:
            yield from _changed(name, a.imports[name], b.imports[name], name, name)


def changed_files(a: Mapping[str, str], b: Mapping[str, str]) -> Iterator[TextDifference]:
    """Yield files that differ by digest, such as meshes."""
    for name in {**a, **b}:
        if name not in b:
            yield TextDifference(name, "only in a")
        elif name not in a:
            yield TextDifference(name, "only in b")
        elif a[name] != b[name]:
            yield TextDifference(name, "changed")


def _changed(name: str, a: str, b: str, name_a: str, name_b: str) -> Iterator[TextDifference]:
    if a == b:
        return
    before, after = (canonical(text).splitlines() for text in (a, b))
    lines = unified_diff(before, after, f"a: {name_a}", f"b: {name_b}", lineterm="")
    if found := tuple(lines):
        yield TextDifference(name, "changed", found)


def canonical(text: str) -> str:
    """Return a text in canonical layout, or unchanged if this version cannot read it."""
    try:
        return format_source(Source("", text))
    except CompileError:
        return text
