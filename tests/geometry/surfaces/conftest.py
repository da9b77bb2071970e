"""Skins of meshes, torn or whole, and what surfaces over them measure."""

import numpy as np

from tissuec.core.source import Source, Span
from tissuec.geometry.surfaces.skin import BodySkin
from tissuec.laws import LINEAR
from tissuec.meshes.generators import MESHES
from tissuec.model.network import BodyPart, Network
from tissuec.model.springs import Springs

SHEET = {
    "corner": np.zeros(3),
    "first_edge": np.array([0.06, 0.01, 0.0]),
    "second_edge": np.array([0.0, 0.05, 0.02]),
}
TUBE = {"axis": (np.zeros(3), np.array([0.06, 0.0, 0.0])), "radius": 0.004}
SPHERE = {"centre": np.array([0.1, 0.2, 0.3]), "radius": 0.02}
BOX = (np.zeros(3), np.array([0.02, 0.02, 0.03]))


def build(mesh, /, **entries):
    """Return a mesh of a kind; entries that are not given are those above."""
    usual = {"tube": TUBE, "sheet": SHEET, "sphere": SPHERE, "lattice": {"box": BOX}}[mesh]
    return MESHES[mesh](**usual | entries).build()


def network_of(mesh):
    """Return the network of one body."""
    span = Span(Source("scene.tis", "language 1"), 0, 10)
    nodes, springs = len(mesh.position), len(mesh.ends)
    numbers = ("stiffness", "damping", "rest", "strength", "crush")
    return Network(
        position=mesh.position,
        velocity=np.zeros((nodes, 3)),
        mass=np.ones(nodes),
        springs=Springs(
            ends=mesh.ends,
            **dict.fromkeys(numbers, np.ones(springs)),
            law=np.zeros(springs, dtype=np.int32),
            laws=(LINEAR,),
            ids=np.arange(springs),
        ),
        skin=mesh.skin,
        node_ids=np.arange(nodes),
        bodies=(BodyPart("b", slice(0, nodes), slice(0, springs), span, mesh.grid),),
        provenance={},
    )


def skin_of(mesh, alive=None):
    """Return the skin of a mesh while some springs are alive."""
    network = network_of(mesh)
    alive = np.ones(len(mesh.ends), dtype=bool) if alive is None else alive
    return BodySkin.of(network, network.bodies[0]).at(alive)


def across(mesh, low, high):
    """Return which springs join one set of nodes to another, given as masks."""
    a, b = mesh.ends.T
    return (low[a] & high[b]) | (low[b] & high[a])


def area(points, triangles):
    a, b, c = points[triangles].swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def volume(points, triangles):
    a, b, c = points[triangles].swapaxes(0, 1)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def order(errors, sizes):
    """Return the observed order: the slope of errors over sizes."""
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]
