"""Check of nets that have too few cells across to bend and twist as their tissue would."""

from collections.abc import Iterator

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.checks import thorough_check
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.arrays import norm
from tissuec.core.errors import Diagnostic
from tissuec.core.names import key_of
from tissuec.core.units import LENGTH, show
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS

#: Ratios of stiffness that are reported; lattices of four cells across stay below both.
BENDING, TORSION, SOFT = 1.15, 1.3, 0.7
FEW = 5.0  # cells across a body that may be too few: with more, no ratio is that large
SLENDER = 3.0  # times its thickness that a body without support is long before it bends much
ENOUGH = 4.0  # cells across that are advised
LARGEST = 20_000  # springs of a body that is examined: some tenths of a second


@thorough_check
def coarse(compiled: Compiled) -> Iterator[Diagnostic]:
    """W210: nets of springs in pascals that are much too stiff in bending or torsion."""
    state = None
    for part in compiled.network.bodies:
        placed = compiled.groups.bodies[key_of(part.name)]
        if not _is_asked_of(placed.drawing):
            continue
        state = state or state_at_start(compiled)
        if (across := _cells_across(part, placed.drawing, state)) is None:
            continue
        from tissuec.compiler.bodies.solid_nets import SolidNet  # where it is needed

        net = SolidNet.of(part, placed.drawing, state)
        elasticity = net.elasticity()
        if not all((*elasticity.young, *elasticity.shear)):
            continue
        found = net.coarseness(elasticity)
        if found.bending < BENDING and SOFT < found.torsion < TORSION:
            continue
        count, thickness = across
        yield Diagnostic(
            "W210",
            f"{part.name} is too coarse to bend and twist like its tissue: with about "
            f"{max(1, round(count))} cells across, it is {found.bending:.3g} times as stiff in "
            f"bending and {found.torsion:.3g} times in torsion",
            part.span,
            f"use cells of {show(thickness / ENOUGH, LENGTH, digits=2)} or less",
        )


def _is_asked_of(drawing: Drawing) -> bool:
    """Return whether a body is a net of springs for one tissue with a Young's modulus."""
    mesh, body = drawing.mesh, drawing.body
    if mesh.volume is None or len(mesh.ends) > LARGEST or drawing.thread is not None:
        return False
    if body.elements is not None:
        return False
    tissues = {tissue.name: tissue for tissue in body.tissues}
    is_of_matter = all(YOUNGS_MODULUS in tissue.given for tissue in tissues.values())
    return len(tissues) == 1 and is_of_matter and bool(np.all(mesh.volume > 0.0))


def _cells_across(part: BodyPart, drawing: Drawing, state: State) -> tuple[float, float] | None:
    """Return about how many cells are across a body, and its thickness [m].

    None where there are enough, or where it is held so that it cannot bend.
    """
    from tissuec.matter.coarseness import principal_axes  # where it is needed

    x, skin = drawing.mesh.position, drawing.mesh.skin
    x = x - x.mean(axis=0)
    along = x @ principal_axes(x.T @ x)
    extent = np.ptp(along, axis=0)
    thickness = float(extent.min())
    edges = norm((x[skin] - x[np.roll(skin, 1, axis=1)]).reshape(-1, 3))
    count = thickness / float(np.median(edges))
    if count > FEW:
        return None
    place = along[:, 0]
    stops = np.concatenate([place[state.held[part.nodes]], [place.min(), place.max()]])
    if np.diff(np.sort(stops)).max() < SLENDER * thickness:
        return None
    return count, thickness
