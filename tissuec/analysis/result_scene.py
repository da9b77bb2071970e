"""The scene of a result, compiled again from the texts in the file, and its anatomy."""

from collections.abc import Iterator, Sequence
from hashlib import sha256
from pathlib import Path

import numpy as np
from msgspec import Struct

from tissuec.compiler.anatomy import anatomy_of
from tissuec.compiler.compile import Compiled
from tissuec.compiler.manifest import digests
from tissuec.core.errors import CompileError, Diagnostic, render
from tissuec.core.source import Source
from tissuec.core.version import __version__
from tissuec.model.network import Network
from tissuec.pipeline import compile_request, read_words
from tissuec.results.blocks.anatomy import Anatomy
from tissuec.results.trajectory import Trajectory
from tissuec.scene.program.imports import StoredTexts
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.request import Request

#: What makes a net the same one, but for its ``ends``.
_ARRAYS = ("position", "mass", "stiffness", "damping", "rest", "strength", "crush")
_ROUNDING = 1e-9  # relative: another machine may have other sines


class Discrepancy(Struct, frozen=True):
    """A fact that has, or may have, changed since the scene ran.

    Attributes:
        text: A sentence without its stop.
        details: Messages that say why.
    """

    text: str
    details: tuple[str, ...] = ()


class RecompiledScene(Struct, frozen=True, eq=False):
    """Facts in the texts of a result, compiled again.

    Attributes:
        words: Params, vocabulary and tissues; None where they cannot be read.
        compiled: The scene; None where it cannot be compiled, or is another net than the one
            that ran.
        warnings: Of the texts.
    """

    request: Request
    words: ResolvedProgram | None
    compiled: Compiled | None
    warnings: tuple[Diagnostic, ...]
    doubts: tuple[Discrepancy, ...]


def recompile(trajectory: Trajectory, libraries: Sequence[Path] = ()) -> RecompiledScene:
    """Return the facts in the texts of a result, as far as they can be derived.

    Args:
        libraries: Folders in which files lie that are not kept, such as meshes; the folders of
            the scene and of the result are searched too.
    """
    request, doubts = request_of(trajectory, libraries), list(_origins(trajectory))
    words, compiled, warnings = None, None, ()
    try:
        words, warnings = read_words(request)
        compiled, warnings = compile_request(request)
    except CompileError as error:
        what = "its files cannot be read" if words is None else "the scene cannot be compiled"
        doubts.append(
            Discrepancy(f"{what} again from the contents of the result", _messages(error))
        )
    if compiled is not None:
        differences = tuple(_differences(trajectory, compiled))
        if differences:
            what = "the files give another net than the one in the run"
            doubts.append(Discrepancy(what, differences))
            compiled = None
    return RecompiledScene(request, words, compiled, warnings, tuple(doubts))


def request_of(trajectory: Trajectory, libraries: Sequence[Path] = ()) -> Request:
    """Return the request of a result, with its texts from the file."""
    manifest = trajectory.manifest
    name = str(manifest.get("scene", trajectory.path.name))
    return Request(
        Source(name, trajectory.text, Path(name)),
        tuple(manifest.get("overrides", ())),
        (*libraries, trajectory.path.parent),
        files=StoredTexts(manifest.get("sources", {})),
    )


def _origins(trajectory: Trajectory) -> Iterator[Discrepancy]:
    manifest = trajectory.manifest
    if manifest.get("digest") != sha256(trajectory.text.encode()).hexdigest():
        yield Discrepancy("the scene has another digest than the one in the run")
    version = manifest.get("versions", {}).get("tissuec")
    if version != __version__:
        yield Discrepancy(
            f"the scene was run with tissuec {version}, but this page is written by "
            f"{__version__}"
        )


def _messages(error: CompileError) -> tuple[str, ...]:
    return tuple(render(one) for one in error.diagnostics if one.severity == "error")


def _differences(trajectory: Trajectory, compiled: Compiled) -> Iterator[str]:
    """Yield why a net is not the one that ran."""
    then, now = trajectory.manifest.get("files", {}), digests(compiled)
    for name in sorted({*then, *now}):
        if then.get(name) != now.get(name):
            yield f'"{name}" has changed since the run'
    for name in _other_arrays(trajectory.network, compiled.network):
        yield f"{name} differs"


def _other_arrays(then: Network, now: Network) -> Iterator[str]:
    if not np.array_equal(then.line_ends, now.line_ends):
        yield "ends"
    for name in _ARRAYS:
        one, other = then.array(name), now.array(name)
        size = float(np.abs(one[np.isfinite(one)]).max(initial=0.0))
        same = one.shape == other.shape and np.allclose(
            one, other, rtol=_ROUNDING, atol=_ROUNDING * size, equal_nan=True
        )
        if not same:
            yield name


def anatomy_of_result(trajectory: Trajectory) -> tuple[Anatomy | None, str]:
    """Return the anatomy of a result, or None and the reason why it is unknown."""
    scene = recompile(trajectory)
    if scene.compiled is not None:
        return anatomy_of(scene.compiled), ""
    return None, "; ".join(doubt.text for doubt in scene.doubts)
