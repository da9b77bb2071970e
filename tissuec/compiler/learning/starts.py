"""Values at which a fit begins: those of the scene as it is written."""

from collections.abc import Sequence

import numpy as np

from tissuec.compiler.compile import Compiled
from tissuec.compiler.learning.laws import constant_of
from tissuec.core.names import key_of
from tissuec.model.network import Floats
from tissuec.scene.model import Scene, Tissue
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.script.fit_problem import (
    REST_LENGTH,
    START_POSITION,
    START_VELOCITY,
    WORDS,
    Adjust,
)

ARRAYS = {REST_LENGTH: "rest", START_POSITION: "position", START_VELOCITY: "velocity"}


def start_of(adjust: Adjust, compiled: Compiled) -> Floats:
    """Return the values that an entry adjusts, in SI units, shape (value,).

    One that a set shares is the geometric mean of its springs or nodes, or the place or
    velocity of its first node, each component of which is a value if there is no direction.
    Words have none.
    """
    if adjust.what == WORDS:
        return np.zeros(0)
    if adjust.per == "force":
        entries = compiled.scene.forces[key_of(adjust.of)].entries
        field = entries_of(type(entries))[adjust.what].field
        return np.array([float(getattr(entries, field))])
    if adjust.per in ("tissue", "region"):
        return start_of_tissues(adjust.what, tissues_of(adjust, compiled.scene), compiled.scene)
    values = compiled.network.array(array_of(adjust.what))[adjust.members].astype(float)
    is_whole = adjust.per == "set"
    if adjust.what in (START_POSITION, START_VELOCITY):
        values = values[:1] if is_whole else values
        return values.ravel() if adjust.along is None else values @ adjust.along
    return np.array([np.exp(np.log(values).mean())]) if is_whole else values


def array_of(what: str) -> str:
    """Return the name of the array of a network that an adjusted quantity belongs to."""
    return ARRAYS[what] if what in ARRAYS else QUANTITIES[what].array


def tissues_of(adjust: Adjust, scene: Scene) -> list[Tissue]:
    """Return the tissues whose number is adjusted: one, or that of each part of a body."""
    if adjust.per != "region":
        return [scene.tissues[key_of(adjust.of)]]
    body = scene.bodies[key_of(adjust.of)]
    parts = (body.tissue, *(region.tissue or body.tissue for region in body.regions))
    return [tissue for tissue in parts if tissue is not None]


def start_of_tissues(what: str, tissues: Sequence[Tissue], scene: Scene) -> Floats:
    """Return a number of tissues, or of their laws, in SI units, shape (tissue,)."""
    if is_given(what, tissues):
        return np.array([tissue.given[what].value for tissue in tissues])
    return np.array([constant_of(tissue, what, scene) for tissue in tissues])


def is_given(what: str, tissues: Sequence[Tissue]) -> bool:
    """Return whether what is adjusted is a quantity of tissues, not a constant of laws."""
    return what in QUANTITIES and all(what in tissue.given for tissue in tissues)
