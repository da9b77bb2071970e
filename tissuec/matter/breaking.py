"""How far springs are stretched when they break."""

import numpy as np

from tissuec.laws.evaluation import Behaviour
from tissuec.network import Floats

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
            strain = _by_halving(behaviour, strength)
    return np.where((rest > 0.0) & (strain < _FURTHEST), strain, np.inf)


def _by_halving(behaviour: Behaviour, strength: Floats) -> Floats:
    """Return strains at which laws reach their limits: the least of many, then halved.

    A limit that is reached between two tries, and not at the larger one, is passed over.
    """
    tried = 2.0 ** np.arange(20, -21, -1)
    breaks = np.full_like(strength, _FURTHEST)
    for strain in tried:
        breaks = np.where(behaviour.pull(strain * behaviour.rest) >= strength, strain, breaks)
    holds = np.where(breaks > tried[-1], 0.5 * breaks, 0.0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (holds + breaks)
        reached = behaviour.pull(middle * behaviour.rest) >= strength
        holds, breaks = np.where(reached, holds, middle), np.where(reached, middle, breaks)
    return breaks
