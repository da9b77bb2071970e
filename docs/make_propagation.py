"""Draw the errors of the published propagation for ``numerics.md``.

    python -m benchmarks.propagation --json > propagation.json
    python docs/make_propagation.py propagation.json

needs matplotlib.
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

FIGURE = Path(__file__).resolve().parent / "figures" / "propagation.png"
COLOURS = ("#b2182b", "#2166ac", "#777777")


def main(path: Path) -> None:
    """Draw errors against the frame and against the work."""
    found = json.loads(path.read_text(encoding="utf-8"))
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.8, 3.6), layout="constrained")
    for (name, runs), colour in zip(found.items(), COLOURS, strict=True):
        done = [run for run in runs if run["error"] is not None]
        errors = [run["error"] for run in done]
        look = {"color": colour, "marker": "o", "markersize": 4, "label": name}
        left.loglog([1e3 * run["frame"] for run in done], errors, **look)
        right.loglog([run["evaluations"] for run in done], errors, **look)
    left.set(xlabel="frame t_Δ, or step [ms]", ylabel="error of positions (relative)")
    right.set(xlabel="evaluations of the forces")
    for axes in (left, right):
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.yaxis.set_minor_formatter("")
    left.legend(frameon=False, fontsize=8)
    figure.savefig(FIGURE, dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
