"""The matrix of an implicit step by conjugate gradients, for nets whose band is wide.

The same S as in ``banded``, never formed: per spring what acts along and across it. Inverses of
the diagonal blocks of the nodes are the preconditioner.

Shared arguments:
    start, stop: Range of lower nodes, ``stop`` excluded.
    first, last: Range of nodes, ``last`` excluded.
    image: S times the direction of search, a scratch vector [N], shape (3 node,).
    step: Length of the step along the direction of search, dimensionless.
"""

from math import sqrt

from tissuec.forces.springs.springs_kernel import resistance
from tissuec.kernels.chunks import clear_sums, total_sums
from tissuec.kernels.records import Floats, Net, Solver
from tissuec.kernels.thread_loops import PIECE, items_of, part_of, pieces_of, share
from tissuec.kernels.vectors import TINY

PRECISION = 1e-3  # of the residual; Newton's method repeats what is left
ROUNDS = 500


def assemble(q: float, x: Floats, v: Floats, net: Net, solver: Solver) -> bool:
    """Set the resistance of springs and the inverses of the diagonal blocks of S."""
    share(net.team, measure, (q, x, v, net, solver))
    bar, block = solver.bar, solver.block
    for node in range(block.shape[0]):
        inverse = net.inverse_mass[node]
        mass = (1.0 / inverse if inverse > 0.0 else 1.0) + q * net.drag[node]
        for k in range(6):
            block[node, k] = mass if k < 3 else 0.0
    for node in range(net.first.size - 1):
        for s in range(net.first[node], net.first[node + 1]):
            along, across = bar[s, 0], bar[s, 1]
            n0, n1, n2 = bar[s, 2], bar[s, 3], bar[s, 4]
            for end in (node, net.other[s] // 3):
                block[end, 0] += along * n0 * n0 + across
                block[end, 1] += along * n1 * n1 + across
                block[end, 2] += along * n2 * n2 + across
                block[end, 3] += along * n0 * n1
                block[end, 4] += along * n1 * n2
                block[end, 5] += along * n0 * n2
    definite = True
    for node in range(block.shape[0]):
        definite &= invert(node, block)
    return definite


def measure(
    part: int, parts: int, q: float, x: Floats, v: Floats, net: Net, solver: Solver
) -> None:
    """Set the directions of springs at a part of the nodes, and their resistance."""
    bar, (first, last) = solver.bar, part_of(part, parts, net.inverse_mass.size)
    for node in range(first, last):
        for s in range(net.first[node], net.first[node + 1]):
            i, j = 3 * node, int(net.other[s])
            r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
            length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
            inverse = 1.0 / (length + TINY)
            along = q * net.damping[s] + q * q * net.stiffness[s]
            across = q * q * net.stiffness[s] * max(1.0 - net.rest[s] * inverse, 0.0)
            if net.law[s] > 0:
                along, across = resistance(q, s, i, j, length, x, v, net)
            bar[s, 0], bar[s, 1] = along - across, across
            bar[s, 2], bar[s, 3], bar[s, 4] = r0 * inverse, r1 * inverse, r2 * inverse


def invert(node: int, block: Floats) -> bool:
    """Replace a symmetric block by its inverse; return False if it has none.

    Args:
        node: Row of the block.
        block: Components xx, yy, zz, xy, yz, xz [kg] or [1/kg], shape (node, 6).
    """
    a, b, c = block[node, 0], block[node, 1], block[node, 2]
    d, e, f = block[node, 3], block[node, 4], block[node, 5]
    first, second, third = b * c - e * e, e * f - c * d, d * e - b * f
    determinant = a * first + d * second + f * third
    if not determinant > 0.0:
        return False
    block[node, 0], block[node, 3], block[node, 5] = (
        first / determinant,
        second / determinant,
        third / determinant,
    )
    block[node, 1], block[node, 2] = (
        (a * c - f * f) / determinant,
        (a * b - d * d) / determinant,
    )
    block[node, 4] = (d * f - a * e) / determinant
    return True


def solve(vector: Floats, net: Net, solver: Solver) -> bool:
    """Replace residuals of accelerations r by S⁻¹ M r; return whether that converged."""
    share(net.team, begin, (vector, net, solver))
    product = total(net.team.work, net)
    enough = PRECISION * PRECISION * product
    ratio = 0.0
    for _ in range(ROUNDS):
        if not product > enough:
            return product == product
        share(net.team, turn, (ratio, net, solver))
        multiply(net, solver)
        share(net.team, project, (net, solver))
        step = product / total(net.team.lost, net)
        share(net.team, advance, (step, vector, net, solver))
        before = product
        product = total(net.team.work, net)
        ratio = product / before
    return False


def total(pieces: Floats, net: Net) -> float:
    """Return the sum over all pieces of the nodes.

    Args:
        pieces: Value of each piece in any unit, shape (piece,).
    """
    found = 0.0
    for piece in range(pieces_of(net.inverse_mass.size)):
        found += pieces[piece]
    return found


def begin(part: int, parts: int, vector: Floats, net: Net, solver: Solver) -> None:
    """Set residuals of a part of the nodes, clear the solution, and precondition."""
    residual, search = solver.scratch[0], solver.scratch[1]
    first, last = part_of(part, parts, net.inverse_mass.size)
    for node in range(first, last):
        inverse = net.inverse_mass[node]
        for i in range(3 * node, 3 * node + 3):
            residual[i] = vector[i] / inverse if inverse > 0.0 else 0.0
            vector[i] = search[i] = 0.0
    precondition(first, last, net, solver)


def turn(part: int, parts: int, ratio: float, net: Net, solver: Solver) -> None:
    """Set the direction of search in a part of the nodes.

    Args:
        ratio: Part of the last direction that is kept.
    """
    search, refined = solver.scratch[1], solver.scratch[3]
    first, last = part_of(part, parts, net.inverse_mass.size)
    for i in range(3 * first, 3 * last):
        search[i] = refined[i] + ratio * search[i]


def multiply(net: Net, solver: Solver) -> None:
    """Set the image to what springs make of the direction of search."""
    share(net.team, multiply_chunks, (net, solver))
    share(net.team, total_sums, (solver.scratch[2], net.chunks))


def multiply_chunks(part: int, parts: int, net: Net, solver: Solver) -> None:
    """Sum the products of springs of some chunks with the direction of search."""
    chunks = net.chunks
    begin, end = items_of(part, parts, chunks.node.size - 1)
    for chunk in range(begin, end):
        clear_sums(chunk, chunks)
        multiply_nodes(chunks.node[chunk], chunks.node[chunk + 1], net, solver)


def multiply_nodes(start: int, stop: int, net: Net, solver: Solver) -> None:
    """Add the products of springs at a range of lower nodes with the direction of search."""
    bar, search = solver.bar, solver.scratch[1]
    sums, to = net.chunks.sums, net.chunks.to
    for node in range(start, stop):
        i = 3 * node
        f0 = f1 = f2 = 0.0
        for s in range(net.first[node], net.first[node + 1]):
            j, k = net.other[s], to[s]
            w0, w1, w2 = (
                search[j] - search[i],
                search[j + 1] - search[i + 1],
                search[j + 2] - search[i + 2],
            )
            part = bar[s, 0] * (bar[s, 2] * w0 + bar[s, 3] * w1 + bar[s, 4] * w2)
            g0 = part * bar[s, 2] + bar[s, 1] * w0
            g1 = part * bar[s, 3] + bar[s, 1] * w1
            g2 = part * bar[s, 4] + bar[s, 1] * w2
            f0 += g0
            f1 += g1
            f2 += g2
            sums[k] += g0
            sums[k + 1] += g1
            sums[k + 2] += g2
        k = 4 * node
        sums[k] -= f0
        sums[k + 1] -= f1
        sums[k + 2] -= f2


def project(part: int, parts: int, net: Net, solver: Solver) -> None:
    """Add the products of masses and drag with the direction to the image; clear held nodes.

    The products of direction and image are summed by pieces.
    """
    search, image = solver.scratch[1], solver.scratch[2]
    first, last = part_of(part, parts, net.inverse_mass.size)
    for start in range(first, last, PIECE):
        product = 0.0
        for node in range(start, min(start + PIECE, last)):
            inverse, drag = net.inverse_mass[node], solver.made[0] * net.drag[node]
            for i in range(3 * node, 3 * node + 3):
                if inverse > 0.0:
                    image[i] += search[i] * (1.0 / inverse + drag)
                else:
                    image[i] = 0.0
                product += search[i] * image[i]
        net.team.lost[start // PIECE] = product


def advance(
    part: int, parts: int, step: float, vector: Floats, net: Net, solver: Solver
) -> None:
    """Move along the direction of search in a part of the nodes, and precondition."""
    residual, search, image = solver.scratch[0], solver.scratch[1], solver.scratch[2]
    first, last = part_of(part, parts, net.inverse_mass.size)
    for i in range(3 * first, 3 * last):
        vector[i] += step * search[i]
        residual[i] -= step * image[i]
    precondition(first, last, net, solver)


def precondition(first: int, last: int, net: Net, solver: Solver) -> None:
    """Multiply by the inverse blocks of some nodes; store the products with the residual."""
    residual, refined, block = solver.scratch[0], solver.scratch[3], solver.block
    for start in range(first, last, PIECE):
        product = 0.0
        for node in range(start, min(start + PIECE, last)):
            i = 3 * node
            if net.inverse_mass[node] > 0.0:
                r0, r1, r2 = residual[i], residual[i + 1], residual[i + 2]
                refined[i] = block[node, 0] * r0 + block[node, 3] * r1 + block[node, 5] * r2
                refined[i + 1] = block[node, 3] * r0 + block[node, 1] * r1 + block[node, 4] * r2
                refined[i + 2] = block[node, 5] * r0 + block[node, 4] * r1 + block[node, 2] * r2
                product += refined[i] * r0 + refined[i + 1] * r1 + refined[i + 2] * r2
            else:
                refined[i] = refined[i + 1] = refined[i + 2] = 0.0
        net.team.work[start // PIECE] = product
