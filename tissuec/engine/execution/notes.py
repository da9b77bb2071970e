"""Notes on a run beside its outcome: errors that its method made."""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.units import ENERGY, show
from tissuec.mechanics import observables
from tissuec.mechanics.state import State
from tissuec.script.measures.snapshot import EnergyBalance

if TYPE_CHECKING:
    from tissuec.engine.method import Statistics

GROWN = 0.01  # of the energy at the end: imbalances that are told


def notes(
    statistics: "Statistics", state: State, ledger: EnergyBalance | None
) -> tuple[str, ...]:
    """Return sentences about a run with a fixed step.

    Args:
        statistics: Counts of the run.
        state: The last good state.
        ledger: Energies until then; None where they are not kept.
    """
    found = [_stalls(statistics)] if statistics.stalls else []
    if ledger is not None:
        found += _growth(state, ledger)
    return tuple(found)


def _stalls(statistics: "Statistics") -> str:
    return (
        f"{statistics.method} stalled in {counted(statistics.stalls, 'step')}: the forces rose "
        f"even at the smallest step size; "
        f"{counted(statistics.evaluations, 'force evaluation')} for "
        f"{counted(statistics.accepted, 'frame')}"
    )


def _growth(state: State, ledger: EnergyBalance) -> list[str]:
    """Return what energy came from nowhere or went there, if that is much."""
    energies = observables.energies(state, state.time, state.position, state.velocity)
    surplus, size = float(ledger.balance(energies)), float(ledger.size(energies))
    if not np.isfinite(surplus) or abs(surplus) <= GROWN * size:
        return []
    verb, part = ("added", "to") if surplus > 0.0 else ("took", "from")
    return [
        f"the steps {verb} {show(abs(surplus), ENERGY)} {part} the energy of the net, which is "
        f"{show(float(energies.kinetic + energies.elastic), ENERGY)} at the end; smaller steps "
        "reduce this"
    ]
