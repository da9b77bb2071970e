"""Texts at axes: names that fit beside them, and powers of ten without formulas."""

import re
from functools import cache
from textwrap import wrap
from typing import Any

_RAISED = str.maketrans("0123456789-−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻")
_POWER = re.compile(r"\^\{([^}]*)\}")
_LEAST = 8  # letters of a line


def wrapped_labels(figure: Any) -> bool:
    """Wrap the names of axes that are longer than these; return whether any was."""
    found = False
    for axes in figure.axes:
        if not axes.axison:
            continue
        box = axes.get_window_extent()
        for label, side, room in (
            (axes.xaxis.label, "width", box.width),
            (axes.yaxis.label, "height", box.height),
        ):
            text, length = label.get_text(), getattr(label.get_window_extent(), side)
            if length <= room:
                continue
            letters = max(_LEAST, int(max(map(len, text.split("\n"))) * room / length))
            lines = wrap(text.replace("\n", " "), letters, break_long_words=False)
            found |= text != "\n".join(lines)
            label.set_text("\n".join(lines))
    return found


def powers_as_text(axis: Any) -> None:
    """Have a logarithmic axis write 10⁻³ in letters: a formula has smaller ones."""
    from matplotlib.ticker import LogFormatterSciNotation

    for which in ("major", "minor"):
        formatter = getattr(axis, f"get_{which}_formatter")()
        if type(formatter) is LogFormatterSciNotation:
            getattr(axis, f"set_{which}_formatter")(_powers()(like=formatter))


@cache
def _powers() -> type[Any]:
    from matplotlib.ticker import LogFormatterSciNotation

    class PowerFormatter(LogFormatterSciNotation):
        """Powers of ten in letters."""

        def __init__(self, like: Any):
            super().__init__(
                like._base, like.labelOnlyBase, like.minor_thresholds, like._linthresh
            )

        def __call__(self, x: float, pos: int | None = None) -> str:
            return _in_letters(super().__call__(x, pos))

    return PowerFormatter


def _in_letters(formula: str) -> str:
    """Return 2×10⁻³ for $\\mathdefault{2\\times10^{-3}}$."""
    plain = formula.removeprefix(r"$\mathdefault{").removesuffix("}$")
    plain = plain.replace(r"\times", "×")
    return _POWER.sub(lambda found: found[1].translate(_RAISED), plain)
