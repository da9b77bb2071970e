"""Ambient damping of each node, by its mass and by its share of the surface."""

from math import pi

import numpy as np

from tissuec.core.structs import replace
from tissuec.meshes.stiffness_sharing import grid_areas, node_areas
from tissuec.model.network import Floats, Indices, Network
from tissuec.scene.environment import Environment
from tissuec.scene.reading.findings import Findings


def with_drag(network: Network, environment: Environment, findings: Findings) -> Network:
    """Return a network with the damping of the environment by mass and by surface."""
    found = environment.entries.mass_damping * network.mass
    if environment.entries.surface_damping:
        area = skin_areas(network) + thread_areas(network)
        if not area.any():
            findings.add(
                "TIS306",
                "surface damping needs a surface, which no body has",
                environment.span,
                hint="write mass damping, or damping (of each node)",
            )
        found = found + environment.entries.surface_damping * area
    return replace(network, drag=found) if found.any() else network


def skin_areas(network: Network) -> Floats:
    """Return the drawn skin that each node represents, from one side [m²], shape (node,)."""
    area = np.zeros(network.node_count)
    for body in network.bodies:
        if body.grid is not None:
            rows, columns, closed = body.grid
            area[body.nodes] = grid_areas(
                network.position[body.nodes], rows, columns, closed=closed
            )
        elif len(skin := _exposed(network.skin_of(body), network)):
            area += node_areas(network.position, skin)
    return area


def _exposed(skin: Indices, network: Network) -> Indices:
    """Return triangles without those between a body and its mirror image, shape (n, 3)."""
    for plane in network.mirrored:
        skin = skin[~np.isin(skin, plane.nodes).all(axis=1)]
    return skin


def thread_areas(network: Network) -> Floats:
    """Return the drawn surface of threads, all around, by node [m²], shape (node,)."""
    area = np.zeros(network.node_count)
    for thread in network.threads.values():
        ends = network.springs.ends[thread.pieces]
        first, second = network.position[ends].swapaxes(0, 1)
        half = pi * thread.radius * np.linalg.norm(second - first, axis=1)
        np.add.at(area, ends, half[:, None])
    return area
