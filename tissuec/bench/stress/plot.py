"""The map of a stress test, drawn."""

from pathlib import Path

from tissuec.bench.plotting import new_figure, save
from tissuec.bench.stress.grid import SIGNS, Stress

COLOURS = {
    "good": "#4c9f70", "energy": "#9ccc9c", "warned": "#f2c14e", "refused": "#f7e3a1",
    "slow": "#c8d3e0", "none": "#f2f2f2", "wrong": "#c0392b", "crash": "#000000",
}  # fmt: skip


def draw(stress: Stress, path: Path) -> None:
    """Write the map to a file: a row for each scene, a column for each method."""
    rows, width = stress.rows, len(stress.methods)
    figure = new_figure(2.0 + 1.2 * width, 1.5 + 0.22 * len(rows))
    axes = figure.subplots()
    for place, verdict in enumerate(stress.verdicts):
        row, column = divmod(place, width)
        axes.barh(row, 0.96, left=column, height=0.9, color=COLOURS[verdict.kind])
    axes.set_yticks(range(len(rows)), [f"{axis} {value}" for axis, value, *_ in rows])
    axes.set_xticks([column + 0.5 for column in range(width)], stress.methods, rotation=30)
    axes.invert_yaxis()
    axes.set_xlim(0, width)
    shown = {verdict.kind for verdict in stress.verdicts}
    for kind, (sign, _) in SIGNS.items():
        if kind in shown:
            axes.bar(0, 0, 0, color=COLOURS[kind], label=sign)
    figure.legend(loc="outside lower center", ncols=len(shown))
    save(figure, path)
