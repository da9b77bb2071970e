"""Permanent strain of elements that yield."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("plastic strain")
class PlasticStrain(ScalarMeasure):
    """The largest plastic strain at the nodes of A, each averaged over the elements around it.

    It is the equivalent logarithmic strain √(2/3) |log U| of the plastic deformation: for a
    bar, the logarithm of its unloaded length over its drawn length. It is 0 where nothing
    yields.
    """

    form = "plastic strain(A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "solid"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        own = plastic_strains(snapshot)[..., nodes]
        return one_column(own.max(axis=-1, initial=0.0), snapshot)


def plastic_strains(snapshot: Snapshot) -> Floats:
    """Return the mean plastic strain around each node, dimensionless, shape (…, node)."""
    velocity = snapshot.velocity.reshape(-1, *snapshot.velocity.shape[-2:])
    found = np.zeros(velocity.shape[:2])
    for row, speeds in zip(found, velocity, strict=True):
        volume = np.zeros_like(row)
        for field in snapshot.state.elements:
            for _, own in field.intact(snapshot.state.alive).in_blocks():
                strain, share = own.plastic_shares(speeds)
                np.add.at(row, own.nodes, strain)
                np.add.at(volume, own.nodes, share)
        row /= np.where(volume > 0.0, volume, 1.0)
    return found.reshape(snapshot.velocity.shape[:-1])
