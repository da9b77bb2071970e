"""Elongations at which springs break."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tissuec.laws.evaluation import Behaviour
from tissuec.model.network import Floats

_FURTHEST = 2.0**20  # times the rest length: what has not broken there never does
_HALVINGS = 48


def breaking_strains(behaviour: Behaviour, strength: Floats) -> Floats:
    """Return elongations at which springs break, per rest length; infinite where they do not.

    Those that are not stretched slowly break earlier, as dashpots and branches pull as well.

    Args:
        strength: The tension that breaks each spring [N], shape (spring,).

    Returns:
        Shape (spring,); infinite also for springs without a rest length.
    """
    rest = behaviour.rest
    with np.errstate(all="ignore"):
        if behaviour.is_linear:
            strain = strength / (behaviour.stiffness * rest)
        else:
            strain = _least_strain(behaviour, lambda e: behaviour.pull(e) >= strength)
    breaks = (rest > 0.0) & (strain < _FURTHEST) & np.isfinite(strength)
    return np.where(breaks, strain, np.inf)


def force_at_energy(behaviour: Behaviour, energy: Floats) -> Floats:
    """Return the forces of springs at which they have taken up an energy, stretched from rest.

    Args:
        energy: Of each spring [J], shape (spring,).

    Returns:
        Forces [N], shape (spring,); infinite where it is never reached.
    """
    if behaviour.is_linear:
        return np.sqrt(2.0 * behaviour.stiffness * energy)
    strain = _least_strain(behaviour, lambda e: behaviour.energy(e) >= energy)
    with np.errstate(all="ignore"):
        force = behaviour.pull(strain * behaviour.rest)
    return np.where(strain < _FURTHEST, force, np.inf)


def _least_strain(
    behaviour: Behaviour, is_reached: Callable[[Floats], NDArray[np.bool_]]
) -> Floats:
    """Return strains from which on a limit is reached: the least of many, then halved.

    A limit that is reached between two tries, and not at the larger one, is passed over.

    Args:
        is_reached: Of elongations [m], shape (spring,).
    """
    tried = 2.0 ** np.arange(20, -21, -1)
    breaks = np.full_like(behaviour.rest, _FURTHEST)
    for strain in tried:
        breaks = np.where(is_reached(strain * behaviour.rest), strain, breaks)
    holds = np.where(breaks > tried[-1], 0.5 * breaks, 0.0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (holds + breaks)
        reached = is_reached(middle * behaviour.rest)
        holds, breaks = np.where(reached, holds, middle), np.where(reached, middle, breaks)
    return breaks
