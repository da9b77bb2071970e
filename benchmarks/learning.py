"""Learning: the cost of a gradient, its error, and how near the truth what is learnt comes.

Takes some minutes, and needs what the tests need: motions, nets and checks are those of
tests/learn.
"""

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np

from benchmarks.gradients import cost
from benchmarks.publishing import DOCS, publish, write_option
from tests.learn import test_learning as known
from tests.learn.making import motion
from tests.learn.test_motion import apart_from_long_doubles, motion_of
from tests.learn.tubes import tube
from tissuec.core.markdown import table
from tissuec.core.source import Source
from tissuec.learn.fit.learning import learn
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

CART = DOCS / "examples" / "learning" / "cart.tis"
STEP, SAMPLES = 50e-6, 51  # of the gradient whose cost is measured
REPEATS, DIRECTIONS, TUBES = 15, 20, (16, 10)


@click.command(help=__doc__)
@write_option
def main(*, write: bool) -> None:
    """Measure everything."""
    tables = {"how good": table(("what", "measured"), list(rows()))}
    publish("learning", tables, write=write, page="learning.md")


def rows() -> Iterator[tuple[str, str]]:
    """Yield the rows of the table."""
    yield (
        "Cost of the gradient by all 1990 parameters of the tube over 1000 steps, in runs",
        f"{cost_of_gradient():.1f}",
    )
    apart = apart_from_long_doubles(tube(), DIRECTIONS)
    yield (
        f"Its error against differences of long doubles, worst of {DIRECTIONS} directions",
        f"{apart.max():.1e}",
    )
    with tempfile.TemporaryDirectory() as folder:
        yield from all_springs(Path(folder))
        yield hidden_nodes(Path(folder))
        yield scatter(Path(folder))
    yield cart()


def cost_of_gradient() -> float:
    """Return the time of a gradient over that of the motion alone."""
    moved, vector = motion_of(tube(), "velocity verlet", STEP, np.linspace(0.0, 0.05, SAMPLES))
    weights = np.random.default_rng(0).standard_normal((SAMPLES, 480))
    moved.forward(vector)
    moved.backward(weights, weights)
    return cost(moved, vector, weights, REPEATS)


def all_springs(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield how well every spring of the tube comes back from data without noise."""
    rings, sides = TUBES
    began = time.process_time()
    _, _, true, learnt = known.learn_tube(
        folder, 2e-3, rings=rings, sides=sides, **known.PUSHED
    )
    spent = time.process_time() - began
    springs, _ = learnt.estimates
    error = np.abs(springs.value / true - 1.0).max()
    yield (
        f"All {len(true)} spring constants of a tube, off by up to 30 %, and its mass, from "
        "50 ms of exact positions: largest error of a constant",
        f"{error:.1e}, in {spent:.0f} s of the processor",
    )


def hidden_nodes(folder: Path) -> tuple[str, str]:
    """Return how far nodes that were not seen are from where they truly were."""
    rings, sides = TUBES
    seen = [n for n in range(rings * sides) if (n // sides + 2 * (n % sides)) % 4 == 0]
    form = {**known.LIFTED, "seen": f"in [{', '.join(str(n + 1) for n in seen)}]"}
    scene, true, _, learnt = known.learn_tube(folder, 2e-3, rings=rings, sides=sides, **form)
    network = scene.network.with_arrays({"stiffness": learnt.estimates[0].value})
    apart = np.linalg.norm(motion(scene, 2e-3, network)[1] - true, axis=2)
    moved = np.linalg.norm(true - true[0], axis=2)
    hidden = np.setdiff1d(np.arange(rings * sides), seen)
    return (
        f"The same tube, {len(seen)} of {rings * sides} nodes seen: largest error of the "
        "position of an unseen node, relative to the largest displacement",
        f"{100 * apart[:, hidden].max() / moved[:, hidden].max():.2g} %",
    )


def scatter(folder: Path) -> tuple[str, str]:
    """Return how estimates scatter, in units of what is predicted."""
    text = known.CHAIN.format(**known.TRUE, more="")
    scene, _ = compile_request(Request(Source("true.tis", text)))
    ratio, _ = known.scatter((scene, *motion(scene, 10e-3)), folder, 50)
    return (
        "Scatter of five parameters over 50 repeats with other noise, divided by the "
        "Cramér-Rao bound (50 repeats are accurate to 10 %)",
        f"{ratio.min():.2f} to {ratio.max():.2f}",
    )


def cart() -> tuple[str, str]:
    """Return the residuals of the positions of a cart."""
    request = Request.file(CART)
    compiled, _ = compile_request(request)
    one, last = learn(compiled, compiled.fit_problems[0], request).fitted
    (left,), (unseen,) = one.left.values(), last.left.values()
    return (
        "The cart, 870 pictures: residual of the first three quarters, and of the last",
        f"{1e3 * left:.2f} px, {1e3 * unseen:.2f} px",
    )


if __name__ == "__main__":
    main()
