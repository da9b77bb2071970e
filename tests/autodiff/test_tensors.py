"""Functions of tensors against NumPy."""

import numpy as np

from tests.every import every
from tissuec.autodiff import Tensor, largest
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph

VALUES = {
    "equal": [2.0, 2.0, 2.0], "two large": [2.0, 2.0, 0.5], "two small": [2.0, 0.5, 0.5],
    "near": [2.0, 2.0 + 1e-12, -3.0], "signs": [3.0, -4.0, 1.0], "zero": [0.0, 0.0, -1.0],
    "far": [1e9, 1.0, 1e-9], "plane": [3.0, -4.0], "equal plane": [2.0, 2.0],
}  # fmt: skip


@every("name", VALUES)
def test_the_largest_eigenvalue_is_exact_also_where_some_are_equal(name):
    values, random = np.array(VALUES[name]), np.random.default_rng(3)
    size, graph = len(values), Graph()
    rows = [[graph.input(f"{min(i, j)}{max(i, j)}") for j in range(size)] for i in range(size)]
    found = largest(Tensor(rows))
    for _ in range(50):
        way = np.linalg.qr(random.normal(size=(size, size)))[0]
        a = way @ np.diag(values) @ way.T
        at = {f"{i}{j}": a[i, j] for i in range(size) for j in range(i, size)}
        error = evaluate([found], at)[0] - values.max()
        assert abs(error) <= 2e-15 * np.abs(values).max()
