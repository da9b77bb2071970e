"""Energies: of motion, stored, both together, and how well the balance of the run closes."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("kinetic energy")
class KineticEnergy(ScalarMeasure):
    """Σ ½ m v² over the nodes of A that are not held."""

    form = "kinetic energy(A)"
    dimension = units.ENERGY
    needs = ("motion",)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        return one_column(
            observables.kinetic_energy(snapshot.state, snapshot.velocity, nodes), snapshot
        )


@MEASURES.member("elastic energy")
class ElasticEnergy(ScalarMeasure):
    """The energy stored in the intact springs and elements of A, and in their branches.

    It is Σ ½ c (L - L0)² for linear springs. Bending of walls counts unless A is a set of
    springs. All nodes of a spring or an element belong to A.
    """

    form = "elastic energy(A)"
    dimension = units.ENERGY
    takes = "any"
    needs = ("energy",)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = snapshot.intact_springs(subjects[0])
        energy = observables.elastic_energy(
            snapshot.state, snapshot.position, snapshot.velocity, springs
        )
        if not subjects[0].is_springs:
            energy = energy + observables.energy_within(
                snapshot.state,
                snapshot.position,
                snapshot.velocity,
                snapshot.nodes(subjects[0]),
            )
        return one_column(energy, snapshot)


@MEASURES.member("energy")
class Energy(ScalarMeasure):
    """The sum of the kinetic and the elastic energy of A."""

    form = "energy(A)"
    dimension = units.ENERGY

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return KineticEnergy.sample(subjects, snapshot) + ElasticEnergy.sample(
            subjects, snapshot
        )


@MEASURES.member("energy drift")
class EnergyDrift(ScalarMeasure):
    """The error of the energy balance, relative to the largest energy so far.

    |E - (E0 + work - dissipated + switched)| / scale, where E is the sum of kinetic, elastic
    and gravitational energy. The scale is the largest energy so far, but at least the energy of
    the stiffest spring stretched by a millionth of the size of the drawing. The drift is 0 if
    there is neither energy nor a spring.
    """

    form = "energy drift"
    dimension = units.NUMBER
    subjects = 0
    takes = "any"
    needs_ledger = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        """Return the drift of a snapshot, dimensionless, shape (…, 1).

        Raises:
            ValueError: The run keeps no energy ledger.
        """
        if snapshot.ledger is None:
            raise ValueError("the energies were not integrated")
        balance = np.abs(snapshot.ledger.balance(snapshot.energies))
        scale = np.asarray(snapshot.ledger.scale, dtype=float)
        return one_column(
            np.where(scale > 0.0, balance / np.where(scale > 0.0, scale, 1.0), 0.0), snapshot
        )
