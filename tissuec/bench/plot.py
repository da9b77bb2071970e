"""Run time against error, drawn."""

from pathlib import Path

from tissuec.bench.bench import Bench
from tissuec.bench.plotting import new_figure, save


def draw(bench: Bench, path: Path, title: str) -> None:
    """Write the curves of all solvers to a file; ours are thick."""
    figure = new_figure(8.0, 6.0)
    axes = figure.subplots()
    for name in dict.fromkeys(point.name for point in bench.points):
        points = [point for point in bench.points if point.name == name]
        axes.loglog(
            [max(point.error, bench.floor) for point in points],
            [point.seconds for point in points],
            "o-" if points[0].ours else "x--",
            linewidth=2.0 if points[0].ours else 1.0,
            label=name,
        )
    axes.axvline(bench.floor, color="grey", linestyle=":", label="known to")
    axes.invert_xaxis()
    axes.set(xlabel="error over largest displacement", ylabel="time [s]", title=title)
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(fontsize="small")
    save(figure, path)
