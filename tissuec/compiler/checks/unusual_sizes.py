"""Checks of sizes and places: bodies, walls, tools and gravity that are far from the usual.

Each kind is reported once, however many there are.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic, Note
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import show
from tissuec.meshes.generators.imported import Imported
from tissuec.model.network import Floats
from tissuec.scene.model import Body
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS
from tissuec.scene.usual_ranges import USUAL, unusual

#: Tools that are this many times as far away as the bodies are large are far on any scale.
FAR = 10.0


@check
def unusual_sizes(compiled: Compiled) -> Iterator[Diagnostic]:
    """W504: sizes of bodies, thicknesses, distances of tools, and gravity."""
    network, scene = compiled.network, compiled.scene
    organs = [one for one in network.bodies if _is_an_organ(scene.bodies.get(key_of(one.name)))]
    sizes = [(body, _extent(network.position[body.nodes])) for body in organs]
    told = (
        (
            f"{body.name} is {'only' if size < USUAL['size'].low else 'as large as'}",
            size,
            body.span,
        )
        for body, size in sizes
    )
    yield from _once("size", told)
    walls = [
        (f"the thickness of {body.name} is", body.thickness, body.places["thickness"])
        for body in scene.bodies.values()
        if body.thickness is not None and "thickness" in body.places
    ]
    yield from _once("thickness", walls)
    yield from _once("distance", _distances(compiled))
    gravity = float(np.linalg.norm(scene.environment.entries.gravity))
    yield from _once("gravity", [("gravity is", gravity, scene.environment.span)])


def _is_an_organ(body: Body | None) -> bool:
    """Return whether a body is of matter, or from a file; a net of springs may be anything."""
    if body is None:
        return False
    of_matter = any(YOUNGS_MODULUS in tissue.given for tissue in body.tissues)
    return of_matter or isinstance(body.mesh, Imported)


def _distances(compiled: Compiled) -> Iterator[tuple[str, float, Span]]:
    """Yield how far tools are from the box around all bodies, if that is far on their scale."""
    network = compiled.network
    drawn = network.position[: network.body_nodes]
    if not len(drawn):
        return
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    for tool in network.tools:
        places = network.position[tool.nodes]
        if not len(places):
            continue
        beside = places - np.clip(places, low, high)
        distance = float(np.linalg.norm(beside, axis=1).min())
        if distance > FAR * _extent(drawn):
            yield f"the distance of {tool.name} from all bodies is", distance, tool.span


def _extent(places: Floats) -> float:
    """Return the largest extent of places along an axis; 0 for none."""
    return float(np.ptp(places, axis=0).max()) if len(places) else 0.0


def _once(key: str, found: Iterable[tuple[str, float, Span]]) -> Iterator[Diagnostic]:
    """Yield one warning about the first of some values that is unusual, with the others."""
    strange = [one for one in found if not USUAL[key].holds(one[1])]
    if not strange:
        return
    (what, value, span), *others = strange
    notes = (
        Note(f"{text} {show(number, USUAL[key].dimension)}", place)
        for text, number, place in others[:3]
    )
    warning = unusual(key, value, what, span, others=notes)
    assert warning is not None
    yield warning
