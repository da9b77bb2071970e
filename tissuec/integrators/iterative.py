"""The matrix of an implicit step by conjugate gradients, for nets whose band is wide.

The same S as in ``banded``, never formed: per spring what acts along and across it. Inverses of
the diagonal blocks of the nodes are the preconditioner.
"""

from math import sqrt

from tissuec.forces.springs_kernel import resistance
from tissuec.kernels.records import Floats, Net, Solver
from tissuec.kernels.vectors import TINY

PRECISION = 1e-3  # of the residual; Newton's method repeats what is left
ROUNDS = 500


def assemble(q: float, x: Floats, v: Floats, net: Net, solver: Solver) -> bool:
    """Make what multiplies by S, and the inverses of its diagonal blocks."""
    bar, block = solver.bar, solver.block
    for node in range(block.shape[0]):
        inverse = net.inverse_mass[node]
        mass = (1.0 / inverse if inverse > 0.0 else 1.0) + q * net.drag[node]
        for k in range(6):
            block[node, k] = mass if k < 3 else 0.0
    for node in range(net.first.size - 1):
        for s in range(net.first[node], net.first[node + 1]):
            other = net.other[s] // 3
            i, j = 3 * node, 3 * other
            r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
            length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
            inverse = 1.0 / (length + TINY)
            along = q * net.damping[s] + q * q * net.stiffness[s]
            across = q * q * net.stiffness[s] * max(1.0 - net.rest[s] * inverse, 0.0)
            if net.law[s] > 0:
                along, across = resistance(q, s, i, j, length, x, v, net)
            n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
            bar[s, 0], bar[s, 1] = along - across, across
            bar[s, 2], bar[s, 3], bar[s, 4] = n0, n1, n2
            for end in (node, other):
                block[end, 0] += (along - across) * n0 * n0 + across
                block[end, 1] += (along - across) * n1 * n1 + across
                block[end, 2] += (along - across) * n2 * n2 + across
                block[end, 3] += (along - across) * n0 * n1
                block[end, 4] += (along - across) * n1 * n2
                block[end, 5] += (along - across) * n0 * n2
    definite = True
    for node in range(block.shape[0]):
        definite &= invert(node, block)
    return definite


def invert(node: int, block: Floats) -> bool:
    """Replace a symmetric block by its inverse; return False if it has none."""
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
    residual, search = solver.scratch[0], solver.scratch[1]
    image, refined = solver.scratch[2], solver.scratch[3]
    for node in range(net.inverse_mass.size):
        inverse = net.inverse_mass[node]
        for i in range(3 * node, 3 * node + 3):
            residual[i] = vector[i] / inverse if inverse > 0.0 else 0.0
            vector[i] = 0.0
    product = precondition(residual, refined, net, solver)
    for i in range(search.size):
        search[i] = refined[i]
    enough = PRECISION * PRECISION * product
    for _ in range(ROUNDS):
        if not product > enough:
            return product == product
        multiply(search, image, net, solver)
        part = 0.0
        for i in range(search.size):
            part += search[i] * image[i]
        step = product / part
        for i in range(search.size):
            vector[i] += step * search[i]
            residual[i] -= step * image[i]
        before = product
        product = precondition(residual, refined, net, solver)
        ratio = product / before
        for i in range(search.size):
            search[i] = refined[i] + ratio * search[i]
    return False


def precondition(residual: Floats, refined: Floats, net: Net, solver: Solver) -> float:
    """Multiply by the inverse blocks; return the product with the residual."""
    block = solver.block
    product = 0.0
    for node in range(block.shape[0]):
        i = 3 * node
        if net.inverse_mass[node] > 0.0:
            r0, r1, r2 = residual[i], residual[i + 1], residual[i + 2]
            refined[i] = block[node, 0] * r0 + block[node, 3] * r1 + block[node, 5] * r2
            refined[i + 1] = block[node, 3] * r0 + block[node, 1] * r1 + block[node, 4] * r2
            refined[i + 2] = block[node, 5] * r0 + block[node, 4] * r1 + block[node, 2] * r2
            product += refined[i] * r0 + refined[i + 1] * r1 + refined[i + 2] * r2
        else:
            refined[i] = refined[i + 1] = refined[i + 2] = 0.0
    return product


def multiply(vector: Floats, image: Floats, net: Net, solver: Solver) -> None:
    """Set ``image`` to S times a vector that is zero at held nodes."""
    bar = solver.bar
    for node in range(net.inverse_mass.size):
        inverse, drag = net.inverse_mass[node], solver.made[0] * net.drag[node]
        for i in range(3 * node, 3 * node + 3):
            image[i] = vector[i] * (1.0 / inverse + drag) if inverse > 0.0 else 0.0
    for node in range(net.first.size - 1):
        i = 3 * node
        f0 = f1 = f2 = 0.0
        for s in range(net.first[node], net.first[node + 1]):
            j = net.other[s]
            w0, w1, w2 = (
                vector[j] - vector[i],
                vector[j + 1] - vector[i + 1],
                vector[j + 2] - vector[i + 2],
            )
            part = bar[s, 0] * (bar[s, 2] * w0 + bar[s, 3] * w1 + bar[s, 4] * w2)
            g0 = part * bar[s, 2] + bar[s, 1] * w0
            g1 = part * bar[s, 3] + bar[s, 1] * w1
            g2 = part * bar[s, 4] + bar[s, 1] * w2
            f0 += g0
            f1 += g1
            f2 += g2
            image[j] += g0
            image[j + 1] += g1
            image[j + 2] += g2
        image[i] -= f0
        image[i + 1] -= f1
        image[i + 2] -= f2
    for node in range(net.inverse_mass.size):
        if net.inverse_mass[node] == 0.0:
            image[3 * node] = image[3 * node + 1] = image[3 * node + 2] = 0.0
