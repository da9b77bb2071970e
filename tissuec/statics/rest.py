"""Whether a net rests with springs under pressure, so that its equilibrium may be unstable.

Asked in every run, hence without SciPy; ``stability`` answers the rest.
"""

import numpy as np

from tissuec import mechanics
from tissuec.situation import Situation

AT_REST = 1e-3  # of the largest tension: a force that is none; of the energy: none in motion


def rests_pressed(situation: Situation) -> bool:
    """Return whether springs are pressed, forces balance, and hardly anything moves.

    False wherever there is contact, whose stiffness says little of what buckles.

    Args:
        situation: With held nodes where they belong; not changed.
    """
    if situation.touching is not None:
        return False
    free, memory = ~situation.held, situation.network.memory
    still = np.zeros_like(situation.velocity)
    still[memory] = situation.velocity[memory]  # what springs and friction remember
    tension = mechanics.tension(situation, situation.position, still)
    largest = float(np.abs(tension).max(initial=0.0))
    if tension.min(initial=0.0) >= -AT_REST * largest:
        return False
    force = mechanics.inner_forces(situation, situation.time, situation.position, still)
    force += mechanics.applied_forces(situation)
    energy = mechanics.energies(
        situation, situation.time, situation.position, situation.velocity
    )
    left = float(np.linalg.norm(force[free], axis=1).max(initial=0.0))
    return left <= AT_REST * largest and bool(energy.kinetic <= AT_REST * energy.elastic)
