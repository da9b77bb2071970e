"""``surface of … every … { … }``: how the surface of a body is drawn."""

import numpy as np

from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.geometry.surfaces import ELSEWHERE, MOST_POINTS, ON_GRIDS, SURFACES, Smoothing
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Mesh
from tissuec.scene.output import SURFACE
from tissuec.scene.reading import schema
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import entries_in

KIND = "kind"


def read_surface(
    item: s.Sentence | s.Block, name: s.Name, body: str, mesh: Mesh, scope: Scope
) -> tuple[str, Smoothing]:
    """Return how the surface of a body is smoothed: the kind, and its entries.

    Args:
        item: The whole output.
        name: Name of the body in the output.
        body: Name of the body as declared.
        mesh: Mesh of the body.
    """
    if not len(mesh.skin):
        scope.findings.reject(
            "TIS704",
            f"{body} has no surface",
            name.span,
            hint="tubes, sheets, spheres and lattices have a surface",
        )
    items = item.items if isinstance(item, s.Block) else ()
    kind = _written_kind(items) or (ELSEWHERE if mesh.grid is None else ON_GRIDS)
    entries = entries_in(SURFACE, kind)
    with scope.findings.together():
        values, places = schema.read(entries, items, scope, what=f"surface of {body}")
    if SURFACES[kind].needs_grid and mesh.grid is None:
        scope.findings.reject(
            "TIS704",
            f"an {kind} needs rows and columns of nodes, which {body} does not have",
            places[KIND],
            hint=Hint(
                f"remove this entry, or write {KIND} is {ELSEWHERE}",
                Edit(f"{KIND} is {ELSEWHERE}"),
            ),
        )
    values.pop(KIND, None)
    smoothing = SURFACES[kind](**values)
    _refuse_size(smoothing, mesh, places.get("subdivisions", name.span), scope)
    return kind, smoothing


def _written_kind(items: tuple[s.Item, ...]) -> str:
    """Return the first kind that there is among entries, empty without one."""
    for item in items:
        if isinstance(item, s.Sentence) and item.name.key == KIND and item.phrase is not None:
            word = item.phrase.words[0].key if item.phrase.kind == "word" else ""
            return word if word in SURFACES else ""
    return ""


def _refuse_size(smoothing: Smoothing, mesh: Mesh, span: Span, scope: Scope) -> None:
    """Reject a surface of more points than can be made."""
    most = len(mesh.skin) * 4**smoothing.subdivisions / 2.0
    if most <= MOST_POINTS:
        return
    fitting = int(np.floor(np.log(2.0 * MOST_POINTS / len(mesh.skin)) / np.log(4.0)))
    hint = f"at most {MOST_POINTS:,} are possible".replace(",", " ")
    if fitting > 0:
        entry = f"subdivisions = {fitting}"
        hint = Hint(f"write {entry}; {hint}", Edit(entry))
    scope.findings.reject(
        "TIS310", f"the surface would have about {most:.2g} points", span, hint=hint
    )
