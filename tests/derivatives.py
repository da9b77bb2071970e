"""Forces of fields, and forces from energies by differences."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def forces(
    field: Any, position: Floats, velocity: Floats | None = None, time: float = 0.0
) -> Floats:
    """Return the forces of a field on all nodes [N], shape (…, node, 3).

    Args:
        field: Such as contact.
        position: Of all nodes [m], shape (…, node, 3).
        velocity: Of all nodes [m/s]; at rest by default.
        time: [s].
    """
    total = np.zeros_like(position)
    still = np.zeros_like(position) if velocity is None else velocity
    field.add_forces(time, position, still, total)
    return total


def stiffness(field: Any, position: Floats, column: int, step: float) -> Floats:
    """Return a column of the stiffness matrix by differences of forces [N/m], (3 node,).

    Args:
        field: Such as contact.
        position: Of all nodes [m], shape (node, 3).
        column: Number of the coordinate.
        step: [m].
    """
    way = np.zeros(position.size)
    way[column] = step
    way = way.reshape(position.shape)
    ahead, behind = (forces(field, position + each).ravel() for each in (way, -way))
    return (behind - ahead) / (2.0 * step)


def slopes(
    energy: Callable[[Floats], object], position: Floats, nodes: Iterable[int], step: float
) -> Floats:
    """Return minus the central differences of an energy by places of nodes [N], (chosen, 3).

    Args:
        energy: Of the places of all nodes [J].
        position: Of all nodes [m], shape (node, 3).
        nodes: The chosen ones.
        step: Of each coordinate [m].
    """
    found = []
    for node in nodes:
        for axis in range(3):
            way = np.zeros_like(position)
            way[node, axis] = step
            ahead, behind = (float(energy(position + each)) for each in (way, -way))
            found.append((behind - ahead) / (2.0 * step))
    return np.array(found).reshape(-1, 3)


def matrix_follows_from_forces(
    field: Any, position: Floats, matrix: Floats, *, every: int, step: float, allowed: float
) -> None:
    """Check some columns of a matrix against differences of forces.

    Args:
        field: Whose forces these are.
        position: Of all nodes [m], shape (node, 3).
        matrix: Minus the derivative of the forces [N/m], shape (3 node, 3 node).
        every: One in so many columns is checked.
        step: Half of the difference in position [m].
        allowed: Differences that are allowed, relative to the largest entry.
    """
    for column in range(0, len(matrix), every):
        by_force = stiffness(field, position, column, step)
        np.testing.assert_allclose(
            matrix[:, column], by_force, atol=allowed * np.abs(matrix).max()
        )


def follow_from_the_energy(
    field: Any, position: Floats, *, every: int, force: float, matrix: float, rounding: float
) -> None:
    """Check forces against an energy, an exact matrix against forces, and a positive one.

    Args:
        field: With elements, such as ``solids.elements.SolidElements``.
        position: Of all nodes [m], shape (node, 3).
        every: One in so many columns of the matrix is checked.
        force, matrix: Differences that are allowed, relative to the largest entries.
        rounding: Asymmetry of the matrix that is allowed, likewise.
    """
    count = len(position)
    by_energy = slopes(lambda x: field.energy(0.0, x), position, range(count), 1e-8)
    found = forces(field, position)
    np.testing.assert_allclose(found, by_energy, atol=force * np.abs(found).max())
    exact, clamped = (
        field.matrix(0.0, position, np.arange(count), count, exact=each).toarray()
        for each in (True, False)
    )
    np.testing.assert_allclose(exact, exact.T, atol=rounding * np.abs(exact).max())
    matrix_follows_from_forces(field, position, exact, every=every, step=1e-9, allowed=matrix)
    lowest = float(np.linalg.eigvalsh(clamped)[0])
    assert lowest > -max(rounding, 1e-13) * np.abs(clamped).max()


def agree(
    field: Any,
    reference: Any,
    position: Floats,
    velocity: Floats,
    *,
    force: float,
    matrix: float,
    energy: float,
    lost: float,
) -> None:
    """Check forces, matrix, energy and dissipation of a field against the reference.

    Args:
        field, reference: Of the same elements.
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        force, matrix, energy, lost: Relative differences that are allowed.
    """
    found, own = forces(field, position, velocity), np.zeros_like(position)
    count = len(position)
    reference.add_forces(0.0, position, velocity, own)
    np.testing.assert_allclose(found, own, atol=force * np.abs(own).max())
    matrices = [
        one.matrix(0.0, position, np.arange(count), count).toarray()
        for one in (field, reference)
    ]
    np.testing.assert_allclose(*matrices, atol=matrix * np.abs(matrices[0]).max())
    assert field.energy(0.0, position) == pytest.approx(
        reference.energy(0.0, position), rel=energy
    )
    dissipated = field.powers(0.0, position, velocity)[1]
    due = reference.dissipated(0.0, position, velocity)
    assert dissipated == pytest.approx(due, rel=lost)
