"""Checks of a compiled scene: one small generator per rule, each yields diagnostics.

All of them are warnings about scenes that can be run but may not mean what their author thinks.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from tissuec import topology
from tissuec.compiler import Compiled
from tissuec.core.errors import Diagnostic, Note
from tissuec.core.units import LENGTH, show
from tissuec.lang import syntax as s
from tissuec.network import BodyPart, Floats
from tissuec.scene.model import Tissue
from tissuec.situation import Situation
from tissuec.verbs import Action

Check = Callable[[Compiled], Iterator[Diagnostic]]
MOST_SPRINGS_NAMED = 3


def check_all(compiled: Compiled) -> list[Diagnostic]:
    """Return the warnings of every check."""
    return [finding for check in CHECKS for finding in check(compiled)]


def pieces(compiled: Compiled) -> Iterator[Diagnostic]:
    """W301: a body that falls apart before anything is cut."""
    for body, _, ends in _bodies(compiled):
        count = int(topology.pieces(_size(body), ends).max(initial=-1)) + 1
        if count > 1 and len(ends):
            yield Diagnostic(
                "W301",
                f"{body.name} starts in {count} pieces",
                body.span,
                "join them with springs, or make them two bodies",
            )


def dangling(compiled: Compiled) -> Iterator[Diagnostic]:
    """W302: nodes that no spring, or a single one, holds."""
    for body, _, ends in _bodies(compiled):
        if not len(ends):
            continue
        degree = np.bincount(ends.ravel(), minlength=_size(body))
        loose = int((degree == 0).sum())
        if loose:
            yield Diagnostic(
                "W302",
                f"{body.name} has {loose} nodes without springs",
                body.span,
                "they move freely; leave them out, or add springs",
            )


def floppy(compiled: Compiled) -> Iterator[Diagnostic]:
    """W303: ways to move that no spring resists."""
    network = compiled.network
    held = situation_at_start(compiled).held
    for body, part, ends in _bodies(compiled):
        if not len(ends):
            continue
        modes = topology.floppy_modes(
            network.position[body.nodes],
            ends,
            network.stiffness[part],
            network.rest[part],
            held[body.nodes],
        )
        if modes.checked and modes.count:
            plural = "s" if modes.count > 1 else ""
            yield Diagnostic(
                "W303",
                f"{body.name} has {modes.count} floppy mode{plural}: it can fold without any spring being stretched",
                body.span,
                "add diagonals or interior springs, a longer reach of the lattice, or prestress",
            )


def zero_lengths(compiled: Compiled) -> Iterator[Diagnostic]:
    """W304: springs between nodes at one place, which have no direction."""
    network = compiled.network
    length = np.linalg.norm(
        network.position[network.ends[:, 1]] - network.position[network.ends[:, 0]], axis=1
    )
    for body in network.bodies:
        zero = np.flatnonzero(length[body.springs] == 0.0)
        if len(zero):
            ids = ", ".join(
                str(i) for i in network.spring_ids[body.springs][zero[:MOST_SPRINGS_NAMED]]
            )
            yield Diagnostic(
                "W304", f"{len(zero)} springs of {body.name} have no length and so no direction (ids {ids}…)", body.span,
                "they exert no force until their ends part",
            )  # fmt: skip


def fallbacks(compiled: Compiled) -> Iterator[Diagnostic]:
    """W203: quantities that no rule spoke for."""
    for tissue in tissues_in_use(compiled):
        for name, given in tissue.given.items():
            if given.how == "otherwise":
                yield Diagnostic(
                    "W203", f"no rule gives the {name} of {tissue.name}; otherwise holds", tissue.span,
                    f"write {name} = … in the tissue if you know it", (Note("the otherwise", given.span),),
                )  # fmt: skip


def unused_parameters(compiled: Compiled) -> Iterator[Diagnostic]:
    """W501: a parameter that nothing uses, so that ``--set`` would do nothing."""
    constants = compiled.scene.constants
    for key, declared in compiled.scene.declarations.of("param").items():
        if key not in constants.used:
            yield Diagnostic(
                "W501",
                f'the param "{declared.name.text}" is never used',
                declared.name.span,
                "use it, or leave it out: setting it would change nothing",
            )


def unused_sets(compiled: Compiled) -> Iterator[Diagnostic]:
    """W502: a set that no sentence names."""
    for key, declared in compiled.scene.declarations.of("set").items():
        if key not in compiled.groups.used and isinstance(declared.item, s.Assign):
            yield Diagnostic(
                "W502",
                f'the set "{declared.name.text}" is never used',
                declared.name.span,
                "use it, or leave it out",
            )


def small_prestress(compiled: Compiled) -> Iterator[Diagnostic]:
    """W305: rest lengths of zero or less, which make a spring pull for ever."""
    network = compiled.network
    for body in network.bodies:
        bad = np.flatnonzero(network.rest[body.springs] <= 0.0)
        if len(bad):
            shortest = show(float(network.rest[body.springs][bad].min()), LENGTH)
            yield Diagnostic(
                "W305",
                f"{len(bad)} springs of {body.name} have no rest length (down to {shortest})",
                body.span,
            )


CHECKS: tuple[Check, ...] = (
    pieces, dangling, floppy, zero_lengths, small_prestress, fallbacks, unused_parameters, unused_sets,
)  # fmt: skip


def tissues_in_use(compiled: Compiled) -> tuple[Tissue, ...]:
    """Return the tissues that some body is made of, each once."""
    tissues: dict[str, Tissue] = {}
    for body in compiled.scene.bodies.values():
        for tissue in (body.tissue, *(region.tissue for region in body.regions)):
            if tissue is not None:
                tissues[tissue.name] = tissue
    return tuple(tissues.values())


def situation_at_start(compiled: Compiled) -> Situation:
    """Return the situation after the events of the script at 0 s."""
    plan = compiled.plan
    situation = Situation.start(compiled.network, gravity=plan.gravity, drag=plan.drag)
    for event in plan.events:
        if event.time == 0.0:
            event.action.apply(situation, _Forgetful())
    return situation


class _Forgetful:
    """An agenda for looking at 0 s only."""

    def add(self, time: float, action: Action) -> None:
        pass

    def land(self, times: Floats) -> None:
        pass


def _bodies(compiled: Compiled) -> Iterator[tuple[BodyPart, slice, NDArray[np.int32]]]:
    for body in compiled.network.bodies:
        yield (
            body,
            body.springs,
            compiled.network.ends[body.springs] - np.int32(body.nodes.start),
        )


def _size(body: BodyPart) -> int:
    return body.nodes.stop - body.nodes.start
