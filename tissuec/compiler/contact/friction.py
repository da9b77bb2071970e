"""Coefficients of friction in contact: that of the environment, or else those of tissues."""

from typing import TypedDict

import numpy as np

from tissuec.compiler.contact.points import FacePoints
from tissuec.model.network import Floats, Indices, Network
from tissuec.scene.environment import EnvironmentEntries

#: Of tools, which take the coefficient of the tissue that they touch: the smaller one counts.
OF_TISSUE = 1e30


class ContactFriction(TypedDict):
    """The entries of ``Contact`` of these names."""

    friction: float | None
    node_friction: Floats
    face_friction: Floats


def has_friction(network: Network, law: EnvironmentEntries) -> bool:
    """Return whether the environment, or else a tissue, gives friction."""
    return network.friction is not None if law.friction is None else law.friction > 0.0


def friction_of(
    network: Network, law: EnvironmentEntries, shapes: Indices, points: FacePoints | None
) -> ContactFriction:
    """Return the coefficients of contact.

    Args:
        network: With the coefficients of its tissues.
        law: As written.
        shapes: Nodes that carry each shape, shape (shape, 3).
        points: That follow the nodes of bodies; None without any.
    """
    given = network.friction
    if law.friction is not None or given is None:
        none = np.zeros((0, 3))
        return {
            "friction": law.friction or 0.0, "node_friction": none[:, 0], "face_friction": none
        }  # fmt: skip
    nodes = np.full(network.node_count, OF_TISSUE)
    nodes[: network.body_nodes] = given.nodes
    own = given.nodes
    if points is not None:
        corners, on_face = points.between.corners, points.skin >= 0
        between = (points.between.shares * nodes[corners]).sum(axis=1)
        between[on_face] = given.skin[points.skin[on_face]]
        own = np.append(own, between)
    return {"friction": None, "node_friction": own, "face_friction": nodes[shapes]}
