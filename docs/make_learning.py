"""Learn the examples of ``learning.md``: what was answered, and figures of how it went.

    python -m docs.make_learning

takes some minutes, in the folder of the repository, and needs what the tests need and
matplotlib.
"""

import re
from pathlib import Path

import matplotlib
from msgspec import Struct

from tissuec.core.structs import replace

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from tests.learn.making import motion
from tissuec.compiler.compile import Compiled
from tissuec.core.markdown import fenced, replace_places
from tissuec.core.report import as_text
from tissuec.learn.fit.learning import LearnProgress, learn
from tissuec.learn.fit.outcome import Learnt
from tissuec.learn.report import differences, drifts, learnt_parts
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

HERE = Path(__file__).resolve().parent
PAGE, FIGURES = HERE / "learning.md", HERE / "figures"
GREY, LEARNT, HELD_OUT = "#999999", "#2166ac", "#b2182b"
CLOCK = re.compile(r", \d+\.\d s$", re.MULTILINE)


class Taught(Struct, frozen=True):
    """A learning of one of the examples, with its progress after each pass."""

    text: str
    compiled: Compiled
    learnt: Learnt
    passes: list[LearnProgress]

    def shown(self) -> str:
        """Return the learn block, and what was answered."""
        block = "learn " + self.text.partition("\nlearn ")[2]
        scene = self.compiled.scene
        moved = drifts(scene, self.learnt.words)
        said = CLOCK.sub("", "\n".join(as_text(learnt_parts(self.learnt, moved))))
        changed = "".join(differences(scene, self.learnt.words)).rstrip()
        parts = [fenced(block.rstrip()), fenced(said)]
        return "\n\n".join([*parts, *([fenced(changed, "diff")] if changed else [])])


def main() -> None:
    """Learn everything; rewrite the page and the figures."""
    taught = {name: teach(name) for name in ("cart", "stretch", "learn_gels", "learn_band")}
    contents = {name: taught[name].shown() for name in ("cart", "stretch", "learn_gels")}
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(replace_places(page, contents, mark="learnt"), encoding="utf-8")
    draw_cart(taught["cart"]).savefig(FIGURES / "learning_cart.png", dpi=110)
    draw_passes(taught).savefig(FIGURES / "learning_passes.png", dpi=110)


def teach(name: str) -> Taught:
    """Learn one of the examples."""
    path = HERE / "examples" / "learning" / f"{name}.tis"
    request = Request.file(path)
    compiled, _ = compile_request(request)
    passes: list[LearnProgress] = []
    learnt = learn(compiled, compiled.fit_problems[0], request, progress=passes.append)
    return Taught(path.read_text(encoding="utf-8"), compiled, learnt, passes)


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
        (~last, LEARNT, "learned from"),
        (last, HELD_OUT, "predicted, held out"),
    ):
        above.plot(at[part], predicted[part], color=colour, linewidth=1.0, label=name)
        below.plot(at[part], (seen - predicted)[part], ".", color=colour, markersize=2.5)
    above.set(ylabel="position of the cart [px]")
    below.set(xlabel="time [s]", ylabel="residual [px]")
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
