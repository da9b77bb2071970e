"""Stress against strain of tissues in the laboratory, compared with evidence."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import PERCENT, AxisUnit, scale_of
from tissuec.view.plots import PLOTS
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

WIDTH, ROW, LEGEND = 150.0, 65.0, 14.0  # [mm]
LOOKS = {
    "coarse": {"color": SERIES[1], "linestyle": "--", "marker": "o", "markersize": 2.5},
    "fine": {"color": SERIES[0], "linestyle": "-", "marker": ".", "markersize": 3.0},
}
#: Of what is known: one colour and hatch for each kind.
KNOWN = {
    "Young's modulus": {"color": SERIES[2], "alpha": 0.25},
    "breaking strain": {"color": SERIES[5], "alpha": 0.25},
    "strength": {"color": SERIES[3], "alpha": 0.2},
}


@PLOTS.member("stress-strain")
class StressStrain(Struct, frozen=True):
    """Stress against strain of each tissue, on both coupons, beside what is known."""

    takes: ClassVar[str] = "laboratory"
    several: ClassVar[bool] = False

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of the curves of tissues.

        Raises:
            TissueError: There is no curve of any tissue.
        """
        every = subjects[0].content["tissues"]
        tissues = [one for one in every if any(map(len, one["curves"].values()))]
        if not tissues:
            raise TissueError(f'"{subjects[0].name}" contains no curve of a tissue')

        def draw(sheet: Canvas) -> None:
            rows = sheet.figure.subplots(len(tissues), squeeze=False)[:, 0]
            for axes, tissue in zip(rows, tissues, strict=True):
                _draw(axes, tissue)
            shown = [axes.get_legend_handles_labels() for axes in rows]
            named = {label: one for some in shown for one, label in zip(*some, strict=True)}
            sheet.figure.legend(
                named.values(), named.keys(), loc="outside lower center", ncols=3
            )

        return Picture(WIDTH, LEGEND + ROW * len(tissues), draw)


def _draw(axes: "Axes", tissue: Mapping[str, Any]) -> None:
    curves = {name: _joined(parts) for name, parts in tissue["curves"].items() if parts}
    scale = scale_of("Pa", [stress for _, stress in curves.values()])
    for name, (strain, stress) in curves.items():
        look: Any = LOOKS[name]
        axes.plot(PERCENT.of(strain), scale.of(stress), label=f"{name} coupon", **look)
    limits = axes.get_xlim(), axes.get_ylim()
    for quantity, low, high in _known(tissue):
        _shade(axes, quantity, low, high, scale)
    axes.set(xlim=limits[0], ylim=limits[1])
    for row in tissue["rows"]:
        if row["quantity"] == "breaking strain" and _is_number(row["fine"]):
            strain, stress = curves["fine"]
            end = scale.of(stress[np.argmax(strain)])
            axes.plot(PERCENT.of(row["fine"]), end, "x", color=INK, label="first spring breaks")
    axes.set(xlabel=PERCENT.label("strain"), ylabel=scale.label("stress"))
    axes.set_title(tissue["tissue"])


def _joined(curves: Sequence[Mapping[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the strains and stresses of all curves as one, ascending."""
    strain = np.concatenate([curve["strain"] for curve in curves])
    stress = np.concatenate([curve["stress"] for curve in curves])
    order = np.argsort(strain, kind="stable")
    return strain[order], stress[order]


def _known(tissue: Mapping[str, Any]) -> Iterator[tuple[str, float, float]]:
    """Yield what is known, each range once: its quantity and limits."""
    found = {
        (row["quantity"], one["low"], one["high"])
        for row in tissue["rows"]
        for one in row["known"]
        if row["quantity"] in KNOWN
    }
    yield from sorted(found)


def _shade(axes: "Axes", quantity: str, low: float, high: float, scale: AxisUnit) -> None:
    """Shade where curves may be: a wedge of moduli, or a band of strains or stresses."""
    look: Any = {**KNOWN[quantity], "linewidth": 0.0, "label": f"known {quantity}"}
    if quantity == "breaking strain":
        axes.axvspan(*PERCENT.of([low, high]), **look)
    elif quantity == "strength":
        axes.axhspan(*scale.of([low, high]), **look)
    else:
        strain = np.array(axes.get_xlim()) / PERCENT.factor
        ends = np.array([strain[0], 0.0, strain[1]])
        axes.fill_between(PERCENT.of(ends), scale.of(low * ends), scale.of(high * ends), **look)


def _is_number(value: Any) -> bool:
    return value is not None and np.isfinite(value)
