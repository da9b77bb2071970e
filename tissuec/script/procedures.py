"""Options of the procedures in the publication.

Table 1 and the text around it differ, and both leave things open (A. Nürnberger, A. Radetzky,
R. Kruse, SPIE Medical Imaging 1998, section 3.1.4). Each choice is an entry of the language.
"""

from typing import Annotated

import numpy as np
from msgspec import Struct
from msgspec.structs import fields

from tissuec.core import units
from tissuec.core.fields import OneOf, Real
from tissuec.model.network import Floats


class PropagationChoices(Struct, frozen=True):
    """How ``propagation`` steps frames.

    Attributes:
        compared_forces: Forces whose greatest sum on a node must not rise: all of them
            (Table 1), or only the internal ones, without weight, loads and ambient damping
            (text).
        former_force: Whether the first step of a frame is compared with the end of the previous
            frame (kept) or with nothing (forgotten); the paper does not say.
        repeated: What is repeated with half the time step when forces rise: the step (Table 1),
            or the frame from its start (text). In a repeated frame, the time step does not
            grow.
        first_step: Time step at the start of a frame: the whole frame (Table 1), or the last
            one of the previous frame (text).
        growth: Factor on the time step after a step in which forces do not rise: 2 (Table 1),
            or less (text).
        frame_end: Whether the last step of a frame is shortened to end with it (exact, text),
            or may pass its end (open, Table 1); prescribed motions wait there.
        smallest_step: Part of the frame below which nothing is repeated. The paper has no such
            limit; without it, time could stand still.
    """

    compared_forces: Annotated[str, OneOf(("all", "internal"))] = "all"
    former_force: Annotated[str, OneOf(("kept", "forgotten"))] = "kept"
    repeated: Annotated[str, OneOf(("step", "frame"))] = "step"
    first_step: Annotated[str, OneOf(("whole frame", "last step"))] = "whole frame"
    growth: Annotated[float, Real(units.NUMBER, at_least=1.0, at_most=2.0)] = 2.0
    frame_end: Annotated[str, OneOf(("exact", "open"))] = "exact"
    smallest_step: Annotated[float, Real(units.NUMBER, at_least=1e-6, at_most=1.0)] = 1 / 64

    def row(self) -> Floats:
        """Return the choices in the order of ``Work.choices``, dimensionless, shape (7,)."""
        return np.array(
            [
                self.smallest_step,
                self.growth,
                self.compared_forces == "internal",
                self.former_force == "forgotten",
                self.repeated == "frame",
                self.first_step == "last step",
                self.frame_end == "open",
            ]
        )


class RelaxationChoices(Struct, frozen=True):
    """How ``relaxation`` goes from one equilibrium to the next.

    Attributes:
        threshold: Change of the force on a node within a sweep above which another sweep
            follows; by default 1e-9 of the largest force.
        activities: What follows at a minimum of the energy: nothing, so that free nodes have no
            velocity (none); or the second step of the paper's procedure, so that nodes keep the
            velocity with which they arrived, and their next path starts where it leads
            (velocities).
    """

    threshold: Annotated[float | None, Real(units.FORCE, above=0.0)] = None
    activities: Annotated[str, OneOf(("none", "velocities"))] = "none"


Choices = PropagationChoices | RelaxationChoices
#: By the name of the method; of others, nothing can be chosen.
PROCEDURES: dict[str, type[PropagationChoices] | type[RelaxationChoices]] = {
    "propagation": PropagationChoices,
    "relaxation": RelaxationChoices,
}


def stated(choices: Choices | None, *, defaults: bool = True) -> list[str]:
    """Return the choices of a procedure as the language writes them.

    Args:
        choices: None of methods that leave no choice.
        defaults: Whether what is chosen by default is among them.
    """
    if choices is None:
        return []
    found: list[str] = []
    for entry in fields(choices):
        name, value = entry.name.replace("_", " "), getattr(choices, entry.name)
        if value is None or (value == entry.default and not defaults):
            continue
        (kind,) = entry.type.__metadata__
        written = isinstance(value, str)
        found.append(
            f"{name} is {value}"
            if written
            else f"{name} = {units.show(value, kind.dimension, digits=9)}"
        )
    return found
