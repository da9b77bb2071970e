"""Common code of measures of the stress of elements."""

import numpy as np

from tissuec.model.network import Floats
from tissuec.script.measures import Subject
from tissuec.script.measures.snapshot import Snapshot


def mean_stress(subject: Subject, snapshot: Snapshot) -> Floats:
    """Return the mean Cauchy stress around the nodes of a subject [Pa], shape (…, 3, 3).

    Nodes count by the volume of their shares of elements as drawn. The stress is zero where no
    element is left. What is viscous is left out.
    """
    times = np.shape(snapshot.time)
    nodes = snapshot.nodes(subject)
    position, velocity = (
        each.reshape(-1, *each.shape[-2:]) for each in (snapshot.position, snapshot.velocity)
    )
    total, volume = np.zeros((len(position), 3, 3)), 0.0
    for field in snapshot.state.elements:
        elements, used = field.intact(snapshot.state.alive).around(nodes)
        own = np.isin(used, nodes)
        drawn = 0.0  # the same at all times
        for row, places, speeds in zip(total, position[:, used], velocity, strict=True):
            stress, share = elements.recalling(speeds).node_stress(places)
            row += stress[own].sum(axis=0)
            drawn = float(share[own].sum())
        volume += drawn
    return (total / (volume or 1.0)).reshape(*times, 3, 3)
