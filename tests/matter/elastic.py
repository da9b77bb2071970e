"""Linear statics of nets, with code of its own: springs, and cells that keep their volume."""

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, diags, eye
from scipy.sparse.linalg import spsolve

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source
from tissuec.model.network import Network
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.plan import Plan
from tissuec.script.verbs.preserve import Preserve


def scene(tissue: str, body: str) -> tuple[Network, Plan]:
    """Return a scene of one body; its tissue is called gel."""
    compiled, _ = compile_request(Request(Source("piece.tis", _text(tissue, body))))
    return compiled.network, compiled.plan


def _text(tissue: str, body: str) -> str:
    return f"""language 1
tissue gel {{ {tissue} }}
body piece {{ {body}; tissue is gel }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms; tolerance = 1e-6; integrator is dop853 }}
"""


def findings(tissue: str, body: str) -> list[Diagnostic]:
    """Return what the compiler finds in a scene of one body."""
    try:
        return list(compile_request(Request(Source("piece.tis", _text(tissue, body))))[1])
    except CompileError as error:
        return list(error.diagnostics)


def stiffness(network: Network, plan: Plan | None = None) -> csc_matrix:
    """Return the matrix of a net at rest [N/m], shape (3 node, 3 node), as a plan begins."""
    x, ends = network.position, network.springs.ends
    along = x[ends[:, 1]] - x[ends[:, 0]]
    n = along / np.linalg.norm(along, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(ends)), 6)
    columns = (3 * ends[:, :, None] + np.arange(3)).reshape(-1)
    values = np.concatenate([-n, n], axis=1).ravel()
    strain = coo_matrix((values, (rows, columns)), shape=(len(ends), x.size))
    matrix = strain.T @ diags(network.springs.stiffness) @ strain
    for event in () if plan is None else plan.events:
        if not isinstance(event.action, Preserve):
            continue
        slopes, drawn = volumes(network)
        matrix = matrix + slopes.T @ diags(event.action.modulus / drawn) @ slopes
    return csc_matrix(matrix)


def volumes(network: Network) -> tuple[csc_matrix, np.ndarray]:
    """Return how cells grow with places of nodes, and how large they are.

    The volume within faces is a third of the sum of r · A over their triangles, each face being
    cut both ways in halves.
    """
    faces, _ = network.bodies[0].cells()
    x = network.position
    count = len(faces)
    slopes, drawn = np.zeros((count, x.size)), np.zeros(count)
    for a, b, c, weight in ((0, 1, 2, 1), (0, 2, 3, 1), (0, 1, 3, 1), (1, 2, 3, 1)):
        for face in np.moveaxis(faces, 1, 0):
            i, j, k = face[:, a], face[:, b], face[:, c]
            drawn += np.einsum("ci,ci->c", x[i], np.cross(x[j], x[k])) * weight / 12.0
            for one, two, three in ((i, j, k), (j, k, i), (k, i, j)):
                area = np.cross(x[two], x[three]) * weight / 12.0
                for axis in range(3):
                    slopes[np.arange(count), 3 * one + axis] += area[:, axis]
    return csc_matrix(slopes), drawn


def moved(matrix: csc_matrix, held: dict[int, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return displacements where some are given, by number, and the forces that hold them."""
    size = matrix.shape[0]
    # Some motions cost nothing, such as a turn; they stay at zero.
    matrix = csc_matrix(matrix + 1e-10 * matrix.diagonal().max() * eye(size))
    numbers = np.array(sorted(held))
    u = np.zeros(size)
    u[numbers] = [held[number] for number in numbers]
    free = np.setdiff1d(np.arange(size), numbers)
    u[free] = spsolve(matrix[free][:, free], -(matrix @ u)[free])
    return u.reshape(-1, 3), (matrix @ u).reshape(-1, 3)


def drawn_out(
    network: Network, plan: Plan, axis: int, *, held_across: bool = False
) -> tuple[float, np.ndarray]:
    """Draw a body by a strain of 1 between end faces; return the force and displacements.

    Args:
        held_across: Whether the end faces keep their shape.
    """
    x = network.position[:, axis]
    low, high = (np.flatnonzero(np.isclose(x, end)) for end in (x.min(), x.max()))
    held = {}
    for nodes, by in ((low, 0.0), (high, float(np.ptp(x)))):
        for node in nodes.tolist():
            held |= {3 * node + other: 0.0 for other in range(3) if held_across}
            held[3 * node + axis] = by
    u, force = moved(stiffness(network, plan), held)
    return float(force[high, axis].sum()), u
