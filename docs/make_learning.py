"""Learn the examples and measure what learning costs and how good it is, for ``learning.md``.

    python -m docs.make_learning

takes some minutes, in the folder of the repository, and needs what the tests need and
matplotlib: the motions, nets and checks are those of ``tests/learn``.
"""

import re
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

import matplotlib
from msgspec import Struct
from msgspec.structs import replace

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from tests.learn import test_learning as known
from tests.learn.making import motion
from tests.learn.test_motion import apart_from_long_doubles, motion_of
from tests.learn.tubes import tube
from tissuec.compiler import Compiled
from tissuec.core.markdown import fenced, replace_places, table
from tissuec.core.source import Source
from tissuec.learn.learning import Progress, learn
from tissuec.learn.outcome import Learnt
from tissuec.learn.telling.text import as_text
from tissuec.learn.telling.words import differences, drifts
from tissuec.pipeline import Request, compile_request

HERE = Path(__file__).resolve().parent
PAGE, FIGURES = HERE / "learning.md", HERE / "figures"
STEP, SAMPLES = 50e-6, 51  # of the gradient whose cost is measured
REPEATS, DIRECTIONS, TUBES = 15, 20, (16, 10)
GREY, LEARNT, HELD_OUT = "#999999", "#2166ac", "#b2182b"
CLOCK = re.compile(r", \d+\.\d s$", re.MULTILINE)


class Taught(Struct, frozen=True):
    """A learning of one of the examples, with its progress after each pass."""

    text: str
    compiled: Compiled
    learnt: Learnt
    passes: list[Progress]

    def shown(self) -> str:
        """Return the learn block, and what was answered."""
        block = "learn " + self.text.partition("\nlearn ")[2]
        scene = self.compiled.scene
        moved = drifts(scene, self.learnt.words)
        said = CLOCK.sub("", "\n".join(as_text(self.learnt, moved)))
        changed = "".join(differences(scene, self.learnt.words)).rstrip()
        parts = [fenced(block.rstrip()), fenced(said)]
        return "\n\n".join([*parts, *([fenced(changed, "diff")] if changed else [])])


def main() -> None:
    """Measure everything; rewrite the page and the figures."""
    taught = {name: teach(name) for name in ("cart", "stretch", "learn_gels", "learn_band")}
    contents = {name: taught[name].shown() for name in ("cart", "stretch", "learn_gels")}
    rows = list(measured(taught["cart"].learnt))
    contents["how good"] = table(("what", "measured"), rows)
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(replace_places(page, contents, mark="measured"), encoding="utf-8")
    draw_cart(taught["cart"]).savefig(FIGURES / "learning_cart.png", dpi=110)
    draw_passes(taught).savefig(FIGURES / "learning_passes.png", dpi=110)


def teach(name: str) -> Taught:
    """Learn one of the examples."""
    path = HERE / "examples" / "learning" / f"{name}.tis"
    request = Request.file(path)
    compiled, _ = compile_request(request)
    passes: list[Progress] = []
    learnt = learn(compiled, compiled.lessons[0], request, progress=passes.append)
    return Taught(path.read_text(encoding="utf-8"), compiled, learnt, passes)


# --- how good, how dear -----------------------------------------------------------------------


def measured(cart: Learnt) -> Iterator[tuple[str, str]]:
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
    one, last = cart.fitted
    (left,), (unseen,) = one.left.values(), last.left.values()
    yield (
        "The cart, 871 pictures: residual of the first three quarters, and of the last",
        f"{1e3 * left:.2f} px, {1e3 * unseen:.2f} px",
    )


def cost_of_gradient() -> float:
    """Return the time of a gradient over that of the motion alone."""
    moved, vector = motion_of(tube(), "velocity verlet", STEP, np.linspace(0.0, 0.05, SAMPLES))
    weights = np.random.default_rng(0).standard_normal((SAMPLES, 480))
    moved.forward(vector)
    moved.backward(weights, weights)
    ratios = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        moved.forward(vector)
        forward = time.perf_counter() - began
        moved.backward(weights, weights)
        ratios.append((time.perf_counter() - began) / forward)
    return median(ratios)


def all_springs(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield how well every spring of the tube comes back from data without noise."""
    rings, sides = TUBES
    began = time.process_time()
    _, _, true, learnt = known.learn_tube(folder, rings=rings, sides=sides, **known.PUSHED)
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
    scene, true, _, learnt = known.learn_tube(folder, rings=rings, sides=sides, **form)
    network = replace(scene.network, stiffness=learnt.estimates[0].value)
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


# --- figures ----------------------------------------------------------------------------------


def draw_cart(cart: Taught) -> plt.Figure:
    """Return what was measured, what was learnt, and what is left, in pixels."""
    path = HERE / "examples" / "learning" / "cart.csv"
    at, seen = np.loadtxt(path, delimiter=",", skiprows=1).T
    predicted = predicted_cart(cart, at)
    last = at > at[0] + 0.75 * (at[-1] - at[0])
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(8.8, 4.6), layout="constrained", sharex=True, height_ratios=(2, 1)
    )
    above.plot(at, seen, ".", color=GREY, markersize=2.5, label="measured")
    for part, colour, name in (
        (~last, LEARNT, "learnt from"),
        (last, HELD_OUT, "foretold, held out"),
    ):
        above.plot(at[part], predicted[part], color=colour, linewidth=1.0, label=name)
        below.plot(at[part], (seen - predicted)[part], ".", color=colour, markersize=2.5)
    above.set(ylabel="place of the cart [px]")
    below.set(xlabel="time [s]", ylabel="left [px]")
    above.legend(frameon=False, fontsize=8, ncols=3, loc="lower right", markerscale=3)
    bare(above, below)
    return figure


def predicted_cart(cart: Taught, at: np.ndarray) -> np.ndarray:
    """Return where the cart is [px] with what was learnt, by the engine."""
    constant, viscosity, place, speed = (one.value[0] for one in cart.learnt.estimates)
    network = cart.compiled.network
    position, velocity = network.position.copy(), network.velocity.copy()
    position[1, 0], velocity[1, 0] = place, speed
    changed = replace(
        network,
        stiffness=np.full(2, constant),
        damping=np.full(2, viscosity),
        position=position,
        velocity=velocity,
    )
    times, found = motion(cart.compiled, 1e-2, changed)
    (zero,) = cart.learnt.zeros.values()
    smooth = np.interp(at, times, found[:, 1, 0])
    return 1e3 * (smooth + zero)


def draw_passes(taught: dict[str, Taught]) -> plt.Figure:
    """Return how errors of what was held out fall from pass to pass."""
    figure, axes = plt.subplots(figsize=(6.6, 3.4), layout="constrained")
    for name, title in (
        ("learn_band", "band, another pull"),
        ("cart", "cart, last quarter"),
        ("learn_gels", "gels, another force"),
    ):
        passes = [one for one in taught[name].passes if one.held_out is not None]
        (line,) = axes.semilogy(
            [one.passes for one in passes],
            [one.held_out for one in passes],
            linewidth=1.0,
            label=title,
        )
        for whole, fill in ((True, line.get_color()), (False, "white")):
            some = [one for one in passes if (one.horizon == 1.0) is whole]
            axes.plot(
                [one.passes for one in some],
                [one.held_out for one in some],
                "o",
                color=line.get_color(),
                markerfacecolor=fill,
                markersize=4,
            )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="passes", ylabel="error of what was held out (relative)")
    axes.legend(frameon=False, fontsize=8)
    bare(axes)
    return figure


def bare(*many: plt.Axes) -> None:
    """Leave out what is not needed."""
    for axes in many:
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
