"""Exact derivatives compared with differences."""

from collections.abc import Sequence

from tissuec.core.columns import aligned
from tissuec.core.errors import counted
from tissuec.learn.fit.gradient_check import Compared

HEADINGS = ("derivative by", "exact", "by differences", "relative difference", "accuracy")
BETTER = 10.0  # times the doubt in differences: what is less is no sign of a mistake


def is_good(found: Sequence[Compared], allowed: float) -> bool:
    """Return whether all derivatives are right within the accuracy of differences."""
    return all(one.apart <= max(allowed, BETTER * one.doubt) for one in found)


def as_lines(fit_problem: str, found: Sequence[Compared], allowed: float) -> list[str]:
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
    verdict = "good" if is_good(found, allowed) else "WRONG"
    count = counted(len(found), "direction")
    last = f"{count}, at worst {worst:.1e} apart, allowed {allowed:g}"
    lines = [
        *aligned([HEADINGS, *rows]),
        f"learn {fit_problem}: derivatives are {verdict}: {last}",
    ]
    if verdict == "good" and worst > allowed:
        lines.append(
            "finite differences are not more accurate here: the motion is too "
            "sensitive for any step size"
        )
    return lines
