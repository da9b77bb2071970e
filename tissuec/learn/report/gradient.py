"""Exact derivatives compared with differences."""

from collections.abc import Sequence

from tissuec.core.errors import counted
from tissuec.core.report import DONE, FAILED, FactTable, Part, Report
from tissuec.learn.fit.gradient_check import Compared

HEADINGS = ("derivative by", "exact", "by differences", "relative difference", "accuracy")
BETTER = 10.0  # times the doubt in differences: what is less is no sign of a mistake


def is_good(found: Sequence[Compared], allowed: float) -> bool:
    """Return whether all derivatives are right within the accuracy of differences."""
    return all(one.apart <= max(allowed, BETTER * one.doubt) for one in found)


def gradient_report(fit_problem: str, found: Sequence[Compared], allowed: float) -> Report:
    """Return a table of derivatives and the verdict on the worst of them.

    Args:
        fit_problem: Name of the ``learn`` block.
        found: The derivatives.
        allowed: Largest relative difference.
    """
    rows = [
        (one.name, f"{one.exact:+.9e}", f"{one.differences:+.9e}", f"{one.apart:.1e}",
         f"{one.doubt:.1e}")
        for one in found
    ]  # fmt: skip
    worst = max((one.apart for one in found), default=0.0)
    good = is_good(found, allowed)
    count = counted(len(found), "direction")
    last = f"{count}, at worst {worst:.1e} apart, allowed {allowed:g}"
    parts: list[Part] = [
        FactTable(HEADINGS, rows),
        f"learn {fit_problem}: derivatives are {'good' if good else 'WRONG'}: {last}",
    ]
    if good and worst > allowed:
        parts.append(
            "finite differences are not more accurate here: the motion is too "
            "sensitive for any step size"
        )
    document = {"gradient": [row._asdict() for row in found], "worst": worst}
    return Report(parts, document, DONE if good else FAILED)
