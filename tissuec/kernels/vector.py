"""Operations that are not on nets, as NumPy calls, for loops over steps that run as Python."""

from math import sqrt

import numpy as np

from tissuec.kernels.records import Buffer, Floats, Team


def is_passed(before: Floats, after: Floats) -> bool:
    """Return whether any spring has passed a corner between two looks."""
    return not np.array_equal(before, after)


def combine(
    x: Floats,
    to: float,
    weights: Floats,
    v: Floats,
    at: float,
    further: Floats,
    rows: Floats,
    out_x: Floats,
    out_v: Floats,
    team: Team,
) -> None:
    """Set out_x = x + to Σ weights_j rows_j and out_v = v + at Σ further_j rows_j."""
    np.dot(to * weights, rows, out=out_x)
    np.add(out_x, x, out=out_x)
    np.dot(at * further, rows, out=out_v)
    np.add(out_v, v, out=out_v)


def scale(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = factor vector."""
    np.multiply(vector, factor, out=out)


def polynomials(table: Floats, part: float, out: Floats) -> None:
    """Set out_j = Σ_k table[k, j] part^(k + 1)."""
    np.dot(part ** np.arange(1, len(table) + 1), table, out=out)


def quadrature(
    base: Floats, factor: float, weights: Floats, power: Floats, out: Floats
) -> None:
    """Set out = base + factor Σ weights_j power_j for the two columns of the ledger."""
    out[:] = base + factor * (weights @ power)


def drift(
    x: Floats, v: Floats, a: Floats, h: float, x_end: Floats, v_end: Floats, team: Team
) -> None:
    """Set x_end = x + h v + h²/2 a and v_end = v + h a."""
    np.multiply(a, h, out=v_end)
    np.multiply(v_end, 0.5, out=x_end)
    np.add(x_end, v, out=x_end)
    np.multiply(x_end, h, out=x_end)
    np.add(x_end, x, out=x_end)
    np.add(v_end, v, out=v_end)


def kick(v: Floats, a: Floats, a_end: Floats, h: float, v_end: Floats, team: Team) -> None:
    """Set v_end = v + h/2 (a + a_end)."""
    np.add(a, a_end, out=v_end)
    np.multiply(v_end, 0.5 * h, out=v_end)
    np.add(v_end, v, out=v_end)


def accumulate(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = out + factor vector."""
    out += factor * vector


def subtract(one: Floats, two: Floats, out: Floats) -> None:
    """Set out = one - two."""
    np.subtract(one, two, out=out)


def between(one: Floats, two: Floats, factor: float, less: Floats, out: Floats) -> None:
    """Set out = factor (two - one) - less."""
    np.subtract((two - one) * factor, less, out=out)


def distance(one: Floats, two: Floats, squares: Floats, team: Team) -> float:
    """Return the largest distance between the nodes of two vectors; NaN where one is none."""
    between = (one - two).reshape(-1, 3)[: squares.size]
    return sqrt(np.einsum("ij,ij->i", between, between).max(initial=0.0))


def blended_error(fifth: Floats, third: Floats, blend: Floats, team: Team) -> float:
    """Return the largest e5² / √(e5² + 0.01 e3²) over the nodes; NaN where it is none."""
    fifth, third = (e.reshape(-1, 3)[: blend.size] for e in (fifth, third))
    five = np.einsum("ij,ij->i", fifth, fifth)
    three = np.einsum("ij,ij->i", third, third)
    below = np.sqrt(five + 0.01 * three)
    return float((five / np.where(below == 0.0, 1.0, below)).max(initial=0.0))


def copy_sample(
    x: Floats, v: Floats, ledger: Floats, error: float, index: int, buffer: Buffer
) -> None:
    """Enter a state into the buffer as sample ``index``."""
    buffer.position[index] = x
    buffer.velocity[index] = v
    buffer.ledger[index] = ledger
    buffer.error[index] = error
