"""The nodes of a fit, and the bodies that they belong to."""

from collections.abc import Sequence

import numpy as np

from tissuec.model.network import BodyPart, Indices, Network
from tissuec.script.measures import Subject


def nodes_of(subjects: Sequence[Subject]) -> Indices:
    """Return the nodes of all subjects, ascending, shape (node,); tools have none."""
    parts = [one.nodes for one in subjects if one.nodes is not None]
    return np.unique(np.concatenate(parts)) if parts else np.zeros(0, dtype=np.int64)


def owners(network: Network, nodes: Indices) -> list[BodyPart]:
    """Return the bodies that contain some of the nodes, given by indices of shape (n,)."""
    return [
        body
        for body in network.bodies
        if ((nodes >= body.nodes.start) & (nodes < body.nodes.stop)).any()
    ]
