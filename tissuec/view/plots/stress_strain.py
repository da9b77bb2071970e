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

WIDTH, ROW, LEGEND = 150.0, 65.0, 20.0  # [mm]
#: Styles of curves by their modes; compression continues tension below 0.
LOOKS = {
    "tension": {"color": SERIES[0], "marker": "."},
    "compression": {"color": SERIES[0], "marker": "."},
    "shear": {"color": SERIES[1], "marker": "s"},
    "equibiaxial tension": {"color": SERIES[4], "marker": "^"},
    "tension across fibres": {"color": SERIES[6], "marker": "v"},
}
#: Of what is known: one colour and hatch for each kind.
KNOWN = {
    "Young's modulus": {"color": SERIES[2], "alpha": 0.25},
    "breaking strain": {"color": SERIES[5], "alpha": 0.25},
    "strength": {"color": SERIES[3], "alpha": 0.2},
}


@PLOTS.member("stress-strain")
class StressStrain(Struct, frozen=True):
    """Stress against strain of each tissue, in all modes, with the evidence."""

    takes: ClassVar[str] = "laboratory"
    several: ClassVar[bool] = False

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of the curves of tissues.

        Raises:
            TissueError: There is no curve of any tissue.
        """
        every = subjects[0].content["tissues"]
        tissues = [
            one for one in every if any(curve["mode"] in LOOKS for curve in one["curves"])
        ]
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
    curves = [one for one in tissue["curves"] if one["mode"] in LOOKS]
    scale = scale_of("Pa", [np.asarray(one["value"], dtype=float) for one in curves])
    for one in curves:
        look: Any = LOOKS[one["mode"]]
        sign = -1.0 if one["mode"] == "compression" else 1.0
        place = PERCENT.of(sign * np.array(one["place"]))
        style: Any = {"color": look["color"], "linewidth": 0.8}
        is_same = one["mode"] == "compression"  # as tension, which is in the legend
        label = "_" if is_same else one["mode"]
        axes.plot(
            place, scale.of(sign * np.array(one["value"])), label=label, marker=look["marker"],
            markersize=3.0, **style,
        )  # fmt: skip
        check = np.array([np.nan if each is None else each for each in one["check"]])
        there = np.isfinite(check)
        if there.any():
            axes.plot(
                place[there], scale.of(sign * check[there]), linestyle="--", label="_", **style
            )
        for known in one["known"]:
            band = sorted(
                [sign * np.array(known["low"]), sign * np.array(known["high"])], key=max
            )
            axes.fill_between(
                PERCENT.of(sign * np.array(known["places"])), *map(scale.of, band),
                color=look["color"], alpha=0.2, linewidth=0.0, label="known stress",
            )  # fmt: skip
    limits = axes.get_xlim(), axes.get_ylim()
    for quantity, low, high in _known(tissue):
        _shade(axes, quantity, low, high, scale)
    axes.set(xlim=limits[0], ylim=limits[1])
    torn = {
        row["quantity"]: row["measured"]
        for row in tissue["rows"]
        if row["quantity"] in ("breaking strain", "strength") and _is_number(row["measured"])
    }
    if len(torn) == 2:
        place = PERCENT.of(torn["breaking strain"]), scale.of(torn["strength"])
        axes.plot(*place, "x", color=INK, label="it tears")
    axes.set(xlabel=PERCENT.label("strain"), ylabel=scale.label("stress"))
    axes.set_title(tissue["tissue"])


def _known(tissue: Mapping[str, Any]) -> Iterator[tuple[str, float, float]]:
    """Yield known ranges, each once: quantity and limits."""
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
