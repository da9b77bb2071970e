"""Checks of sizes and places: bodies, walls, tools and gravity that are far from the usual.

Each kind is reported once, however many there are.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.arrays import largest_side, norm
from tissuec.core.errors import Diagnostic, Note
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, VELOCITY, show
from tissuec.meshes.generators.imported import Imported
from tissuec.scene.model import Body
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS
from tissuec.scene.usual_ranges import USUAL, unusual
from tissuec.script.verbs.hold import Grasp
from tissuec.script.verbs.move import Move, Turn

#: Tools that are this many times as far away as the bodies are large are far on any scale.
FAR = 10.0
FAST = 10.0  # [m/s]: no hand moves as fast


@check
def unusual_sizes(compiled: Compiled) -> Iterator[Diagnostic]:
    """W504: sizes of bodies, thicknesses, distances of tools, motions, and gravity."""
    network, scene = compiled.network, compiled.scene
    organs = [one for one in network.bodies if _is_an_organ(scene.bodies.get(key_of(one.name)))]
    sizes = [(body, largest_side(network.position[body.nodes])) for body in organs]
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
    if organs or USUAL["size"].holds(network.extent):
        yield from _motions(compiled)
    yield from _grasps_from_afar(compiled)
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
        if distance > FAR * largest_side(drawn):
            yield f"the distance of {tool.name} from all bodies is", distance, tool.span


def _motions(compiled: Compiled) -> Iterator[Diagnostic]:
    """Yield W504 for motions that are far longer than everything is large, or very fast."""
    extent, is_static = compiled.network.extent, compiled.plan.simulation.is_static
    actions = {id(event.action): event.action for event in compiled.plan.every_event}
    for action in actions.values():
        if not isinstance(action, Move):
            continue
        ends = np.array([profile.extremes for profile in action.profiles])
        way, speed = map(float, norm(ends.T @ np.array(action.vectors)))
        if way > FAR * extent > 0.0:
            said = (
                f"is moved by {show(way, LENGTH)}, {way / extent:.0f} times the size of "
                "everything in the scene"
            )
        elif speed > FAST and not is_static:  # whose time is only the order of events
            said = f"is moved at up to {show(speed, VELOCITY)}, as fast as in an accident"
        else:
            continue
        hint = (
            "check the units of its way and of its time; if they are right, leave it as it is"
        )
        yield Diagnostic("W504", f"{action.mover.name} {said}", action.span, hint)


def _grasps_from_afar(compiled: Compiled) -> Iterator[Diagnostic]:
    """Yield W504 for grasps by tools that are drawn far from what they grasp."""
    network, moved = compiled.network, set[str]()
    drawn = {tool.name: network.position[tool.nodes] for tool in network.tools if tool.shapes}
    bodies = largest_side(network.position[: network.body_nodes])
    for event in compiled.plan.events:
        action = event.action
        if isinstance(action, (Move, Turn)):
            moved.add(action.mover.name)
        if not isinstance(action, Grasp) or action.tool in moved or action.tool not in drawn:
            continue
        tool, group = drawn[action.tool], network.position[action.group.indices]
        beside = tool - np.clip(tool, group.min(axis=0), group.max(axis=0))
        distance = float(norm(beside).min())
        if distance > bodies:
            yield Diagnostic(
                "W504",
                f"{action.tool} grasps {action.group.name} from a distance of "
                f"{show(distance, LENGTH)}",
                action.span,
                "draw it there, or move it there first; it holds from afar as well",
            )


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
