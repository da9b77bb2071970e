"""A check of the contact thickness: how short steps it makes."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.checks.supports import driven_by
from tissuec.compiler.checks.threads import entry_of
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.units import LENGTH, show
from tissuec.script.verbs import Shifting, follows

MANY = 5000  # steps, from which on they are announced


@check
def thin_skins(compiled: Compiled) -> Iterator[Diagnostic]:
    """W414: a contact thickness so small that motions take many steps."""
    network, law = compiled.network, compiled.scene.environment.contact
    contact = network.contact
    if contact is None or law is None or not law.contact_thickness:
        return
    thinnest = contact.radius[contact.radius > 0.0].min(initial=np.inf)
    if compiled.plan.simulation.is_static or thinnest != law.contact_thickness:
        return
    way = _longest_way(compiled)
    steps = way / contact.stride
    if steps <= MANY:
        return
    about = int(float(f"{steps:.2g}"))
    place = entry_of(compiled.scene.declarations.single["environment"], "contact thickness")
    from tissuec.compiler.contact.build import default_thickness
    from tissuec.compiler.contact.points import face_points

    points = face_points(network, list(compiled.scene.tools.values()), law)
    fit = show(default_thickness(network, points), LENGTH, digits=2)
    yield Diagnostic(
        "W414",
        f"the run takes at least {about:,} steps: something moves by {show(way, LENGTH)}, and "
        f"by no more than half of the contact thickness in a step",
        compiled.scene.environment.span if place is None else place,
        f"write a larger contact thickness; by default it would be {fit}",
    )


def _longest_way(compiled: Compiled) -> float:
    """Return how far the script moves a set or what a tool carries at most [m]."""
    ways = defaultdict[str, float](float)
    for event in compiled.plan.every_event:
        action = event.action
        way = action.shift if follows(action, Shifting) else 0.0
        if np.isfinite(way):
            ways[driven_by(event.action)] += way
    return max(ways.values(), default=0.0)
