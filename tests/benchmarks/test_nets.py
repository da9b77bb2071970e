"""The nets of the benchmarks: what they are, and that every method keeps its word on them."""

import pytest

from tissuec.bench.bench import bench
from tissuec.pipeline import Request, compile_request


def compiled(repository, name, *overrides):
    path = repository / "benchmarks" / "nets" / f"{name}.tis"
    found, warnings = compile_request(Request.file(path, overrides=overrides))
    assert not warnings
    return found


@pytest.mark.parametrize(
    ("name", "overrides", "nodes", "springs"),
    [
        ("tube", ("harder=1e4", "thicker=1e4", "knot=1e6"), 160, 544),
        ("lattice", (), 1000, 7560),
        ("lattice", ("edge nodes=22",), 10_648, 88_704),
    ],
)
def test_nets_have_the_sizes_that_they_are_known_by(
    repository, name, overrides, nodes, springs
):
    network = compiled(repository, name, *overrides).network
    assert (network.node_count, network.spring_count) == (nodes, springs)


@pytest.mark.slow
@pytest.mark.parametrize("overrides", [(), ("thicker=0",)], ids=["damped", "undamped"])
def test_errors_stay_near_tolerances_on_the_tube(repository, overrides):
    found = bench(
        compiled(repository, "tube", *overrides),
        methods=(), tolerances=(1e-2, 1e-3, 1e-4), repeat=1, budget=5.0, tell=print,
    )  # fmt: skip
    assert found.floor < 1e-6
    for point in found.points:
        if point.ours:
            assert point.error < 2.0 * point.tolerance, point.name
    assert found.ratios()
